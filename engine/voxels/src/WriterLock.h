#pragma once

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::voxels {

/// An empty file that only one process writes: locked until this is destroyed. What an earlier
/// process left there is emptied; what another is writing is not touched.
class WriterLock {
public:
    /// @param path  of the file, which is made if there is none
    /// @param asked  its later name, for messages
    /// Fails with `inputOutput`.
    static core::Result<WriterLock>
    take(const std::filesystem::path& path, const std::filesystem::path& asked);

    WriterLock(WriterLock&& other) noexcept;
    WriterLock& operator=(WriterLock&&) = delete;
    WriterLock(const WriterLock&) = delete;
    WriterLock& operator=(const WriterLock&) = delete;
    ~WriterLock();

private:
    explicit WriterLock(int descriptor) : _descriptor(descriptor) {}
    int _descriptor;
};

} // namespace isofront::voxels

#pragma once

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::voxels {

/// An empty file, or a folder, that only one process writes: locked until this is destroyed. What
/// an earlier process left in a file is gone, what it left in a folder is there; what another
/// process is writing is not touched.
class WriterLock {
public:
    /// @param path  of the file, which is made if there is none
    /// @param asked  its later name, for messages
    /// Fails with `inputOutput`.
    static core::Result<WriterLock>
    take(const std::filesystem::path& path, const std::filesystem::path& asked);

    /// The same for a folder.
    static core::Result<WriterLock>
    takeFolder(const std::filesystem::path& path, const std::filesystem::path& asked);

    WriterLock(WriterLock&& other) noexcept;
    WriterLock& operator=(WriterLock&&) = delete;
    WriterLock(const WriterLock&) = delete;
    WriterLock& operator=(const WriterLock&) = delete;
    ~WriterLock();

private:
    static core::Result<WriterLock>
    take(const std::filesystem::path& path, const std::filesystem::path& asked, bool isFolder);
    explicit WriterLock(int descriptor) : _descriptor(descriptor) {}
    int _descriptor;
};

} // namespace isofront::voxels

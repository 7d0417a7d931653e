#pragma once

#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>

namespace isofront::voxels {

/// A nameless file for what doesn't fit into memory. It is gone with the process, however that
/// ends.
///
/// Thread: any number at once.
class ScratchFile {
public:
    /// @param folder  where; empty for the system's folder for such
    static core::Result<ScratchFile> create(const std::filesystem::path& folder);

    ScratchFile(ScratchFile&& other) noexcept;
    ScratchFile& operator=(ScratchFile&&) = delete;
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    ~ScratchFile();

    /// @return where it begins, or `inputOutput`
    core::Result<std::uint64_t> append(std::span<const std::byte> bytes);
    /// Reads what was appended.
    std::optional<core::Error> read(std::uint64_t offset, std::span<std::byte> bytes) const;
    /// Of all that was appended. Thread: not while something is.
    [[nodiscard]] std::uint64_t bytes() const { return _end; }

private:
    explicit ScratchFile(int descriptor, std::filesystem::path folder);
    [[nodiscard]] core::Error error(const char* what, int number) const;

    int _descriptor;
    std::filesystem::path _folder;
    std::mutex _mutex;
    std::uint64_t _end = 0;
};

} // namespace isofront::voxels

#pragma once

#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::exchange {

/// A file that appears under its name only when it is whole.
///
/// It is written beside its target under a temporary name (`.NAME.PID-N.part`), flushed to the disk
/// and renamed by `commit`. Until then a file that was there stays as it was; destroyed without a
/// commit, this one leaves nothing behind. Only a process that is killed outright leaves the
/// temporary file. A link is followed; a pipe or a device is written directly.
///
/// Thread: one at a time.
class OutputFile {
public:
    /// Fails with `inputOutput` if the folder is missing or not writable, or the name is a
    /// folder's.
    static core::Result<OutputFile> create(const std::filesystem::path& path);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&& other) noexcept;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    /// Appends. After a failure everything written is dropped, and `commit` tells why: writers need
    /// not check each call, and long ones can stop early by asking `failed`.
    void write(std::span<const std::byte> bytes);
    void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
    [[nodiscard]] bool failed() const { return _errorNumber != 0; }

    /// Flushes to the disk and gives the file its name.
    /// @return how long it is [bytes], or an `inputOutput` failure; then the old file is still
    /// there.
    core::Result<std::uint64_t> commit();

    /// Where the bytes are until `commit`, for a program that writes them itself.
    [[nodiscard]] const std::filesystem::path& temporaryPath() const { return _temporary; }
    /// Whether the bytes go straight to a pipe or a device.
    [[nodiscard]] bool isDirect() const { return _temporary.empty(); }

private:
    OutputFile() = default;
    void flush();
    void discard();
    [[nodiscard]] core::Error error(const std::string& what, int errorNumber) const;

    std::filesystem::path _asked;     ///< as the caller named it, for messages
    std::filesystem::path _target;    ///< with links followed
    std::filesystem::path _temporary; ///< empty if written directly
    std::vector<std::byte> _buffer;
    std::uint64_t _written = 0;
    int _descriptor = -1;
    int _errorNumber = 0; ///< of the first write that failed
};

/// Writes a whole file at once, by the same rule.
core::Result<std::uint64_t> writeFile(const std::filesystem::path& path, std::string_view content);

} // namespace isofront::exchange

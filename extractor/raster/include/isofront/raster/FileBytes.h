#pragma once

#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace isofront::raster {

/// Fails with inputOutput unless the path names a regular file that can be opened, and with badData
/// if the file is empty. The message doesn't name the file. Thread: any.
core::Result<void> checkReadable(const std::filesystem::path& path);

/// All bytes of a file, unpacked if it is gzipped (by content, not by name).
///
/// Errors: inputOutput for what can't be read; badData for gzip data that are damaged or cut short;
/// `whenMore` for more than `mostBytes` once unpacked: the message then says how many were expected
/// at most. Takes at most about twice `mostBytes` of memory. Thread: any.
core::Result<std::vector<std::byte>> readFileBytes(
    const std::filesystem::path& path,
    std::uint64_t mostBytes,
    core::ErrorCode whenMore = core::ErrorCode::badData);

} // namespace isofront::raster

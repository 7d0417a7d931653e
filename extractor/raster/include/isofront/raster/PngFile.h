#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace isofront::raster {

/// A grey picture with the numbers of its file: rows from the top, no gamma applied.
struct GreyPicture {
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    int bits = 16;  ///< 1 to 16 of each value
    std::vector<std::uint16_t> values;
};

/// Reads a PNG of one channel, as numbers.
///
/// Errors, which don't name the file: inputOutput for what can't be read; badData for what is no
/// PNG, damaged, or has colours or opacity; resourceLimit if its values take more than
/// `memoryLimit` bytes. The size is held against the length of the file before memory is taken.
/// Thread: any.
core::Result<GreyPicture> readGreyPng(const std::filesystem::path& path, std::uint64_t memoryLimit);

} // namespace isofront::raster

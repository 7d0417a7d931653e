#pragma once

#include <isofront/core/Image.h>
#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>

namespace isofront::exchange {

/// Writes a picture as an 8-bit sRGB PNG, whole or not at all (see OutputFile). Pictures that are
/// opaque everywhere are stored without opacity.
///
/// @return the file's length [bytes]; `usage` for an image without pixels or whose bytes don't
/// match
///         its size, `inputOutput` for the disk. Thread: any.
core::Result<std::uint64_t> writePng(const core::Image& image, const std::filesystem::path& path);

/// Reads any PNG (grey, palette, 16 bits, interlaced, with or without opacity) as 8-bit sRGB.
///
/// Fails with `inputOutput` if the file can't be read, `badData` if it is not a PNG or is damaged,
/// `resourceLimit` if it has more than 2^28 pixels. Thread: any.
core::Result<core::Image> readPng(const std::filesystem::path& path);

} // namespace isofront::exchange

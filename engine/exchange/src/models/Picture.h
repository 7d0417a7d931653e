#pragma once

#include <isofront/core/Image.h>
#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace isofront::exchange {

/// A PNG or JPEG picture, by what it begins with. Of 16 bits a channel, the upper 8 are kept.
///
/// Fails with `badData` for what is damaged or of another kind, `resourceLimit` if it says that it
/// has more pixels than there may be, before memory is taken. Messages don't name the picture.
/// @param mostBytes  of the pixels
core::Result<core::Image> decodePicture(std::span<const std::byte> bytes, std::uint64_t mostBytes);

/// The same from a file, whose name messages begin with.
core::Result<core::Image> readPicture(const std::filesystem::path& path, std::uint64_t mostBytes);

} // namespace isofront::exchange

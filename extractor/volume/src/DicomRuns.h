#pragma once

#include <isofront/core/Result.h>

#include <cstddef>
#include <span>

namespace isofront::volume {

/// Unpacks pixels that DICOM keeps as runs of bytes (RLE Lossless, 1.2.840.10008.1.2.5).
/// @param packed  the one fragment of a frame
/// @param bytesOfPixel  1 to 4
/// @param into  all pixels, lowest byte first: a multiple of `bytesOfPixel`
/// Errors: badData for anything that doesn't come to exactly so many bytes.
/// Source: DICOM PS3.5, Annex G.
core::Result<void>
unpackDicomRuns(std::span<const char> packed, std::size_t bytesOfPixel, std::span<char> into);

} // namespace isofront::volume

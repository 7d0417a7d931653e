#pragma once

#include "DenseVoxels.h"
#include "FileHeader.h"

#include <isofront/core/Result.h>

#include <vector>

namespace isofront::volume {

/// Reads the numbers that a header describes, plain or gzipped: `header.dataFile` from
/// `header.dataOffset` (or, gzipped, from `header.unpackedOffset` of what it unpacks to).
/// @param header  one that `checkHeader` has passed
/// Errors: inputOutput for what can't be read, badData for data that are damaged or cut short.
core::Result<VoxelArray> readRawNumbers(
    const FileHeader& header,
    raster::SampleType type,
    bool bigEndian,
    std::vector<std::string>& notes);

} // namespace isofront::volume

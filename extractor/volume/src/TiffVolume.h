#pragma once

#include "DenseVoxels.h"

#include <isofront/core/Result.h>

#include <filesystem>
#include <string>

namespace isofront::volume {

/// True if the first name comes before the second where runs of digits are compared as numbers:
/// slice2 before slice10.
bool comesNaturallyBefore(const std::string& first, const std::string& second);

/// Reads a TIFF file with many pages, or a folder of TIFF files in the natural order of their
/// names, as the slices of a volume, from low z to high.
core::Result<DenseVoxels>
readTiffVolume(const std::filesystem::path& path, const LoadOptions& options);

} // namespace isofront::volume

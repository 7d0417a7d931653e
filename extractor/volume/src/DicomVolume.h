#pragma once

#include "DenseVoxels.h"

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::volume {

/// Reads a series of slices from a folder of DICOM files.
core::Result<DenseVoxels>
readDicomFolder(const std::filesystem::path& folder, const LoadOptions& options);

} // namespace isofront::volume

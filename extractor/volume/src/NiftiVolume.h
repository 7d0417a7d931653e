#pragma once

#include "DenseVoxels.h"

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::volume {

/// Reads NIfTI-1 and NIfTI-2 in one file, plain or gzipped, in either byte order. World coordinates
/// are LPS: those of the sform if the file has one, else of the qform, else of the voxel sizes.
core::Result<DenseVoxels>
readNiftiVolume(const std::filesystem::path& path, const LoadOptions& options);

} // namespace isofront::volume

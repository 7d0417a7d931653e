#pragma once

#include "SourceArguments.h"

#include <isofront/core/Result.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <cstdint>
#include <optional>

namespace isofront::cli {

/// What the user says about the voxels of a field or a volume.
struct FieldVoxelOptions {
    std::uint32_t resolution = 0; ///< 0 for the source's own voxels or posts
    std::optional<double> isovalue;
    double filter = 0.5;
    bool closed = false;
};

/// How a source is voxelised. A procedural one has `resolution` voxels along its domain, from its
/// corner on. One with voxels or posts of its own has a voxel around each of them, or as many along
/// its longest edge as there are to be; where its axes lie askew, or their spacings differ, voxels
/// are cubes in the world all the same, by default of the least spacing.
/// Errors: usage for a resolution that is missing or too small for the source.
core::Result<voxels::FieldVoxelizationSettings>
fieldVoxelSettings(const Source& source, const FieldVoxelOptions& options);

} // namespace isofront::cli

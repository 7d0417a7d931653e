#pragma once

#include "Console.h"
#include "SourceArguments.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <memory>
#include <stop_token>
#include <string>

namespace isofront::cli {

/// The voxels that stand for a source in the distance: a stored model of it, or made now and kept
/// in memory, without colours, as the meshes beside them have none.
/// @param text      a number of voxels along the longest edge, or the path of a model
/// @param isovalue  in the source's own units
/// @param filter    strength of the low-pass filter, as of the meshes
/// @return usage for a number out of range and for a model that lies elsewhere; what opening a
/// model
///         and voxelising a field say; interrupted
core::Result<std::shared_ptr<const voxels::ChunkStore>> openFarField(
    const std::string& text,
    const Source& source,
    double isovalue,
    double filter,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop);

} // namespace isofront::cli

#pragma once

#include "VoxelStore.h"

#include <isofront/core/Result.h>

#include <span>
#include <vector>

namespace isofront::render {

/// The chunks that a scene shows or tests, wherever they come from; `usage` if one isn't on the
/// device, or the scene contradicts itself.
core::Result<std::vector<PlacedChunk>> chunksOf(const VoxelStore& store, const VoxelScene& shown);

/// Chunks that a streamer has placed; `usage` if one lies outside the store.
core::Result<std::vector<PlacedChunk>> placedIn(
    const VoxelStore& store,
    std::span<const voxels::ChunkDraw> draws,
    const voxels::ChunkTree& tree);

} // namespace isofront::render

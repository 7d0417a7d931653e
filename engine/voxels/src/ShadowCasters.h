#pragma once

#include <isofront/voxels/ChunkStreamer.h>

#include <functional>
#include <vector>

namespace isofront::voxels {

/// Adds what of a model casts shadows: every place of it that may be seen from the sun once, in the
/// coarsest level whose voxels fit into a texel, or the finest one that is there. What isn't there
/// is left to the chunk above it, octant by octant.
/// @param isThere  where it is false of a chunk, those below don't count either
/// @param sun      as ChunkStreamer::casters
void castersInto(
    const ChunkTree& tree,
    const std::function<bool(ChunkIndex)>& isThere,
    const ChunkView& sun,
    double texel,
    std::vector<ChunkDraw>& casters);

} // namespace isofront::voxels

#pragma once

#include "WeightedVoxel.h"

#include <isofront/voxels/Chunk.h>

namespace isofront::voxels {

/// The colour of a sum, as in Chunk::colours.
/// @param area  that the sum was taken over
std::uint32_t colourOf(const WeightedColour& sum, float area);

/// Voxels in the form in which they are kept: means in place of sums, and those faces apart that
/// look different from their voxel's mean. Voxels whose faces look the same share what is kept of
/// them.
Chunk stored(const ChunkKey& key, const VoxelList& list, bool coloured);

} // namespace isofront::voxels

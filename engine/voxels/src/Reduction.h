#pragma once

#include "WeightedVoxel.h"

#include <array>

namespace isofront::voxels {

/// The voxels of a chunk from those of its eight children: one for each cube of two by two by two
/// that holds any, with all faces that they show and the mean of their attributes. Each contains
/// its children, so that nothing vanishes.
///
/// Children are in order already, so rows are merged, not sorted. The sums are taken in the order
/// of children, so the result is the same wherever it is computed. Where the children of one are
/// turned to different sides, each face keeps the mean of those that show it.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 3, "Level of detail". Differs: they sort.
///
/// @param children  in the order of ChunkKey::child; null where there is none
VoxelList reduced(const std::array<const VoxelList*, 8>& children);

} // namespace isofront::voxels

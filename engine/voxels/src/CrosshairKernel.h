#pragma once

#include "LatticeTriangle.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// A voxel, from a range's lowest on.
using RangePlace = std::array<std::int32_t, 3>;

/// Whether a triangle is one for `addCrosshairs`: its edges are shorter than 16 voxels along each
/// axis, so that all numbers are exact.
bool hasSmallCrosshairs(const LatticeTriangle& triangle);

/// Adds the voxels whose crosshair a small triangle meets, once for each crossing: what
/// `forEachCrosshair` finds, for several rows at a time. All instruction sets give the same.
void addCrosshairs(
    const LatticeTriangle& triangle, const VoxelRange& within, std::vector<RangePlace>& hits);

} // namespace isofront::voxels

#pragma once

#include "LatticeTriangle.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::voxels {

/// Bits of a coordinate in a place that a crosshair is met at.
inline constexpr unsigned kPlaceBits = 10;
/// Edges of triangles for `findCrosshairs` are shorter than this along each axis [voxels].
inline constexpr std::size_t kSmallEdge = 16;
/// Places of voxels from a range's lowest on: x, y and z, kPlaceBits each, x lowest. There is room
/// for all that a small triangle meets, and for what is written in passing.
using CrosshairHits = std::array<std::int32_t, 3 * kSmallEdge * kSmallEdge + 16>;

/// Whether a triangle is one for `findCrosshairs`, so that all numbers are exact.
bool hasSmallCrosshairs(const LatticeTriangle& triangle);

/// Finds the voxels whose crosshair a small triangle meets, once for each crossing: what
/// `forEachCrosshair` finds, for several rows at a time. All instruction sets give the same.
///
/// @param within  at most 2^kPlaceBits voxels along each axis
/// @return how many hits there are
std::size_t
findCrosshairs(const LatticeTriangle& triangle, const VoxelRange& within, CrosshairHits& hits);

} // namespace isofront::voxels

#pragma once

#include "LatticeTriangle.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// The part of a triangle that lies in a voxel.
struct TrianglePart {
    std::array<std::int32_t, 3> voxel{}; ///< from the range's lowest on
    double area = 0;      ///< [faces of a voxel]; 0 where the triangle only touches it
    glm::dvec3 offset{0}; ///< of its centroid from the triangle's first corner [voxels]
};

/// Who holds as much of a triangle touches it, whatever rounding does.
inline constexpr double kSurelyTouched = 1e-6;

/// Adds the parts of a triangle: of all voxels that it touches, and perhaps of some that it only
/// comes close to, whose areas are below kSurelyTouched. Areas may be a rounding error below 0.
///
/// Seen along the axis along which it is least steep, a triangle is a polygon in each layer of
/// voxels, and a polygon's part in a square of a row is the difference of what lies beyond two
/// lines: a sum over its edges in that row. So nothing is cut into polygons of its own, and the
/// work is that of edges in rows, several of which are looked at together. All instruction sets
/// give the same bits.
///
/// @param within     as for forEachTouched
/// @param centroids  whether to set the offsets, of those with larger areas
void divideTriangle(
    const LatticeTriangle& triangle,
    const VoxelRange& within,
    bool centroids,
    std::vector<TrianglePart>& parts);

} // namespace isofront::voxels

#pragma once

#include "ClosestPoint.h"
#include "CubeContact.h"
#include "LatticeTriangle.h"
#include "TriangleKernel.h"

#include <algorithm>
#include <vector>

namespace isofront::voxels {

/// The point of a triangle nearest to a voxel's middle, from its first corner on [voxels]: where
/// it touches the voxel, if it hardly does.
inline glm::dvec3 touchedNear(const LatticeTriangle& triangle, const LatticePoint& voxel)
{
    const auto from0 = [&](const LatticePoint& to) {
        glm::dvec3 offset(0);
        for (std::size_t axis = 0; axis < 3; ++axis)
            offset[static_cast<glm::length_t>(axis)] =
                static_cast<double>(to[axis] - triangle[0][axis]) / static_cast<double>(kSteps);
        return offset;
    };
    LatticePoint middle{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        middle[axis] = voxel[axis] * kSteps + kSteps / 2;
    return closestPoint(from0(triangle[1]), from0(triangle[2]), from0(middle));
}

/// Divides a triangle among the voxels that it touches: exactly those whose cubes, borders
/// included, it meets, once each. The parts' areas add up to the triangle's to within rounding;
/// what lies between two voxels counts in the upper one.
///
/// Numbers are rounded, but where that could decide who is touched, integers do.
///
/// @param within      other voxels are left out; at most some thousands along an axis
/// @param centroids   whether the offsets of parts are needed
/// @param candidates  scratch
/// @param body        called with (x, y, z, TrianglePart)
template <typename Body>
void forEachTouched(
    const LatticeTriangle& triangle,
    const VoxelRange& within,
    bool centroids,
    std::vector<TrianglePart>& candidates,
    const Body& body)
{
    candidates.clear();
    divideTriangle(triangle, within, centroids, candidates);
    for (TrianglePart& part : candidates) {
        const LatticePoint voxel{
            within.low[0] + part.voxel[0],
            within.low[1] + part.voxel[1],
            within.low[2] + part.voxel[2]};
        // rounding doesn't come near to what surely is an area
        if (part.area < kSurelyTouched) {
            if (!touches(triangle, voxel))
                continue;
            part.area = std::max(part.area, 0.0);
            if (centroids)
                part.offset = touchedNear(triangle, voxel);
        }
        body(voxel[0], voxel[1], voxel[2], part);
    }
}

} // namespace isofront::voxels

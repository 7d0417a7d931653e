#pragma once

#include "LatticeTriangle.h"

#include <cstddef>

namespace isofront::voxels {

/// Whether a triangle meets a voxel's cube, its border included. Exact, in integers; triangles that
/// are lines or points meet cubes, too.
///
/// By projections onto the thirteen lines across which two such shapes can be told apart.
/// Source: T. Akenine-Möller, "Fast 3D triangle-box overlap testing" (2001).
inline bool touches(const LatticeTriangle& triangle, const LatticePoint& voxel)
{
    // from the cube's middle, in half steps, so that it lies on the lattice
    constexpr std::int64_t kReach = kSteps;
    LatticeTriangle p{};
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[corner][axis] = 2 * triangle[corner][axis] - (2 * voxel[axis] + 1) * kSteps;
    const auto size = [](std::int64_t x) { return x < 0 ? -x : x; };
    const auto isApart = [](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t reach) {
        return (a > reach && b > reach && c > reach) || (a < -reach && b < -reach && c < -reach);
    };

    for (std::size_t axis = 0; axis < 3; ++axis)
        if (isApart(p[0][axis], p[1][axis], p[2][axis], kReach))
            return false;
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // across an edge of the triangle and one of the cube
            const std::size_t u = (axis + 1) % 3;
            const std::size_t v = (axis + 2) % 3;
            const LatticePoint& from = p[corner];
            const LatticePoint& to = p[(corner + 1) % 3];
            const std::int64_t du = to[u] - from[u];
            const std::int64_t dv = to[v] - from[v];
            const auto along = [&](const LatticePoint& q) { return du * q[v] - dv * q[u]; };
            if (isApart(along(p[0]), along(p[1]), along(p[2]), kReach * (size(du) + size(dv))))
                return false;
        }
    const std::array<std::int64_t, 3> normal = doubleArea(triangle);
    Wide distance = 0;
    Wide reach = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        distance += static_cast<Wide>(normal[axis]) * p[0][axis];
        reach += static_cast<Wide>(size(normal[axis])) * kReach;
    }
    return distance <= reach && distance >= -reach;
}

} // namespace isofront::voxels

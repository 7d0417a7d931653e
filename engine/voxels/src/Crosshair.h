#pragma once

#include "LatticeTriangle.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::voxels {

namespace crosshair {

/// Turns heights that are given in steps times an area into voxels.
class Division {
public:
    explicit Division(std::int64_t area)
        : _area(area), _inverse(1 / (static_cast<double>(area) * static_cast<double>(kSteps)))
    {
    }
    [[nodiscard]] std::int64_t floor(Wide height) const
    {
        return static_cast<std::int64_t>(
            floorDivide<Wide>(height, static_cast<Wide>(_area) * kSteps));
    }
    /// For an area below 2^37: an estimate that is off by one at most, put right by what remains.
    [[nodiscard]] std::int64_t floor(std::int64_t height) const
    {
        const std::int64_t divisor = _area * kSteps;
        const auto estimate = static_cast<std::int64_t>(static_cast<double>(height) * _inverse);
        const std::int64_t rest = height - estimate * divisor;
        return estimate + (rest < 0 ? -1 : rest >= divisor ? 1 : 0);
    }

private:
    std::int64_t _area;
    double _inverse;
};

} // namespace crosshair

/// The voxels whose crosshair a triangle meets: the three segments along the axes through the
/// middle, from face to face. For a closed surface they are its six-separating voxels.
///
/// Exact, in integers: an axis-parallel line through the middles of voxels that meets an edge or a
/// corner is given to one of the triangles there, so that it enters a closed surface as often as it
/// leaves; a hit between two voxels belongs to the upper one.
///
/// Source: S. Laine, "A topological approach to voxelization" (2013), section 4.
///
/// @param within  other voxels are left out
/// @param hit     called with (x, y, z, axis of the segment) for each crossing
template <typename Hit>
void forEachCrosshair(const LatticeTriangle& triangle, const VoxelRange& within, const Hit& hit)
{
    const std::array<std::int64_t, 3> area = doubleArea(triangle);
    // the voxels whose middles the triangle's box holds, along each axis
    LatticeTriangle corners{}; // from the range's corner on
    VoxelRange range;
    bool isSmall = true; // whether products fit into 64 bits
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t corner = 0; corner < 3; ++corner)
            corners[corner][axis] = triangle[corner][axis] - within.low[axis] * kSteps;
        const auto [least, most] =
            std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
        constexpr std::int64_t kReach = std::int64_t{1} << 21U;
        constexpr std::int64_t kLargest = std::int64_t{1} << 37U;
        isSmall = isSmall && least > -kReach && most < kReach && area[axis] > -kLargest &&
                  area[axis] < kLargest;
        range.low[axis] = std::max<std::int64_t>(floorDivide(least + kSteps / 2 - 1, kSteps), 0);
        range.high[axis] = std::min(
            floorDivide(most - kSteps / 2, kSteps) + 1, within.high[axis] - within.low[axis]);
    }
    for (std::size_t w = 0; w < 3; ++w) {
        const std::size_t u = (w + 1) % 3;
        const std::size_t v = (w + 2) % 3;
        if (area[w] == 0 || range.low[u] >= range.high[u])
            continue; // seen edge on, or between lines
        // counter-clockwise as seen along w
        const LatticePoint& a = corners[0];
        const LatticePoint& b = corners[area[w] > 0 ? 1 : 2];
        const LatticePoint& c = corners[area[w] > 0 ? 2 : 1];

        struct Edge {
            std::int64_t du, dv, value;
        };
        const auto edge = [&](const LatticePoint& from, const LatticePoint& to) {
            const std::int64_t du = to[u] - from[u];
            const std::int64_t dv = to[v] - from[v];
            const std::int64_t middleU = range.low[u] * kSteps + kSteps / 2;
            const std::int64_t middleV = range.low[v] * kSteps + kSteps / 2;
            // what lies on the edge belongs to one of its two sides
            const std::int64_t owned = dv > 0 || (dv == 0 && du < 0) ? 0 : -1;
            return Edge{du, dv, du * (middleV - from[v]) - dv * (middleU - from[u]) + owned};
        };
        std::array<Edge, 3> row{edge(a, b), edge(b, c), edge(c, a)};
        const std::int64_t size = area[w] > 0 ? area[w] : -area[w];
        const std::int64_t slopeU = area[w] > 0 ? area[u] : -area[u];
        const std::int64_t slopeV = area[w] > 0 ? area[v] : -area[v];
        const crosshair::Division division(size);
        for (std::int64_t j = range.low[v]; j < range.high[v]; ++j) {
            std::int64_t e0 = row[0].value;
            std::int64_t e1 = row[1].value;
            std::int64_t e2 = row[2].value;
            for (std::int64_t i = range.low[u]; i < range.high[u]; ++i) {
                if ((e0 | e1 | e2) >= 0) {
                    // where the line meets the plane: area . (p - a) = 0
                    const std::int64_t fromU = i * kSteps + kSteps / 2 - a[u];
                    const std::int64_t fromV = j * kSteps + kSteps / 2 - a[v];
                    const std::int64_t k =
                        isSmall ? division.floor(a[w] * size - slopeU * fromU - slopeV * fromV)
                                : division.floor(
                                      static_cast<Wide>(a[w]) * size -
                                      static_cast<Wide>(slopeU) * fromU -
                                      static_cast<Wide>(slopeV) * fromV);
                    if (k >= 0 && k < within.high[w] - within.low[w]) {
                        LatticePoint voxel{};
                        voxel[u] = within.low[u] + i;
                        voxel[v] = within.low[v] + j;
                        voxel[w] = within.low[w] + k;
                        hit(voxel[0], voxel[1], voxel[2], w);
                    }
                }
                e0 -= row[0].dv * kSteps;
                e1 -= row[1].dv * kSteps;
                e2 -= row[2].dv * kSteps;
            }
            for (Edge& e : row)
                e.value += e.du * kSteps;
        }
    }
}

} // namespace isofront::voxels

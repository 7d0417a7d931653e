#pragma once

#include "LatticeTriangle.h"

namespace isofront::voxels {

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
    const VoxelRange range = intersection(voxelsOf(triangle), within);
    if (isEmpty(range))
        return;
    for (std::size_t w = 0; w < 3; ++w) {
        if (area[w] == 0)
            continue; // seen edge on
        const std::size_t u = (w + 1) % 3;
        const std::size_t v = (w + 2) % 3;
        // counter-clockwise as seen along w
        const LatticePoint& a = triangle[0];
        const LatticePoint& b = triangle[area[w] > 0 ? 1 : 2];
        const LatticePoint& c = triangle[area[w] > 0 ? 2 : 1];

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
        for (std::int64_t j = range.low[v]; j < range.high[v]; ++j) {
            std::int64_t e0 = row[0].value;
            std::int64_t e1 = row[1].value;
            std::int64_t e2 = row[2].value;
            for (std::int64_t i = range.low[u]; i < range.high[u]; ++i) {
                if ((e0 | e1 | e2) >= 0) {
                    // where the line meets the plane: area . (p - a) = 0
                    const Wide along =
                        static_cast<Wide>(slopeU) * (i * kSteps + kSteps / 2 - a[u]) +
                        static_cast<Wide>(slopeV) * (j * kSteps + kSteps / 2 - a[v]);
                    const Wide place = static_cast<Wide>(a[w]) * size - along; // times `size`
                    const auto k = static_cast<std::int64_t>(
                        floorDivide<Wide>(place, static_cast<Wide>(size) * kSteps));
                    if (k >= within.low[w] && k < within.high[w]) {
                        std::array<std::int64_t, 3> voxel{};
                        voxel[u] = i;
                        voxel[v] = j;
                        voxel[w] = k;
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

#include "CrosshairKernel.h"

#include <algorithm>
#include <cstddef>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "CrosshairKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::voxels::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Rows = hn::CappedTag<double, 4>;
constexpr auto kEdge = static_cast<double>(kSteps);

/// An edge of the triangle as seen along an axis. Its value at a voxel's middle is above zero on
/// its inner side: a whole number and a half, as what lies on the edge belongs to one side.
struct Edge {
    double value = 0;     ///< at the lowest column and row
    double perRow = 0;    ///< what it grows by
    double perColumn = 0; ///< what it shrinks by
};

} // namespace

std::size_t
findCrosshairsOn(const LatticeTriangle& triangle, const VoxelRange& within, CrosshairHits& hits)
{
    const Rows d;
    const hn::Rebind<std::int32_t, Rows> ints;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const std::array<std::int64_t, 3> area = doubleArea(triangle);
    // the voxels whose middles the triangle's box holds, along each axis
    VoxelRange range;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, most] =
            std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
        range.low[axis] = std::max(floorDivide(least + kSteps / 2 - 1, kSteps), within.low[axis]);
        range.high[axis] = std::min(floorDivide(most - kSteps / 2, kSteps) + 1, within.high[axis]);
    }
    std::size_t count = 0;
    for (std::size_t w = 0; w < 3; ++w) {
        const std::size_t u = w < 2 ? w + 1 : 0;
        const std::size_t v = w > 0 ? w - 1 : 2;
        if (area[w] == 0 || range.low[u] >= range.high[u] || range.low[v] >= range.high[v])
            continue; // seen edge on, or between lines
        const std::int64_t middleU = range.low[u] * kSteps + kSteps / 2;
        const std::int64_t middleV = range.low[v] * kSteps + kSteps / 2;
        const std::int64_t turn = area[w] > 0 ? 1 : -1; // clockwise ones are turned
        std::array<Edge, 3> edges;
        for (std::size_t i = 0; i < 3; ++i) {
            const LatticePoint& from = triangle[i];
            const LatticePoint& to = triangle[i < 2 ? i + 1 : 0];
            const std::int64_t du = turn * (to[u] - from[u]);
            const std::int64_t dv = turn * (to[v] - from[v]);
            const bool isOwned = dv > 0 || (dv == 0 && du < 0);
            edges[i].value =
                static_cast<double>(du * (middleV - from[v]) - dv * (middleU - from[u])) +
                (isOwned ? 0.5 : -0.5);
            edges[i].perRow = static_cast<double>(du) * kEdge;
            edges[i].perColumn = static_cast<double>(dv) * kEdge;
        }
        // where the line meets the plane, times the area: area . (p - a) = 0
        const LatticePoint& a = triangle[0];
        const auto sign = static_cast<double>(turn);
        const double size = sign * static_cast<double>(area[w]);
        const double slopeU = sign * static_cast<double>(area[u]);
        const double slopeV = sign * static_cast<double>(area[v]);
        const double height = static_cast<double>(a[w] - within.low[w] * kSteps) * size -
                              slopeU * static_cast<double>(middleU - a[u]) -
                              slopeV * static_cast<double>(middleV - a[v]);
        const auto divisor = hn::Set(d, size * kEdge);
        const auto layers = hn::Set(d, static_cast<double>(within.high[w] - within.low[w]));
        const auto unit = [](std::size_t axis) {
            return static_cast<double>(1U << kPlaceBits * axis);
        };

        for (std::int64_t row = range.low[v]; row < range.high[v]; row += lanes) {
            const auto rows =
                hn::Add(hn::Set(d, static_cast<double>(row - range.low[v])), hn::Iota(d, 0.0));
            const auto isRow =
                hn::Lt(rows, hn::Set(d, static_cast<double>(range.high[v] - range.low[v])));
            const auto begin = [&](const Edge& edge) {
                return hn::Add(hn::Set(d, edge.value), hn::Mul(hn::Set(d, edge.perRow), rows));
            };
            auto value0 = begin(edges[0]);
            auto value1 = begin(edges[1]);
            auto value2 = begin(edges[2]);
            auto at = hn::Sub(hn::Set(d, height), hn::Mul(hn::Set(d, slopeV * kEdge), rows));
            auto place = hn::Add(
                hn::Set(d, static_cast<double>(range.low[u] - within.low[u]) * unit(u)),
                hn::Mul(
                    hn::Add(rows, hn::Set(d, static_cast<double>(range.low[v] - within.low[v]))),
                    hn::Set(d, unit(v))));
            for (std::int64_t column = range.low[u]; column < range.high[u]; ++column) {
                const auto least = hn::Min(hn::Min(value0, value1), value2);
                const auto isInside = hn::And(isRow, hn::Gt(least, hn::Zero(d)));
                if (!hn::AllFalse(d, isInside)) {
                    const auto layer = hn::Floor(hn::Div(at, divisor));
                    const auto isWithin =
                        hn::And(hn::Ge(layer, hn::Zero(d)), hn::Lt(layer, layers));
                    const auto isHit = hn::And(isInside, isWithin);
                    const auto found = hn::Add(place, hn::Mul(layer, hn::Set(d, unit(w))));
                    const auto hit =
                        hn::DemoteTo(ints, hn::IfThenElse(isHit, found, hn::Set(d, -1.0)));
                    // into a register first, as some processors compress into memory slowly
                    const auto isPlace = hn::Gt(hit, hn::Set(ints, -1));
                    hn::StoreU(hn::Compress(hit, isPlace), ints, hits.data() + count);
                    count += hn::CountTrue(ints, isPlace);
                }
                value0 = hn::Sub(value0, hn::Set(d, edges[0].perColumn));
                value1 = hn::Sub(value1, hn::Set(d, edges[1].perColumn));
                value2 = hn::Sub(value2, hn::Set(d, edges[2].perColumn));
                at = hn::Sub(at, hn::Set(d, slopeU * kEdge));
                place = hn::Add(place, hn::Set(d, unit(u)));
            }
        }
    }
    return count;
}

} // namespace isofront::voxels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::voxels {

HWY_EXPORT(findCrosshairsOn);

bool hasSmallCrosshairs(const LatticeTriangle& triangle)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, most] =
            std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
        if (most - least >= static_cast<std::int64_t>(kSmallEdge) * kSteps)
            return false;
    }
    return true;
}

std::size_t
findCrosshairs(const LatticeTriangle& triangle, const VoxelRange& within, CrosshairHits& hits)
{
    return HWY_DYNAMIC_DISPATCH(findCrosshairsOn)(triangle, within, hits);
}

} // namespace isofront::voxels
#endif

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
constexpr std::size_t kMostLanes = 4;
constexpr auto kEdge = static_cast<double>(kSteps);
/// More columns than a small triangle has.
constexpr double kManyColumns = 64;

/// An edge of the triangle as seen along an axis. Its value at a voxel's middle is not negative on
/// its inner side: a whole number and a half, as what lies on the edge belongs to one side.
struct Edge {
    double value = 0;     ///< at the lowest column and row
    double perRow = 0;    ///< what it grows by
    double perColumn = 0; ///< what it shrinks by
};

} // namespace

void addCrosshairsOn(
    const LatticeTriangle& triangle, const VoxelRange& within, std::vector<RangePlace>& hits)
{
    const Rows d;
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
    for (std::size_t w = 0; w < 3; ++w) {
        const std::size_t u = (w + 1) % 3;
        const std::size_t v = (w + 2) % 3;
        if (area[w] == 0 || range.low[u] >= range.high[u] || range.low[v] >= range.high[v])
            continue; // seen edge on, or between lines
        const std::int64_t middleU = range.low[u] * kSteps + kSteps / 2;
        const std::int64_t middleV = range.low[v] * kSteps + kSteps / 2;
        // counter-clockwise as seen along w
        const std::array<std::size_t, 4> turn{
            0, area[w] > 0 ? std::size_t{1} : 2, area[w] > 0 ? std::size_t{2} : 1, 0};
        std::array<Edge, 3> edges;
        for (std::size_t i = 0; i < 3; ++i) {
            const LatticePoint& from = triangle[turn[i]];
            const LatticePoint& to = triangle[turn[i + 1]];
            const std::int64_t du = to[u] - from[u];
            const std::int64_t dv = to[v] - from[v];
            const bool isOwned = dv > 0 || (dv == 0 && du < 0);
            edges[i].value =
                static_cast<double>(du * (middleV - from[v]) - dv * (middleU - from[u])) +
                (isOwned ? 0.5 : -0.5);
            edges[i].perRow = static_cast<double>(du) * kEdge;
            edges[i].perColumn = static_cast<double>(dv) * kEdge;
        }
        // where the line meets the plane, times the area: area . (p - a) = 0
        const LatticePoint& a = triangle[0];
        const double sign = area[w] > 0 ? 1 : -1;
        const double size = sign * static_cast<double>(area[w]);
        const double slopeU = sign * static_cast<double>(area[u]);
        const double slopeV = sign * static_cast<double>(area[v]);
        const std::int64_t lowest = floorDivide(a[w], kSteps);
        const double height = static_cast<double>(a[w] - lowest * kSteps) * size -
                              slopeU * static_cast<double>(middleU - a[u]) -
                              slopeV * static_cast<double>(middleV - a[v]);

        const std::int64_t columns = range.high[u] - range.low[u];
        for (std::int64_t row = range.low[v]; row < range.high[v]; row += lanes) {
            const auto rows =
                hn::Add(hn::Set(d, static_cast<double>(row - range.low[v])), hn::Iota(d, 0.0));
            auto first = hn::Zero(d);
            auto last = hn::Set(d, static_cast<double>(columns - 1));
            for (const Edge& edge : edges) {
                const auto value =
                    hn::Add(hn::Set(d, edge.value), hn::Mul(hn::Set(d, edge.perRow), rows));
                // level ones let through all columns or none
                const double divisor = edge.perColumn == 0 ? 1e-9 : edge.perColumn;
                const auto limit = hn::Div(value, hn::Set(d, divisor));
                const auto isLast = hn::Gt(hn::Set(d, divisor), hn::Zero(d));
                const auto many = hn::Set(d, kManyColumns);
                last = hn::Min(last, hn::IfThenElse(isLast, hn::Floor(limit), many));
                first = hn::Max(first, hn::IfThenElse(isLast, hn::Neg(many), hn::Ceil(limit)));
            }
            HWY_ALIGN std::array<double, kMostLanes> begin;
            HWY_ALIGN std::array<double, kMostLanes> end;
            hn::Store(first, d, begin.data());
            hn::Store(last, d, end.data());
            double least = kManyColumns;
            double most = -1;
            const auto used = static_cast<std::size_t>(std::min(lanes, range.high[v] - row));
            for (std::size_t i = 0; i < used; ++i) {
                const bool isMet = begin[i] <= end[i];
                least = std::min(least, isMet ? begin[i] : kManyColumns);
                most = std::max(most, isMet ? end[i] : -1);
            }
            for (double column = least; column <= most; ++column) {
                const auto at = hn::Sub(
                    hn::Sub(hn::Set(d, height), hn::Mul(hn::Set(d, slopeV * kEdge), rows)),
                    hn::Set(d, slopeU * kEdge * column));
                HWY_ALIGN std::array<double, kMostLanes> layer;
                hn::Store(hn::Floor(hn::Div(at, hn::Set(d, size * kEdge))), d, layer.data());
                for (std::size_t i = 0; i < used; ++i) {
                    if (column < begin[i] || column > end[i])
                        continue;
                    const std::int64_t k = lowest + static_cast<std::int64_t>(layer[i]);
                    if (k < within.low[w] || k >= within.high[w])
                        continue;
                    RangePlace& hit = hits.emplace_back();
                    hit[u] = static_cast<std::int32_t>(
                        range.low[u] + static_cast<std::int64_t>(column) - within.low[u]);
                    hit[v] = static_cast<std::int32_t>(
                        row + static_cast<std::int64_t>(i) - within.low[v]);
                    hit[w] = static_cast<std::int32_t>(k - within.low[w]);
                }
            }
        }
    }
}

} // namespace isofront::voxels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::voxels {

HWY_EXPORT(addCrosshairsOn);

bool hasSmallCrosshairs(const LatticeTriangle& triangle)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, most] =
            std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
        if (most - least >= 16 * kSteps)
            return false;
    }
    return true;
}

void addCrosshairs(
    const LatticeTriangle& triangle, const VoxelRange& within, std::vector<RangePlace>& hits)
{
    HWY_DYNAMIC_DISPATCH(addCrosshairsOn)(triangle, within, hits);
}

} // namespace isofront::voxels
#endif

#pragma once

#include "LatticeTriangle.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace isofront::voxels {

/// A corner of a polygon, and the line that its edge to the next corner is a part of: cuts are
/// taken on that, so that all who share the line cut it at the same places, in any order.
struct CutCorner {
    LatticePoint at{};
    LatticePoint from{}; ///< of the line's ends, the first in lexicographic order
    LatticePoint to{};
};
using CutPolygon = std::vector<CutCorner>;

/// Where a plane cuts the edge that leaves a corner, rounded to whole steps; on the edge's own side
/// of all planes that its ends respect.
/// @param next  the edge's other end, on the other side of the plane
inline LatticePoint
cutOf(const CutCorner& corner, const LatticePoint& next, std::size_t axis, std::int64_t plane)
{
    LatticePoint cut{};
    const std::int64_t length = corner.to[axis] - corner.from[axis];
    const std::int64_t along = plane - corner.from[axis];
    for (std::size_t i = 0; i < 3; ++i) {
        const std::int64_t rise = corner.to[i] - corner.from[i];
        // the nearest whole number; below 2^56 for steps below 2^27
        const std::int64_t sign = length < 0 ? -1 : 1;
        const std::int64_t place =
            corner.from[i] + floorDivide(sign * (2 * along * rise + length), 2 * sign * length);
        cut[i] =
            std::clamp(place, std::min(corner.at[i], next[i]), std::max(corner.at[i], next[i]));
    }
    cut[axis] = plane;
    return cut;
}

inline void setLine(CutCorner& corner, const LatticePoint& next)
{
    std::tie(corner.from, corner.to) = std::minmax({corner.at, next});
}

/// A triangle as a polygon.
inline CutPolygon polygonOf(const LatticeTriangle& triangle)
{
    CutPolygon polygon(3);
    for (std::size_t i = 0; i < 3; ++i) {
        polygon[i].at = triangle[i];
        setLine(polygon[i], triangle[(i + 1) % 3]);
    }
    return polygon;
}

/// Divides a polygon at a plane. What lies in the plane belongs to both; nothing is left of a half
/// that has no more than a line there.
inline void divide(
    const CutPolygon& polygon,
    std::size_t axis,
    std::int64_t plane,
    CutPolygon& below,
    CutPolygon& above)
{
    std::array<CutPolygon*, 2> halves{&below, &above};
    std::array<std::vector<bool>, 2> isCut; // whether the edge that leaves a corner lies in it
    const auto sideOf = [&](const CutCorner& corner) {
        return corner.at[axis] < plane ? -1 : corner.at[axis] > plane ? 1 : 0;
    };
    below.clear();
    above.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const CutCorner& corner = polygon[i];
        const CutCorner& next = polygon[(i + 1) % polygon.size()];
        const int here = sideOf(corner);
        const int there = sideOf(next);
        for (std::size_t half = 0; half < 2; ++half) {
            const int side = half == 0 ? -1 : 1;
            if (here == -side)
                continue;
            halves[half]->push_back(corner);
            isCut[half].push_back(here == 0 && there == -side);
        }
        if (here * there >= 0)
            continue;
        CutCorner cut = corner;
        cut.at = cutOf(corner, next.at, axis, plane);
        for (std::size_t half = 0; half < 2; ++half) {
            halves[half]->push_back(cut);
            isCut[half].push_back(there == (half == 0 ? 1 : -1));
        }
    }
    for (std::size_t half = 0; half < 2; ++half) {
        CutPolygon& part = *halves[half];
        for (std::size_t i = 0; i < part.size(); ++i)
            if (isCut[half][i])
                setLine(part[i], part[(i + 1) % part.size()].at);
        const int side = half == 0 ? -1 : 1;
        const bool isFlat = std::ranges::none_of(
            part, [&](const CutCorner& corner) { return sideOf(corner) == side; });
        if (part.size() < 3 || isFlat)
            part.clear();
    }
}

/// Divides what of a polygon lies within a range at all planes that are multiples of a step.
///
/// @param low, high  the range, multiples of the step; a polygon in its upper border is not part of
///                   it, one in its lower border is
/// @param body       called with each part
template <typename Body>
void cutInto(
    CutPolygon polygon,
    const LatticePoint& low,
    const LatticePoint& high,
    std::int64_t step,
    const Body& body,
    std::size_t axis = 0)
{
    if (axis == 3) {
        body(polygon);
        return;
    }
    const auto ends = [&] {
        const auto [least, most] = std::ranges::minmax_element(
            polygon, {}, [&](const CutCorner& corner) { return corner.at[axis]; });
        return std::pair(least->at[axis], most->at[axis]);
    };
    auto [least, most] = ends();
    if (most < low[axis] || least >= high[axis] || (most == low[axis] && least < most))
        return;
    CutPolygon below;
    CutPolygon above;
    if (least < low[axis]) {
        divide(polygon, axis, low[axis], below, above);
        polygon.swap(above);
        if (polygon.empty())
            return;
        least = low[axis];
    }
    if (most > high[axis]) {
        divide(polygon, axis, high[axis], below, above);
        polygon.swap(below);
        if (polygon.empty())
            return;
        most = high[axis];
    }
    for (std::int64_t plane = (floorDivide(least, step) + 1) * step; plane < most; plane += step) {
        divide(polygon, axis, plane, below, above);
        if (!below.empty())
            cutInto(below, low, high, step, body, axis + 1);
        polygon.swap(above);
        if (polygon.empty())
            return;
    }
    cutInto(std::move(polygon), low, high, step, body, axis + 1);
}

} // namespace isofront::voxels

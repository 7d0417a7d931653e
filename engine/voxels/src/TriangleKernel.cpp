#include "TriangleKernel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "TriangleKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef ISOFRONT_TRIANGLE_KERNEL
#define ISOFRONT_TRIANGLE_KERNEL
namespace isofront::voxels {
namespace {

/// Places that rounding may put on the other side of a border are looked at twice [voxels]: far
/// more than rounding is, and less than a step of the lattice.
constexpr double kSlack = 1e-4;
/// Farther than any triangle's corner [voxels].
constexpr double kFar = 1 << 20;
/// Numbers up to here are exact enough for the slack, even along edges that are all but parallel to
/// a row's border [voxels].
constexpr double kNear = 1024;
/// Three corners of a triangle, and two more where both of a layer's borders cut it.
constexpr std::size_t kMostEdges = 5;

inline std::int32_t floored(double x)
{
    const auto toward0 = static_cast<std::int32_t>(x);
    return toward0 - (x < static_cast<double>(toward0) ? 1 : 0);
}

/// A place in the plane across the axis along which a triangle is least steep [voxels].
struct Place {
    double u = 0;
    double v = 0;
};

/// A triangle's corner: also its height, exactly.
struct Corner {
    Place place;
    std::int64_t height = 0; ///< [steps]
};

/// The line from a corner to a higher one.
class RisingEdge {
public:
    RisingEdge(const Corner& low, const Corner& high) : _low(low), _high(high)
    {
        const std::int64_t height = high.height - low.height;
        const double scale = 1 / static_cast<double>(height > 0 ? height : 1);
        _u = (high.place.u - low.place.u) * scale;
        _v = (high.place.v - low.place.v) * scale;
    }
    /// Where it has a height; the nearest end where it hasn't.
    [[nodiscard]] Place at(std::int64_t height) const
    {
        if (height <= _low.height)
            return _low.place;
        if (height >= _high.height)
            return _high.place;
        const auto up = static_cast<double>(height - _low.height);
        return {_low.place.u + up * _u, _low.place.v + up * _v};
    }

private:
    Corner _low;
    Corner _high;
    double _u; ///< a step of height
    double _v;
};

/// A triangle with its corners in the order of their heights.
struct LayeredTriangle {
    Corner low;
    Corner middle;
    Corner high;
    double sign = 1; ///< of the area from the low corner to the high one and the middle one
    bool isNear = true;
};

/// The edges of a convex polygon, each from its lower end.
struct PolygonEdges {
    std::array<Place, kMostEdges + 1> corner; ///< the first once more at the end
    std::array<Place, kMostEdges> low;
    std::array<double, kMostEdges> high;  ///< v
    std::array<double, kMostEdges> slope; ///< of u over v
    std::array<double, kMostEdges> sign;  ///< of what they count in the area
    std::size_t count = 0;
    double least = 0; ///< v
    double most = 0;
    /// Whether a corner may lie on a row's border but for rounding: it and its edges belong to both
    /// rows then.
    bool isDelicate = false;

    void add(const Place& place) { corner[count++] = place; }
    void close(double polygonSign)
    {
        corner[count] = corner[0];
        least = most = corner[0].v;
        for (std::size_t i = 0; i < count; ++i) {
            const Place& from = corner[i];
            const Place& to = corner[i + 1];
            const double rise = to.v - from.v;
            const bool isRising = rise >= 0;
            low[i].u = isRising ? from.u : to.u;
            low[i].v = isRising ? from.v : to.v;
            high[i] = isRising ? to.v : from.v;
            slope[i] = (to.u - from.u) / (rise == 0 ? 1 : rise);
            sign[i] = isRising ? polygonSign : -polygonSign;
            least = std::min(least, from.v);
            most = std::max(most, from.v);
            const double rest = from.v - static_cast<double>(floored(from.v));
            isDelicate = isDelicate || std::min(rest, 1 - rest) < kSlack;
        }
    }
    /// How far along a row the polygon may reach.
    void widen(double row, double& least_u, double& most_u) const
    {
        const auto reach = [&](double u) {
            least_u = std::min(least_u, u);
            most_u = std::max(most_u, u);
        };
        for (std::size_t i = 0; i < count; ++i) {
            if (corner[i].v >= row - kSlack && corner[i].v <= row + 1 + kSlack)
                reach(corner[i].u);
            for (const double v : {row - kSlack, row + 1 + kSlack})
                if (low[i].v < v && v < high[i])
                    reach(low[i].u + (v - low[i].v) * slope[i]);
        }
    }
};

/// A triangle's polygon in a layer.
inline void
cut(const LayeredTriangle& triangle,
    const std::array<RisingEdge, 3>& edges,
    std::int64_t floor,
    std::int64_t ceiling,
    PolygonEdges& polygon)
{
    polygon.count = 0;
    polygon.isDelicate = !triangle.isNear;
    const auto& [low, middle, high, sign, isNear] = triangle;
    const auto& [longest, lower, upper] = edges;
    if (low.height >= floor && high.height <= ceiling) {
        polygon.add(low.place);
        polygon.add(high.place);
        polygon.add(middle.place);
    } else {
        polygon.add(longest.at(floor));
        polygon.add(longest.at(ceiling));
        if (high.height > ceiling)
            polygon.add(ceiling < middle.height ? lower.at(ceiling) : upper.at(ceiling));
        if (middle.height >= floor && middle.height <= ceiling)
            polygon.add(middle.place);
        if (low.height < floor)
            polygon.add(floor < middle.height ? lower.at(floor) : upper.at(floor));
    }
    polygon.close(sign);
}

} // namespace
} // namespace isofront::voxels
#endif

HWY_BEFORE_NAMESPACE();
namespace isofront::voxels::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Rows that are looked at together: few triangles reach across more of them.
using Rows = hn::CappedTag<double, 4>;
constexpr std::size_t kMostLanes = 4;

/// A polygon's edges, cut at the borders of some rows.
struct EdgesInRows {
    // a number for each edge and row
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> from; ///< u at the lower end
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> to;
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> inverse; ///< of the difference
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> rise;    ///< signed
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> begin;   ///< v from the row's border
    HWY_ALIGN std::array<double, kMostEdges * kMostLanes> end;
    // one for each row: how far the polygon reaches along it
    HWY_ALIGN std::array<double, kMostLanes> least;
    HWY_ALIGN std::array<double, kMostLanes> most;
};

HWY_INLINE void enterRows(const PolygonEdges& polygon, double firstRow, EdgesInRows& rows)
{
    const Rows d;
    const auto low = hn::Add(hn::Set(d, firstRow), hn::Iota(d, 0.0));
    const auto high = hn::Add(low, hn::Set(d, 1.0));
    const auto far = hn::Set(d, kFar);
    const auto nearFar = hn::Neg(far);
    auto least = far;
    auto most = nearFar;
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const auto edgeLow = hn::Set(d, polygon.low[i].v);
        const auto edgeHigh = hn::Set(d, polygon.high[i]);
        // those that don't meet a row have no height in it
        const auto begin = hn::Min(hn::Max(edgeLow, low), edgeHigh);
        const auto end = hn::Max(hn::Min(edgeHigh, high), edgeLow);
        const auto lowU = hn::Set(d, polygon.low[i].u);
        const auto slope = hn::Set(d, polygon.slope[i]);
        const auto from = hn::Add(lowU, hn::Mul(hn::Sub(begin, edgeLow), slope));
        const auto to = hn::Add(lowU, hn::Mul(hn::Sub(end, edgeLow), slope));
        const auto isMet = hn::Lt(begin, end);
        least = hn::Min(least, hn::IfThenElse(isMet, hn::Min(from, to), far));
        most = hn::Max(most, hn::IfThenElse(isMet, hn::Max(from, to), nearFar));
        const auto width =
            hn::Max(hn::Abs(hn::Sub(to, from)), hn::Set(d, std::numeric_limits<double>::min()));
        const std::size_t at = i * kMostLanes;
        hn::Store(from, d, &rows.from[at]);
        hn::Store(to, d, &rows.to[at]);
        hn::Store(hn::Div(hn::Set(d, 1.0), width), d, &rows.inverse[at]);
        hn::Store(
            hn::Mul(hn::Set(d, 0.5 * polygon.sign[i]), hn::Sub(end, begin)), d, &rows.rise[at]);
        hn::Store(hn::Sub(begin, low), d, &rows.begin[at]);
        hn::Store(hn::Sub(end, low), d, &rows.end[at]);
    }
    hn::Store(least, d, rows.least.data());
    hn::Store(most, d, rows.most.data());
}

/// What of the rows' parts lies beyond a line in each, with u growing, as integrals over it.
struct Beyond {
    hn::Vec<Rows> area;
    hn::Vec<Rows> u; ///< moment about that line
    hn::Vec<Rows> v; ///< moment about the row's border
};

template <bool kMoments>
HWY_INLINE Beyond beyond(const EdgesInRows& rows, std::size_t edges, hn::Vec<Rows> line)
{
    const Rows d;
    const auto zero = hn::Zero(d);
    const auto one = hn::Set(d, 1.0);
    Beyond sum{zero, zero, zero};
    for (std::size_t i = 0; i < edges; ++i) {
        const std::size_t at = i * kMostLanes;
        const auto from = hn::Sub(hn::Load(d, &rows.from[at]), line);
        const auto to = hn::Sub(hn::Load(d, &rows.to[at]), line);
        const auto fromPart = hn::Max(from, zero);
        const auto toPart = hn::Max(to, zero);
        // of an edge across the line, the share that lies beyond it
        const auto share = hn::IfThenElse(
            hn::Lt(hn::Mul(from, to), zero),
            hn::Mul(hn::Add(fromPart, toPart), hn::Load(d, &rows.inverse[at])),
            one);
        const auto rise = hn::Mul(hn::Load(d, &rows.rise[at]), share);
        const auto width = hn::Add(fromPart, toPart);
        sum.area = hn::Add(sum.area, hn::Mul(rise, width));
        if constexpr (kMoments) {
            const auto low = hn::Load(d, &rows.begin[at]);
            const auto high = hn::Load(d, &rows.end[at]);
            const auto part = hn::Mul(share, hn::Sub(high, low));
            const auto begin = hn::IfThenElse(hn::Lt(from, zero), hn::Sub(high, part), low);
            const auto end = hn::IfThenElse(hn::Lt(to, zero), hn::Add(low, part), high);
            const auto third = hn::Mul(rise, hn::Set(d, 1.0 / 3));
            const auto squares = hn::Add(
                hn::Mul(fromPart, fromPart),
                hn::Add(hn::Mul(fromPart, toPart), hn::Mul(toPart, toPart)));
            sum.u = hn::Add(sum.u, hn::Mul(third, squares));
            const auto weighted = hn::Add(
                hn::Mul(begin, hn::Add(fromPart, width)), hn::Mul(end, hn::Add(toPart, width)));
            sum.v = hn::Add(sum.v, hn::Mul(third, weighted));
        }
    }
    return sum;
}

/// How a triangle lies in the voxels of a range.
struct Frame {
    std::size_t u = 0; ///< which axis
    std::size_t v = 0;
    std::size_t w = 0;
    std::int32_t columns = 0;
    std::int32_t rows = 0;
    double stretch = 0; ///< its area over that seen along w
    Place first;        ///< its first corner
    double riseU = 0;   ///< of w over u
    double riseV = 0;
};

template <bool kMoments>
HWY_INLINE void addRows(
    const Frame& frame,
    const PolygonEdges& polygon,
    double stretch,
    std::int32_t layer,
    std::vector<TrianglePart>& parts)
{
    const Rows d;
    const std::size_t lanes = hn::Lanes(d);
    EdgesInRows rows;
    const std::int32_t lastRow = std::min(floored(polygon.most + kSlack), frame.rows - 1);
    for (std::int32_t row = std::max(floored(polygon.least - kSlack), 0); row <= lastRow;
         row += static_cast<std::int32_t>(lanes)) {
        enterRows(polygon, row, rows);
        std::array<std::int32_t, kMostLanes> first{};
        std::array<std::int32_t, kMostLanes> count{};
        HWY_ALIGN std::array<double, kMostLanes> lines{};
        std::int32_t most = 0;
        bool isClipped = false;
        const std::size_t used = std::min(lanes, static_cast<std::size_t>(lastRow - row) + 1);
        for (std::size_t i = 0; i < used; ++i) {
            double low = rows.least[i];
            double high = rows.most[i];
            // a polygon that is but a line along the row has no edges that rise
            if (polygon.isDelicate || low > high)
                polygon.widen(static_cast<double>(row) + static_cast<double>(i), low, high);
            if (low > high)
                continue;
            const std::int32_t begin = floored(low - kSlack);
            const std::int32_t end = floored(high + kSlack) + 1;
            isClipped = isClipped || begin < 0 || end > frame.columns;
            first[i] = std::max(begin, 0);
            count[i] = std::min(end, frame.columns) - first[i];
            lines[i] = static_cast<double>(first[i]);
            most = std::max(most, count[i]);
        }
        auto line = hn::Load(d, lines.data());
        const auto one = hn::Set(d, 1.0);
        const auto zero = hn::Zero(d);
        auto here = beyond<kMoments>(rows, polygon.count, line);
        for (std::int32_t column = 0; column < most; ++column) {
            line = hn::Add(line, one);
            Beyond next{zero, zero, zero};
            if (isClipped || column + 1 < most)
                next = beyond<kMoments>(rows, polygon.count, line);
            HWY_ALIGN std::array<double, kMostLanes> area;
            HWY_ALIGN std::array<double, kMostLanes> u{};
            HWY_ALIGN std::array<double, kMostLanes> v{};
            hn::Store(hn::Sub(here.area, next.area), d, area.data());
            if constexpr (kMoments) {
                hn::Store(hn::Sub(hn::Sub(here.u, next.u), next.area), d, u.data());
                hn::Store(hn::Sub(here.v, next.v), d, v.data());
            }
            here = next;
            for (std::size_t i = 0; i < used; ++i) {
                if (column >= count[i])
                    continue;
                TrianglePart& part = parts.emplace_back();
                part.voxel[frame.u] = first[i] + column;
                part.voxel[frame.v] = row + static_cast<std::int32_t>(i);
                part.voxel[frame.w] = layer;
                part.area = stretch * area[i];
                if constexpr (kMoments) {
                    if (part.area < kSurelyTouched)
                        continue;
                    const double toU = first[i] + column + u[i] / area[i] - frame.first.u;
                    const double toV = part.voxel[frame.v] + v[i] / area[i] - frame.first.v;
                    part.offset[static_cast<glm::length_t>(frame.u)] = toU;
                    part.offset[static_cast<glm::length_t>(frame.v)] = toV;
                    part.offset[static_cast<glm::length_t>(frame.w)] =
                        frame.riseU * toU + frame.riseV * toV;
                }
            }
        }
    }
}

} // namespace

void divideTriangleOn(
    const LatticeTriangle& triangle,
    const VoxelRange& within,
    bool centroids,
    std::vector<TrianglePart>& parts)
{
    const VoxelRange range = intersection(voxelsOf(triangle), within);
    if (isEmpty(range))
        return;
    const std::array<std::int64_t, 3> area = doubleArea(triangle);
    const std::array<double, 3> normal{
        static_cast<double>(area[0]), static_cast<double>(area[1]), static_cast<double>(area[2])};
    Frame frame;
    frame.w = 2;
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}})
        if (std::abs(normal[axis]) > std::abs(normal[frame.w]))
            frame.w = axis;
    // rows along the longer side
    const std::size_t w = frame.w;
    std::size_t u = (w + 1) % 3;
    std::size_t v = (w + 2) % 3;
    const bool isTurned = range.high[u] - range.low[u] < range.high[v] - range.low[v];
    if (isTurned)
        std::swap(u, v);
    frame.u = u;
    frame.v = v;
    frame.columns = static_cast<std::int32_t>(within.high[u] - within.low[u]);
    frame.rows = static_cast<std::int32_t>(within.high[v] - within.low[v]);
    if (normal[w] != 0) {
        const double length =
            std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        frame.stretch = length / std::abs(normal[w]);
        frame.riseU = -normal[u] / normal[w];
        frame.riseV = -normal[v] / normal[w];
    }

    // from the range's corner on, so that numbers stay small
    std::array<Corner, 3> corners;
    LayeredTriangle layered;
    for (std::size_t i = 0; i < 3; ++i) {
        constexpr auto kEdge = static_cast<double>(kSteps);
        Corner& corner = corners[i];
        corner.place.u = static_cast<double>(triangle[i][u] - within.low[u] * kSteps) / kEdge;
        corner.place.v = static_cast<double>(triangle[i][v] - within.low[v] * kSteps) / kEdge;
        corner.height = triangle[i][w] - within.low[w] * kSteps;
        layered.isNear =
            layered.isNear && std::abs(corner.place.u) < kNear && std::abs(corner.place.v) < kNear;
    }
    frame.first = corners[0].place;
    layered.sign = (area[w] > 0) == isTurned ? 1 : -1;
    const auto order = [&](std::size_t a, std::size_t b) {
        if (corners[a].height > corners[b].height) {
            std::swap(corners[a], corners[b]);
            layered.sign = -layered.sign;
        }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    layered.low = corners[0];
    layered.middle = corners[1];
    layered.high = corners[2];
    const std::array<RisingEdge, 3> edges{
        RisingEdge(corners[0], corners[2]),
        RisingEdge(corners[0], corners[1]),
        RisingEdge(corners[1], corners[2])};

    PolygonEdges polygon;
    for (std::int64_t layer = range.low[w] - within.low[w]; layer < range.high[w] - within.low[w];
         ++layer) {
        const std::int64_t floor = layer * kSteps;
        const std::int64_t ceiling = floor + kSteps;
        cut(layered, edges, floor, ceiling, polygon);
        // a triangle that lies in a layer's ceiling counts in the layer above
        const double stretch = layered.low.height == ceiling ? 0 : frame.stretch;
        if (centroids)
            addRows<true>(frame, polygon, stretch, static_cast<std::int32_t>(layer), parts);
        else
            addRows<false>(frame, polygon, stretch, static_cast<std::int32_t>(layer), parts);
    }
}

} // namespace isofront::voxels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::voxels {

HWY_EXPORT(divideTriangleOn);

void divideTriangle(
    const LatticeTriangle& triangle,
    const VoxelRange& within,
    bool centroids,
    std::vector<TrianglePart>& parts)
{
    HWY_DYNAMIC_DISPATCH(divideTriangleOn)(triangle, within, centroids, parts);
}

} // namespace isofront::voxels
#endif

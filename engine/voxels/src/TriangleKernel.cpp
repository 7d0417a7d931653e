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
/// The three sides of a triangle, and two more where both of a layer's borders cut it.
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
    double height = 0; ///< [steps]
};

/// A triangle with its corners in the order of their heights.
struct LayeredTriangle {
    Corner low;
    Corner middle;
    Corner high;
    double sign = 1; ///< of the area from the low corner to the high one and the middle one
    bool isNear = true;
};

} // namespace
} // namespace isofront::voxels
#endif

HWY_BEFORE_NAMESPACE();
namespace isofront::voxels::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Rows, and layers, that are looked at together: few triangles reach across more of them.
using Rows = hn::CappedTag<double, 4>;
constexpr std::size_t kMostLanes = 4;
using Number = hn::Vec<Rows>;
using Choice = hn::Mask<Rows>;

/// Places in several layers.
struct Places {
    Number u;
    Number v;
};

HWY_INLINE Places set(const Place& place)
{
    const Rows d;
    return {hn::Set(d, place.u), hn::Set(d, place.v)};
}

HWY_INLINE Places choose(Choice isFirst, const Places& first, const Places& second)
{
    return {hn::IfThenElse(isFirst, first.u, second.u), hn::IfThenElse(isFirst, first.v, second.v)};
}

/// A side of a triangle, from its lower corner to its higher one.
class Side {
public:
    HWY_INLINE Side(const Corner& low, const Corner& high)
        : _low(set(low.place)), _high(set(high.place)), _lowHeight(hn::Set(Rows(), low.height)),
          _highHeight(hn::Set(Rows(), high.height))
    {
        const double height = high.height - low.height;
        const double scale = 1 / (height > 0 ? height : 1);
        _perStep =
            set({(high.place.u - low.place.u) * scale, (high.place.v - low.place.v) * scale});
    }
    /// Where it enters layers: at their floors, or its lower end above them.
    [[nodiscard]] HWY_INLINE Places bottom(Number floors) const
    {
        const auto isBelow = hn::Ge(floors, _highHeight);
        const auto isAbove = hn::Le(floors, _lowHeight);
        return choose(isAbove, _low, choose(isBelow, _high, at(floors)));
    }
    /// Where it leaves them.
    [[nodiscard]] HWY_INLINE Places top(Number ceilings) const
    {
        const auto isBelow = hn::Ge(ceilings, _highHeight);
        const auto isAbove = hn::Le(ceilings, _lowHeight);
        return choose(isBelow, _high, choose(isAbove, _low, at(ceilings)));
    }
    /// In which layers there is nothing of it.
    [[nodiscard]] HWY_INLINE Choice isElsewhere(Number floors, Number ceilings) const
    {
        return hn::Or(hn::Lt(_highHeight, floors), hn::Gt(_lowHeight, ceilings));
    }

private:
    [[nodiscard]] HWY_INLINE Places at(Number heights) const
    {
        const auto up = hn::Sub(heights, _lowHeight);
        return {hn::Add(_low.u, hn::Mul(up, _perStep.u)), hn::Add(_low.v, hn::Mul(up, _perStep.v))};
    }

    Places _low;
    Places _high;
    Number _lowHeight;
    Number _highHeight;
    Places _perStep;
};

/// A triangle's polygons in some layers: convex ones, as edges, each from its lower end. Those that
/// a polygon lacks have no length.
struct PolygonsInLayers {
    /// A number for each edge and layer.
    using Numbers = std::array<double, kMostEdges * kMostLanes>;
    HWY_ALIGN Numbers lowU;
    HWY_ALIGN Numbers lowV;
    HWY_ALIGN Numbers highU;
    HWY_ALIGN Numbers highV;
    HWY_ALIGN Numbers slope; ///< of u over v
    HWY_ALIGN Numbers half;  ///< 1/2 or -1/2: what they count in the area
    // one for each layer
    HWY_ALIGN std::array<double, kMostLanes> least; ///< v
    HWY_ALIGN std::array<double, kMostLanes> most;
    /// How near a corner comes to a row's border. One that is there but for rounding belongs to
    /// both rows, with its edges.
    HWY_ALIGN std::array<double, kMostLanes> nearest;

    /// How far along a row a layer's polygon may reach.
    void widen(std::size_t layer, double row, double& leastU, double& mostU) const
    {
        const auto reach = [&](double u) {
            leastU = std::min(leastU, u);
            mostU = std::max(mostU, u);
        };
        const auto isIn = [&](double v) { return v >= row - kSlack && v <= row + 1 + kSlack; };
        for (std::size_t i = layer; i < lowU.size(); i += kMostLanes) {
            if (isIn(lowV[i]))
                reach(lowU[i]);
            if (isIn(highV[i]))
                reach(highU[i]);
            for (const double v : {row - kSlack, row + 1 + kSlack})
                if (lowV[i] < v && v < highV[i])
                    reach(lowU[i] + (v - lowV[i]) * slope[i]);
        }
    }
};

/// Cuts a triangle at the borders of some layers.
/// @param firstFloor  of the first one [steps]
HWY_INLINE void cut(const LayeredTriangle& triangle, double firstFloor, PolygonsInLayers& polygons)
{
    const Rows d;
    constexpr auto kEdge = static_cast<double>(kSteps);
    const auto floors =
        hn::Add(hn::Set(d, firstFloor), hn::Mul(hn::Iota(d, 0.0), hn::Set(d, kEdge)));
    const auto ceilings = hn::Add(floors, hn::Set(d, kEdge));
    const auto& [low, middle, high, sign, isNear] = triangle;
    const Side longest(low, high);
    const Side lower(low, middle);
    const Side upper(middle, high);
    const Places longestBottom = longest.bottom(floors);
    const Places longestTop = longest.top(ceilings);
    // what isn't there has no length, and is where the polygon is
    const auto noLower = lower.isElsewhere(floors, ceilings);
    const auto noUpper = upper.isElsewhere(floors, ceilings);
    const Places lowerBottom = choose(noLower, longestBottom, lower.bottom(floors));
    const Places lowerTop = choose(noLower, longestBottom, lower.top(ceilings));
    const Places upperBottom = choose(noUpper, longestBottom, upper.bottom(floors));
    const Places upperTop = choose(noUpper, longestBottom, upper.top(ceilings));
    const auto middleHeight = hn::Set(d, middle.height);
    const auto isCutBelow = hn::Lt(hn::Set(d, low.height), floors);
    const auto isCutAbove = hn::Gt(hn::Set(d, high.height), ceilings);
    const Places floorEnd = choose(
        isCutBelow, choose(hn::Lt(floors, middleHeight), lowerBottom, upperBottom), longestBottom);
    const Places ceilingEnd =
        choose(isCutAbove, choose(hn::Lt(ceilings, middleHeight), lowerTop, upperTop), longestTop);

    auto least = longestBottom.v;
    auto most = longestBottom.v;
    const auto enter = [&](std::size_t edge, const Places& from, const Places& to) {
        const auto rise = hn::Sub(to.v, from.v);
        const auto isRising = hn::Ge(rise, hn::Zero(d));
        const Places lowEnd = choose(isRising, from, to);
        const Places highEnd = choose(isRising, to, from);
        least = hn::Min(least, lowEnd.v);
        most = hn::Max(most, highEnd.v);
        const auto divisor = hn::IfThenElse(hn::Eq(rise, hn::Zero(d)), hn::Set(d, 1.0), rise);
        const std::size_t at = edge * kMostLanes;
        hn::Store(lowEnd.u, d, &polygons.lowU[at]);
        hn::Store(lowEnd.v, d, &polygons.lowV[at]);
        hn::Store(highEnd.u, d, &polygons.highU[at]);
        hn::Store(highEnd.v, d, &polygons.highV[at]);
        hn::Store(hn::Div(hn::Sub(to.u, from.u), divisor), d, &polygons.slope[at]);
        hn::Store(
            hn::IfThenElse(isRising, hn::Set(d, 0.5 * sign), hn::Set(d, -0.5 * sign)),
            d,
            &polygons.half[at]);
    };
    enter(0, longestBottom, longestTop);
    enter(1, longestTop, ceilingEnd);
    enter(2, upperTop, upperBottom);
    enter(3, lowerTop, lowerBottom);
    enter(4, floorEnd, longestBottom);
    auto nearest = hn::Set(d, isNear ? 1.0 : 0.0);
    for (const Places& corner :
         {longestBottom, longestTop, lowerBottom, lowerTop, upperBottom, upperTop})
        nearest = hn::Min(nearest, hn::Abs(hn::Sub(corner.v, hn::Round(corner.v))));
    hn::Store(least, d, polygons.least.data());
    hn::Store(most, d, polygons.most.data());
    hn::Store(nearest, d, polygons.nearest.data());
}

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

/// @return how many edges there are
HWY_INLINE std::size_t
enterRows(const PolygonsInLayers& polygons, std::size_t layer, double firstRow, EdgesInRows& rows)
{
    const Rows d;
    const auto low = hn::Add(hn::Set(d, firstRow), hn::Iota(d, 0.0));
    const auto high = hn::Add(low, hn::Set(d, 1.0));
    const auto far = hn::Set(d, kFar);
    const auto nearFar = hn::Neg(far);
    auto least = far;
    auto most = nearFar;
    std::size_t count = 0;
    for (std::size_t i = layer; i < polygons.lowV.size(); i += kMostLanes) {
        if (polygons.lowV[i] >= polygons.highV[i])
            continue; // along the row, or not there
        const auto edgeLow = hn::Set(d, polygons.lowV[i]);
        const auto edgeHigh = hn::Set(d, polygons.highV[i]);
        // those that don't meet a row have no height in it
        const auto begin = hn::Min(hn::Max(edgeLow, low), edgeHigh);
        const auto end = hn::Max(hn::Min(edgeHigh, high), edgeLow);
        const auto lowU = hn::Set(d, polygons.lowU[i]);
        const auto slope = hn::Set(d, polygons.slope[i]);
        const auto from = hn::Add(lowU, hn::Mul(hn::Sub(begin, edgeLow), slope));
        const auto to = hn::Add(lowU, hn::Mul(hn::Sub(end, edgeLow), slope));
        const auto isMet = hn::Lt(begin, end);
        least = hn::Min(least, hn::IfThenElse(isMet, hn::Min(from, to), far));
        most = hn::Max(most, hn::IfThenElse(isMet, hn::Max(from, to), nearFar));
        const auto width =
            hn::Max(hn::Abs(hn::Sub(to, from)), hn::Set(d, std::numeric_limits<double>::min()));
        const std::size_t at = count++ * kMostLanes;
        hn::Store(from, d, &rows.from[at]);
        hn::Store(to, d, &rows.to[at]);
        hn::Store(hn::Div(hn::Set(d, 1.0), width), d, &rows.inverse[at]);
        hn::Store(hn::Mul(hn::Set(d, polygons.half[i]), hn::Sub(end, begin)), d, &rows.rise[at]);
        hn::Store(hn::Sub(begin, low), d, &rows.begin[at]);
        hn::Store(hn::Sub(end, low), d, &rows.end[at]);
    }
    hn::Store(least, d, rows.least.data());
    hn::Store(most, d, rows.most.data());
    return count;
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
    const PolygonsInLayers& polygons,
    std::size_t which, ///< of them
    double stretch,
    std::int32_t layer,
    std::vector<TrianglePart>& parts)
{
    const Rows d;
    const std::size_t lanes = hn::Lanes(d);
    EdgesInRows rows;
    const std::int32_t lastRow = std::min(floored(polygons.most[which] + kSlack), frame.rows - 1);
    for (std::int32_t row = std::max(floored(polygons.least[which] - kSlack), 0); row <= lastRow;
         row += static_cast<std::int32_t>(lanes)) {
        const std::size_t edges = enterRows(polygons, which, row, rows);
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
            if (polygons.nearest[which] < kSlack || low > high)
                polygons.widen(which, static_cast<double>(row) + static_cast<double>(i), low, high);
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
        auto here = beyond<kMoments>(rows, edges, line);
        for (std::int32_t column = 0; column < most; ++column) {
            line = hn::Add(line, one);
            Beyond next{zero, zero, zero};
            if (isClipped || column + 1 < most)
                next = beyond<kMoments>(rows, edges, line);
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
        corner.height = static_cast<double>(triangle[i][w] - within.low[w] * kSteps);
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

    PolygonsInLayers polygons;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(Rows()));
    const std::int64_t end = range.high[w] - within.low[w];
    for (std::int64_t first = range.low[w] - within.low[w]; first < end; first += lanes) {
        cut(layered, static_cast<double>(first * kSteps), polygons);
        for (std::int64_t layer = first; layer < std::min(first + lanes, end); ++layer) {
            // a triangle that lies in a layer's ceiling counts in the layer above
            const auto ceiling = static_cast<double>((layer + 1) * kSteps);
            const double stretch = layered.low.height == ceiling ? 0 : frame.stretch;
            const auto which = static_cast<std::size_t>(layer - first);
            const auto name = static_cast<std::int32_t>(layer);
            if (centroids)
                addRows<true>(frame, polygons, which, stretch, name, parts);
            else
                addRows<false>(frame, polygons, which, stretch, name, parts);
        }
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

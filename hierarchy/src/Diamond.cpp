#include "isofront/hierarchy/Diamond.h"

#include <isofront/core/Assert.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

namespace isofront::hierarchy {

namespace {

/// The axes along which the spine does not run.
struct EvenAxes {
    std::array<std::size_t, 2> axis{};
    std::size_t count = 0;
};

EvenAxes evenAxes(const Diamond& diamond)
{
    EvenAxes even;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!diamond.odd[axis])
            even.axis[even.count++] = axis;
    return even;
}

/// A point moved along an axis, unless that leaves the domain.
std::optional<LatticePoint> moved(const LatticePoint& point, std::size_t axis, std::int64_t by)
{
    const std::int64_t coordinate = std::int64_t{point[axis]} + by;
    if (coordinate < 0 || coordinate > std::int64_t{kLatticeEdge})
        return std::nullopt;
    LatticePoint result = point;
    result[axis] = static_cast<std::uint32_t>(coordinate);
    return result;
}

} // namespace

Diamond::Diamond(const LatticePoint& diamondCentre) : centre(diamondCentre)
{
    const int zeros = std::countr_zero(centre.x | centre.y | centre.z);
    ISOFRONT_ASSERT(zeros < kLatticeBits, "a corner of the domain is not the centre of a diamond");
    halfEdge = 1U << static_cast<unsigned>(zeros);
    int oddCount = 0;
    spineBegin = centre;
    spineFinish = centre;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        odd[axis] = (centre[axis] & halfEdge) != 0;
        if (!odd[axis])
            continue;
        ++oddCount;
        // Of the two ends one is an even multiple of the cube's edge: there all spines begin.
        const std::uint32_t below = centre[axis] - halfEdge;
        const std::uint32_t above = centre[axis] + halfEdge;
        const bool belowIsEven = (below & (2 * halfEdge)) == 0;
        spineBegin[axis] = belowIsEven ? below : above;
        spineFinish[axis] = belowIsEven ? above : below;
    }
    level = 3 * (kLatticeBits - 1 - zeros) + 3 - oddCount;
}

double Diamond::radius() const
{
    return halfEdge * (congruenceClass() == 0 ? std::numbers::sqrt3 : std::numbers::sqrt2);
}

LatticePoints parentsOf(const Diamond& diamond)
{
    LatticePoints parents;
    if (diamond.level == 0)
        return parents;
    if (diamond.congruenceClass() == 0) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            LatticePoint parent = diamond.spineBegin;
            parent[axis] = diamond.spineFinish[axis];
            parents.push(parent);
        }
        return parents;
    }
    const EvenAxes even = evenAxes(diamond);
    const auto h = std::int64_t{diamond.halfEdge};
    for (std::size_t i = 0; i < even.count; ++i)
        for (const std::int64_t by : {-h, h})
            if (const auto parent = moved(diamond.centre, even.axis[i], by))
                parents.push(*parent);
    return parents;
}

LatticePoints childrenOf(const Diamond& diamond)
{
    ISOFRONT_ASSERT(diamond.level < kMaxLevel, "a diamond of the deepest level has no children");
    LatticePoints children;
    const auto h = std::int64_t{diamond.halfEdge};
    if (diamond.congruenceClass() == 2) {
        for (unsigned signs = 0; signs < 8; ++signs) {
            std::optional<LatticePoint> child = diamond.centre;
            for (std::size_t axis = 0; axis < 3 && child; ++axis)
                child = moved(*child, axis, (signs >> axis & 1U) != 0 ? h / 2 : -h / 2);
            if (child)
                children.push(*child);
        }
        return children;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (diamond.odd[axis])
            for (const std::int64_t by : {-h, h})
                if (const auto child = moved(diamond.centre, axis, by))
                    children.push(*child);
    return children;
}

std::uint8_t DiamondTetrahedra::mask() const
{
    unsigned bits = 0;
    for (std::size_t i = 0; i < _count; ++i)
        bits |= 1U << _index[i];
    return static_cast<std::uint8_t>(bits);
}

DiamondTetrahedra tetrahedraOf(const Diamond& diamond)
{
    DiamondTetrahedra result;
    const LatticePoint& q = diamond.spineBegin;
    const LatticePoint& p = diamond.spineFinish;
    const auto h = std::int64_t{diamond.halfEdge};

    if (diamond.congruenceClass() == 0) {
        constexpr std::array<std::array<std::size_t, 3>, 6> kOrders{
            {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
        for (std::size_t i = 0; i < kOrders.size(); ++i) {
            Tetrahedron t{{q, q, q, p}, diamond.level};
            t.corner[1][kOrders[i][0]] = p[kOrders[i][0]];
            t.corner[2] = t.corner[1];
            t.corner[2][kOrders[i][1]] = p[kOrders[i][1]];
            result.push(static_cast<std::uint8_t>(i), t);
        }
        return result;
    }

    const EvenAxes even = evenAxes(diamond);
    std::uint8_t index = 0;
    if (diamond.congruenceClass() == 1) {
        for (const std::int64_t by : {-h, h})
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (!diamond.odd[axis])
                    continue;
                LatticePoint side = q;
                side[axis] = p[axis];
                if (const auto apex = moved(diamond.centre, even.axis[0], by))
                    result.push(index, {{q, side, p, *apex}, diamond.level});
                ++index;
            }
        return result;
    }

    for (std::size_t k = 0; k < 2; ++k)
        for (const std::int64_t faceBy : {-h, h})
            for (const std::int64_t apexBy : {-h, h}) {
                if (const auto face = moved(diamond.centre, even.axis[1 - k], faceBy))
                    if (const auto apex = moved(*face, even.axis[k], apexBy))
                        result.push(index, {{q, p, *face, *apex}, diamond.level});
                ++index;
            }
    return result;
}

CellId cellIdOf(const Tetrahedron& tetrahedron)
{
    // The index follows from which way the corners lead, in the order of `tetrahedraOf`.
    const auto& corner = tetrahedron.corner;
    const LatticePoint centre = tetrahedron.spineCentre();
    const auto axisBetween = [](const LatticePoint& a, const LatticePoint& b) -> unsigned {
        return a.x != b.x ? 0 : a.y != b.y ? 1 : 2;
    };
    unsigned index = 0;
    if (tetrahedron.level % 3 == 0) {
        const unsigned first = axisBetween(corner[0], corner[1]);
        const unsigned second = axisBetween(corner[1], corner[2]);
        index = 2 * first + (second == (first == 0 ? 1U : 0U) ? 0U : 1U);
    } else if (tetrahedron.level % 3 == 1) {
        const unsigned even = axisBetween(corner[3], centre);
        const unsigned side = axisBetween(corner[0], corner[1]);
        index =
            (corner[3][even] > centre[even] ? 2U : 0U) + (side == (even == 0 ? 1U : 0U) ? 0U : 1U);
    } else {
        const unsigned spine = axisBetween(corner[0], corner[1]);
        const unsigned face = axisBetween(corner[2], centre);
        const unsigned apex = 3 - spine - face;
        index = (apex > face ? 4U : 0U) + (corner[2][face] > centre[face] ? 2U : 0U) +
                (corner[3][apex] > centre[apex] ? 1U : 0U);
    }
    const CellId id{centre, static_cast<std::uint8_t>(index)};
    ISOFRONT_ASSERT(
        tetrahedronOf(id) == tetrahedron, "the tetrahedron is not one of the hierarchy");
    return id;
}

Tetrahedron tetrahedronOf(const CellId& id)
{
    const DiamondTetrahedra all = tetrahedraOf(Diamond(id.spine));
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all.index(i) == id.index)
            return all.tetrahedron(i);
    ISOFRONT_ASSERT(false, "the diamond has no tetrahedron of that index");
    return {};
}

} // namespace isofront::hierarchy

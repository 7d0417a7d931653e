#include "VertexKernel.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "VertexKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::surface::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, VertexBlock::kSize>;
using Real = hn::Vec<Doubles>;

struct Vectors {
    Real x;
    Real y;
    Real z;
};

HWY_INLINE Vectors times(const glm::dmat3& matrix, const Vectors& v)
{
    const Doubles d;
    const auto row = [&](std::size_t i) HWY_ATTR {
        return hn::Add(
            hn::Add(hn::Mul(hn::Set(d, matrix[0][i]), v.x), hn::Mul(hn::Set(d, matrix[1][i]), v.y)),
            hn::Mul(hn::Set(d, matrix[2][i]), v.z));
    };
    return {row(0), row(1), row(2)};
}

HWY_INLINE Vectors normalized(const Vectors& v)
{
    const Doubles d;
    const Real squared = hn::Add(hn::Add(hn::Mul(v.x, v.x), hn::Mul(v.y, v.y)), hn::Mul(v.z, v.z));
    const Real scale = hn::Div(hn::Set(d, 1.0), hn::Sqrt(squared));
    return {hn::Mul(v.x, scale), hn::Mul(v.y, scale), hn::Mul(v.z, scale)};
}

/// 1 with the sign of a number; zeros of either sign count as positive.
HWY_INLINE Real signOf(Real value)
{
    const Doubles d;
    const Real one = hn::Set(d, 1.0);
    return hn::IfThenElse(hn::Lt(value, hn::Zero(d)), hn::Neg(one), one);
}

HWY_INLINE Vectors decoded(const std::uint32_t* codes)
{
    const Doubles d;
    const hn::Rebind<std::int32_t, Doubles> i;
    const hn::Rebind<std::uint32_t, Doubles> u;
    const Real scale = hn::Set(d, 32767.0);
    const Real one = hn::Set(d, 1.0);
    const auto code = hn::LoadU(u, codes);
    const auto first = hn::ShiftRight<16>(hn::BitCast(i, hn::ShiftLeft<16>(code)));
    const auto second = hn::ShiftRight<16>(hn::BitCast(i, code));
    const Real a = hn::Div(hn::PromoteTo(d, first), scale);
    const Real b = hn::Div(hn::PromoteTo(d, second), scale);
    const Real z = hn::Sub(hn::Sub(one, hn::Abs(a)), hn::Abs(b));
    const auto isBelow = hn::Lt(z, hn::Zero(d));
    const Real x = hn::IfThenElse(isBelow, hn::Mul(hn::Sub(one, hn::Abs(b)), signOf(a)), a);
    const Real y = hn::IfThenElse(isBelow, hn::Mul(hn::Sub(one, hn::Abs(a)), signOf(b)), b);
    return normalized({x, y, z});
}

} // namespace

void placeInWorldOn(
    const VertexBlock& block,
    std::size_t count,
    const hierarchy::Domain& domain,
    const glm::dmat3& normalMatrix,
    glm::dvec3* positions,
    glm::vec3* normals)
{
    const Doubles d;
    const hn::Rebind<float, Doubles> f;
    const Real unit = hn::Set(d, domain.gridUnit());
    std::array<std::array<double, VertexBlock::kSize>, 3> position;
    std::array<std::array<float, VertexBlock::kSize>, 3> normal;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const auto field = [&](std::size_t axis) HWY_ATTR {
            const Real grid = hn::LoadU(d, block.grid[axis].data() + first);
            return hn::Add(hn::Set(d, domain.origin[axis]), hn::Mul(unit, grid));
        };
        const Vectors p = times(domain.worldFromField.linear, {field(0), field(1), field(2)});
        const glm::dvec3& moved = domain.worldFromField.translation;
        hn::StoreU(hn::Add(p.x, hn::Set(d, moved.x)), d, position[0].data() + first);
        hn::StoreU(hn::Add(p.y, hn::Set(d, moved.y)), d, position[1].data() + first);
        hn::StoreU(hn::Add(p.z, hn::Set(d, moved.z)), d, position[2].data() + first);
        const Vectors n = normalized(times(normalMatrix, decoded(block.normal.data() + first)));
        hn::StoreU(hn::DemoteTo(f, n.x), f, normal[0].data() + first);
        hn::StoreU(hn::DemoteTo(f, n.y), f, normal[1].data() + first);
        hn::StoreU(hn::DemoteTo(f, n.z), f, normal[2].data() + first);
    }
    for (std::size_t i = 0; i < count; ++i) {
        positions[i] = {position[0][i], position[1][i], position[2][i]};
        normals[i] = {normal[0][i], normal[1][i], normal[2][i]};
    }
}

} // namespace isofront::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::surface {

HWY_EXPORT(placeInWorldOn);

void placeInWorld(
    const VertexBlock& block,
    std::size_t count,
    const hierarchy::Domain& domain,
    const glm::dmat3& normalMatrix,
    glm::dvec3* positions,
    glm::vec3* normals)
{
    HWY_DYNAMIC_DISPATCH(placeInWorldOn)(block, count, domain, normalMatrix, positions, normals);
}

} // namespace isofront::surface
#endif

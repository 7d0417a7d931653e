#include "TrilinearKernel.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "TrilinearKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::volume::detail::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DoubleTag = hn::CappedTag<double, kBlock>;
using IndexTag = hn::Rebind<std::int32_t, DoubleTag>;
using Doubles = hn::Vec<DoubleTag>;

template <bool kGuarded>
HWY_INLINE Doubles between(Doubles a, Doubles b, Doubles t)
{
    const Doubles mixed = hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
    if constexpr (kGuarded)
        return hn::IfThenElse(hn::Eq(t, hn::Zero(DoubleTag())), a, mixed);
    else
        return mixed;
}

template <bool kGuarded>
HWY_INLINE void interpolate(
    const CellCorners& corners,
    const BlockOf<double>& x,
    const BlockOf<double>& y,
    const BlockOf<double>& z,
    std::size_t count,
    double* out)
{
    const DoubleTag d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto corner = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, &corners[k][i]); };
        const Doubles tx = hn::LoadU(d, &x[i]);
        const Doubles ty = hn::LoadU(d, &y[i]);
        const Doubles low = between<kGuarded>(
            between<kGuarded>(corner(0), corner(1), tx),
            between<kGuarded>(corner(2), corner(3), tx),
            ty);
        const Doubles high = between<kGuarded>(
            between<kGuarded>(corner(4), corner(5), tx),
            between<kGuarded>(corner(6), corner(7), tx),
            ty);
        hn::StoreU(between<kGuarded>(low, high, hn::LoadU(d, &z[i])), d, out + i);
    }
}

} // namespace

void placeOn(const AxisCells& axis, const double* coordinates, std::size_t count, CellPlaces& out)
{
    const DoubleTag d;
    const IndexTag indexTag;
    const Doubles zero = hn::Zero(d);
    const Doubles limit = hn::Set(d, axis.limit);
    const Doubles scale = hn::Set(d, axis.scale);
    const Doubles lastCell = hn::Set(d, axis.lastCell);
    const Doubles lastRatio = hn::Set(d, axis.lastRatio);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Doubles given = hn::LoadU(d, coordinates + i);
        const Doubles below = hn::IfThenElse(hn::Lt(given, limit), given, limit);
        const Doubles inside = hn::IfThenElse(hn::Gt(given, zero), below, zero); // NaN is not above
        const Doubles position = hn::Mul(inside, scale);
        const auto cell =
            hn::Min(hn::DemoteTo(indexTag, position), hn::Set(indexTag, axis.lastCell));
        const Doubles whole = hn::PromoteTo(d, cell);
        const Doubles t = hn::Sub(position, whole);
        hn::StoreU(cell, indexTag, &out.cell[i]);
        hn::StoreU(hn::IfThenElse(hn::Eq(whole, lastCell), hn::Mul(t, lastRatio), t), d, &out.t[i]);
    }
}

void interpolateOn(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool guarded,
    double* out)
{
    if (guarded)
        interpolate<true>(corners, x.t, y.t, z.t, count, out);
    else
        interpolate<false>(corners, x.t, y.t, z.t, count, out);
}

} // namespace isofront::volume::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::volume::detail {

HWY_EXPORT(placeOn);
HWY_EXPORT(interpolateOn);

void placeInCells(
    const AxisCells& axis, const BlockOf<double>& coordinates, std::size_t count, CellPlaces& out)
{
    HWY_DYNAMIC_DISPATCH(placeOn)(axis, coordinates.data(), count, out);
}

void interpolateCells(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool guarded,
    BlockOf<double>& out)
{
    HWY_DYNAMIC_DISPATCH(interpolateOn)(corners, x, y, z, count, guarded, out.data());
}

} // namespace isofront::volume::detail
#endif

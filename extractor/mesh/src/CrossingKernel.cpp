#include "CrossingKernel.h"

#include "RoughMesh.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "CrossingKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::extractor::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, CrossingBlock::kSize>;
using Real = hn::Vec<Doubles>;

/// The sample points at some ends of edges [sample units]: exact, so in whatever order.
struct Points {
    std::array<Real, 3> axis;
};

HWY_INLINE Points pointsAt(
    const CrossingBlock::End& end,
    std::size_t first,
    const std::array<std::array<double, 3>, 4>& corners)
{
    const Doubles d;
    const hn::Rebind<std::uint32_t, Doubles> u;
    const hn::Rebind<std::int32_t, Doubles> i;
    hn::Vec<decltype(u)> w0;
    hn::Vec<decltype(u)> w1;
    hn::Vec<decltype(u)> w2;
    hn::Vec<decltype(u)> w3;
    hn::LoadInterleaved4(u, end.weights[first].data(), w0, w1, w2, w3);
    const Real a = hn::PromoteTo(d, hn::BitCast(i, w0));
    const Real b = hn::PromoteTo(d, hn::BitCast(i, w1));
    const Real c = hn::PromoteTo(d, hn::BitCast(i, w2));
    const Real e = hn::PromoteTo(d, hn::BitCast(i, w3));
    const auto along = [&](std::size_t axis) HWY_ATTR {
        return hn::Add(
            hn::Add(
                hn::Mul(a, hn::Set(d, corners[0][axis])), hn::Mul(b, hn::Set(d, corners[1][axis]))),
            hn::Add(
                hn::Mul(c, hn::Set(d, corners[2][axis])),
                hn::Mul(e, hn::Set(d, corners[3][axis]))));
    };
    return {{along(0), along(1), along(2)}};
}

/// The nearest whole number to one that is not negative, halves up.
HWY_INLINE Real rounded(Real value)
{
    const Doubles d;
    const Real whole = hn::Floor(value);
    const auto isUp = hn::Ge(hn::Sub(value, whole), hn::Set(d, 0.5));
    return hn::Add(whole, hn::IfThenElseZero(isUp, hn::Set(d, 1.0)));
}

} // namespace

void placeSharesOn(CrossingBlock& block, std::size_t count, double isovalue)
{
    const Doubles d;
    const hn::Rebind<float, Doubles> f;
    const Real level = hn::Set(d, isovalue);
    const Real least = hn::Set(d, kCrossingClamp);
    const Real most = hn::Set(d, 1.0 - kCrossingClamp);
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const Real in = hn::PromoteTo(d, hn::Load(f, block.inside.value.data() + first));
        const Real out = hn::PromoteTo(d, hn::Load(f, block.outside.value.data() + first));
        const Real above = hn::Sub(in, level);
        const Real below = hn::Sub(out, level);
        const Real share =
            hn::IfThenElse(hn::Lt(below, hn::Zero(d)), hn::Div(above, hn::Sub(above, below)), most);
        const Real t = hn::IfThenElse(
            hn::Lt(share, least), least, hn::IfThenElse(hn::Lt(most, share), most, share));
        hn::Store(t, d, block.t.data() + first);
    }
}

void placeCrossingsOn(
    CrossingBlock& block, std::size_t count, const std::array<std::array<double, 3>, 4>& corners)
{
    const Doubles d;
    for (std::size_t first = 0; first < count; first += hn::Lanes(d)) {
        const Points in = pointsAt(block.inside, first, corners);
        const Points out = pointsAt(block.outside, first, corners);
        const Real t = hn::Load(d, block.t.data() + first);
        const Real units = hn::Load(d, block.unitsPerSample.data() + first);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Real p =
                hn::Add(in.axis[axis], hn::Mul(t, hn::Sub(out.axis[axis], in.axis[axis])));
            hn::StoreU(rounded(hn::Mul(p, units)), d, block.position[axis].data() + first);
        }
    }
}

} // namespace isofront::extractor::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::extractor {

HWY_EXPORT(placeSharesOn);
HWY_EXPORT(placeCrossingsOn);

void placeShares(CrossingBlock& block, std::size_t count, double isovalue)
{
    HWY_DYNAMIC_DISPATCH(placeSharesOn)(block, count, isovalue);
}

void placeCrossings(
    CrossingBlock& block, std::size_t count, const std::array<std::array<double, 3>, 4>& corners)
{
    HWY_DYNAMIC_DISPATCH(placeCrossingsOn)(block, count, corners);
}

} // namespace isofront::extractor
#endif

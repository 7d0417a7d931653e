#include "FilterKernel.h"

#include "FilterBands.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "FilterKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::volume::detail::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kBlock>;
using Integers = hn::Rebind<std::int64_t, Doubles>;
using Real = hn::Vec<Doubles>;
using Whole = hn::Vec<Integers>;

constexpr int kMantissaBits = 52;

/// `smallExponential`
HWY_INLINE Real exponentialOf(Real u)
{
    const Doubles d;
    Real series = hn::Set(d, kExponentialSeries[0]);
    for (std::size_t i = 1; i < kExponentialSeries.size(); ++i)
        series = hn::Add(hn::Mul(series, u), hn::Set(d, kExponentialSeries[i]));
    return series;
}

HWY_INLINE Real stretchedOf(Real exponential)
{
    const Doubles d;
    const Real moved = hn::Mul(hn::Sub(exponential, hn::Set(d, kCut)), hn::Set(d, kStretch));
    return hn::Max(hn::Min(moved, hn::Set(d, 1.0)), hn::Zero(d));
}

HWY_INLINE Real fourthPower(Real value)
{
    const Real square = hn::Mul(value, value);
    return hn::Mul(square, square);
}

/// Where a radius stands that is multiplied by powers of two until it lies in (kPlainRadius / 2,
/// kPlainRadius]: the coarsest band that is damped, -1 for none, and the exponential there.
struct Damped {
    Whole band;
    Real exponential;
};

/// @param radius  kPlainRadius at least, and normal
HWY_INLINE Damped dampedAt(Real radius)
{
    const Doubles d;
    const Integers i;
    // Numbers compare like their bits, and a power of two is one more in those of the exponent.
    const Whole bits = hn::BitCast(i, radius);
    const Whole plain = hn::Set(i, std::bit_cast<std::int64_t>(kPlainRadius));
    const Whole above = hn::Sub(hn::Sub(bits, plain), hn::Set(i, 1));
    const Whole band = hn::ShiftRight<kMantissaBits>(above);
    const Real twice = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<kMantissaBits>(band)));
    const Real x = hn::Mul(hn::Set(d, kCyclesPerVoxel), twice);
    return {band, exponentialOf(hn::Mul(x, x))};
}

/// Radii between those up to which nothing is filtered and from which on only the top level is
/// left: others count as the nearer one of them, and NaN as the former.
HWY_INLINE Real withinLimits(Real radius, int top)
{
    const Doubles d;
    const Real least = hn::Set(d, kPlainRadius);
    const Real most = hn::Set(d, topRadius(top));
    const Real raised = hn::IfThenElse(hn::Gt(radius, least), radius, least);
    return hn::IfThenElse(hn::Lt(raised, most), raised, most);
}

} // namespace

void weighLevelsOn(const BlockOf<double>& radii, std::size_t count, int top, BlockWeights& out)
{
    const Doubles d;
    const Integers whole;
    const std::size_t lanes = hn::Lanes(d);
    Real least = withinLimits(hn::LoadU(d, radii.data()), top);
    Real most = least;
    for (std::size_t i = lanes; i < count; i += lanes) {
        const Real radius = withinLimits(hn::LoadU(d, &radii[i]), top);
        least = hn::Min(least, radius);
        most = hn::Max(most, radius);
    }
    // The bands below the first level are left out. They are so, beyond doubt, at a radius that is
    // a little smaller, so that rounding can't let one count at another point.
    constexpr double kLittle = 1e-9;
    const double leastRadius = (1 - kLittle) * hn::GetLane(hn::MinOfLanes(d, least));
    const double mostRadius = hn::GetLane(hn::MaxOfLanes(d, most));
    const int mostBand = coarsestDamped(mostRadius);
    out.first = levelWeights(leastRadius, top).first;
    out.end = std::min(mostBand + 1, top) + 1;

    const Real one = hn::Set(d, 1.0);
    for (std::size_t i = 0; i < count; i += lanes) {
        Damped damped = dampedAt(withinLimits(hn::LoadU(d, &radii[i]), top));
        Real coarser = one; // w of the band before
        // From coarse to fine, as the exponentials come.
        for (int band = mostBand; band >= out.first; --band) {
            const auto isDamped =
                hn::RebindMask(d, hn::Gt(damped.band, hn::Set(whole, std::int64_t{band} - 1)));
            if (band < top) {
                const Real weight = hn::IfThenElse(isDamped, stretchedOf(damped.exponential), one);
                auto& row = out.rows[static_cast<std::size_t>(band) + 1];
                hn::StoreU(hn::Sub(coarser, weight), d, &row[i]);
                coarser = weight;
            }
            damped.exponential =
                hn::IfThenElse(isDamped, fourthPower(damped.exponential), damped.exponential);
        }
        hn::StoreU(coarser, d, &out.rows[static_cast<std::size_t>(out.first)][i]);
    }
}

} // namespace isofront::volume::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::volume::detail {

HWY_EXPORT(weighLevelsOn);

void weighLevels(const double* radii, std::size_t count, int top, BlockWeights& out)
{
    BlockOf<double> padded;
    std::copy_n(radii, count, padded.begin());
    std::fill(padded.begin() + static_cast<std::ptrdiff_t>(count), padded.end(), radii[count - 1]);
    HWY_DYNAMIC_DISPATCH(weighLevelsOn)(padded, count, top, out);
}

} // namespace isofront::volume::detail
#endif

#include "HeightKernel.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "HeightKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

#ifndef ISOFRONT_HEIGHT_KERNEL
#define ISOFRONT_HEIGHT_KERNEL
namespace isofront::elevation {

constexpr double kPassing = 1.0 / 64; // below it the filter passes everything
constexpr double kStopping = 3.0;     // and from here on nothing

/// exp(-q) is the 16th power of its Taylor polynomial at q / 16 < 0.6, the highest power first.
constexpr std::array<double, 8> kSeries = {
    -1.0 / 5040, 1.0 / 720, -1.0 / 120, 1.0 / 24, -1.0 / 6, 0.5, -1.0, 1.0};

} // namespace isofront::elevation
#endif

HWY_BEFORE_NAMESPACE();
namespace isofront::elevation::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kBlock>;
using Integers = hn::Rebind<std::int32_t, Doubles>;
using Floats = hn::Rebind<float, Doubles>;
using Real = hn::Vec<Doubles>;

HWY_INLINE Real constant(double value)
{
    return hn::Set(Doubles(), value);
}

/// `filterWeight`
HWY_INLINE Real filterWeights(Real x)
{
    const Real t = hn::Mul(hn::Mul(x, x), constant(0.0625));
    Real power = constant(kSeries[0]);
    for (std::size_t i = 1; i < kSeries.size(); ++i)
        power = hn::Add(hn::Mul(power, t), constant(kSeries[i]));
    for (int i = 0; i < 4; ++i)
        power = hn::Mul(power, power);
    const Real stopped = hn::IfThenElseZero(hn::Lt(x, constant(kStopping)), power);
    return hn::IfThenElse(hn::Lt(x, constant(kPassing)), constant(1.0), stopped);
}

/// Weights of four posts in a row, and sums of posts by them.
struct Weights {
    Real a, b, c, d;

    [[nodiscard]] HWY_INLINE Real sum(Real p, Real q, Real r, Real s) const
    {
        return hn::Add(
            hn::Add(hn::Mul(a, p), hn::Mul(b, q)), hn::Add(hn::Mul(c, r), hn::Mul(d, s)));
    }
};

/// Between the middle two (Catmull-Rom).
HWY_INLINE Weights splineWeights(Real t)
{
    const Real half = constant(0.5);
    const Real square = hn::Mul(t, t);
    const Real steep = hn::Mul(constant(1.5), t);
    return {
        hn::Mul(t, hn::Sub(hn::Mul(t, hn::Sub(constant(1.0), hn::Mul(half, t))), half)),
        hn::Add(constant(1.0), hn::Mul(square, hn::Sub(steep, constant(2.5)))),
        hn::Mul(t, hn::Add(half, hn::Mul(t, hn::Sub(constant(2.0), steep)))),
        hn::Mul(square, hn::Sub(hn::Mul(half, t), half))};
}

/// Their derivatives.
HWY_INLINE Weights slopeWeights(Real t)
{
    const Real half = constant(0.5);
    const Real steep = hn::Mul(constant(1.5), t);
    const Real steeper = hn::Mul(constant(4.5), t);
    return {
        hn::Sub(hn::Mul(t, hn::Sub(constant(2.0), steep)), half),
        hn::Mul(t, hn::Sub(steeper, constant(5.0))),
        hn::Add(half, hn::Mul(t, hn::Sub(constant(4.0), steeper))),
        hn::Mul(t, hn::Sub(steep, constant(1.0)))};
}

/// Where points lie along one axis, in posts of the finest level.
HWY_INLINE void placePosts(
    const BlockOfDoubles& given,
    std::size_t count,
    double origin,
    double postsPerMetre,
    double last,
    BlockOfDoubles& out)
{
    const Doubles d;
    const Real zero = hn::Zero(d);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Real moved = hn::Sub(hn::LoadU(d, &given[i]), constant(origin));
        const Real post = hn::Mul(moved, constant(postsPerMetre));
        const Real below = hn::IfThenElse(hn::Lt(post, constant(last)), post, constant(last));
        // NaN is not above zero
        hn::StoreU(hn::IfThenElse(hn::Gt(post, zero), below, zero), d, &out[i]);
    }
}

/// The patches of one level in which a block's points lie: where in them, and their posts.
struct Patches {
    BlockOfDoubles s, t; ///< from 0 to 1 in the patch
    std::array<std::int32_t, kBlock> column, row;
    /// Four rows of four posts for each point.
    std::array<std::array<float, 4 * kBlock>, 4> posts;
};

HWY_INLINE void placeInPatches(
    const BlockOfDoubles& posts,
    std::size_t count,
    double scale,
    int nodes,
    std::array<std::int32_t, kBlock>& patch,
    BlockOfDoubles& rest)
{
    const Doubles d;
    const Integers whole;
    const auto last = hn::Set(whole, std::max(nodes - 2, 0));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Real place = hn::Mul(hn::LoadU(d, &posts[i]), constant(scale));
        const auto low = hn::Min(hn::DemoteTo(whole, place), last);
        hn::StoreU(low, whole, &patch[i]);
        hn::StoreU(hn::Sub(place, hn::PromoteTo(d, low)), d, &rest[i]);
    }
}

HWY_INLINE void lookUpPosts(const PaddedGrid& grid, std::size_t count, Patches& patches)
{
    for (std::size_t i = 0; i < count; ++i) {
        const float* post = grid.cornerOf(patches.column[i], patches.row[i]);
        for (std::size_t row = 0; row < 4; ++row, post += grid.stride())
            std::memcpy(&patches.posts[row][4 * i], post, 4 * sizeof(float));
    }
}

HWY_INLINE Real
sumOfRow(const Patches& patches, std::size_t row, std::size_t i, const Weights& weights)
{
    const Doubles d;
    const Floats f;
    hn::Vec<Floats> p;
    hn::Vec<Floats> q;
    hn::Vec<Floats> r;
    hn::Vec<Floats> s;
    hn::LoadInterleaved4(f, &patches.posts[row][4 * i], p, q, r, s);
    return weights.sum(
        hn::PromoteTo(d, p), hn::PromoteTo(d, q), hn::PromoteTo(d, r), hn::PromoteTo(d, s));
}

HWY_INLINE void addTo(BlockOfDoubles& sums, std::size_t i, Real share, Real value)
{
    const Doubles d;
    const Real before = hn::LoadU(d, &sums[i]);
    const Real after = hn::Add(before, hn::Mul(share, value));
    hn::StoreU(hn::IfThenElse(hn::Gt(share, hn::Zero(d)), after, before), d, &sums[i]);
}

template <bool kHasSlopes>
HWY_INLINE void addLevel(
    const Patches& patches,
    const BlockOfDoubles& shares,
    std::size_t count,
    double scale,
    HeightSlopes& out)
{
    const Doubles d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Real share = hn::LoadU(d, &shares[i]);
        if (hn::AllFalse(d, hn::Gt(share, hn::Zero(d))))
            continue;
        const Real s = hn::LoadU(d, &patches.s[i]);
        const Real t = hn::LoadU(d, &patches.t[i]);
        const Weights along = splineWeights(s);
        const Weights across = splineWeights(t);
        const Real a = sumOfRow(patches, 0, i, along);
        const Real b = sumOfRow(patches, 1, i, along);
        const Real c = sumOfRow(patches, 2, i, along);
        const Real e = sumOfRow(patches, 3, i, along);
        addTo(out.height, i, share, across.sum(a, b, c, e));
        if constexpr (kHasSlopes) {
            const Weights steep = slopeWeights(s);
            const Real scaled = hn::Mul(share, constant(scale));
            addTo(
                out.alongX,
                i,
                scaled,
                across.sum(
                    sumOfRow(patches, 0, i, steep),
                    sumOfRow(patches, 1, i, steep),
                    sumOfRow(patches, 2, i, steep),
                    sumOfRow(patches, 3, i, steep)));
            addTo(out.alongY, i, scaled, slopeWeights(t).sum(a, b, c, e));
        }
    }
}

/// How much a level counts at each point: its band's weight less that of the band before, which is
/// replaced by it.
/// @return whether it counts anywhere
HWY_INLINE bool weighLevel(
    const BlockOfDoubles& cycles,
    std::size_t count,
    double scale,
    bool isLast,
    BlockOfDoubles& before,
    BlockOfDoubles& shares)
{
    const Doubles d;
    bool counts = false;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Real x = hn::Mul(hn::LoadU(d, &cycles[i]), constant(scale));
        const Real weight = isLast ? constant(1.0) : filterWeights(x);
        const Real share = hn::Sub(weight, hn::LoadU(d, &before[i]));
        hn::StoreU(weight, d, &before[i]);
        hn::StoreU(share, d, &shares[i]);
        counts = counts || !hn::AllFalse(d, hn::Gt(share, hn::Zero(d)));
    }
    return counts;
}

HWY_INLINE bool areAllOne(const BlockOfDoubles& weights, std::size_t count)
{
    const Doubles d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d))
        if (!hn::AllTrue(d, hn::Ge(hn::LoadU(d, &weights[i]), constant(1.0))))
            return false;
    return true;
}

template <bool kHasSlopes>
void sumLevelsOf(const HeightLevels& levels, const HeightPoints& points, HeightSlopes& out)
{
    const std::size_t count = points.size;
    const glm::dvec2& origin = levels.origin;
    const glm::dvec2& perMetre = levels.postsPerMetre;
    BlockOfDoubles u;
    BlockOfDoubles v;
    placePosts(points.x, count, origin.x, perMetre.x, levels.lastPost.x, u);
    placePosts(points.y, count, origin.y, perMetre.y, levels.lastPost.y, v);
    BlockOfDoubles cycles;
    for (std::size_t i = 0; i < kBlock; ++i)
        cycles[i] = points.radius[i] * levels.cyclesPerMetre;
    BlockOfDoubles before{};
    out.height = {};
    if constexpr (kHasSlopes) {
        out.alongX = {};
        out.alongY = {};
    }
    Patches patches;
    BlockOfDoubles shares;
    double scale = 1; // of this level's posts to the finest
    for (std::size_t k = 0; k < levels.grids.size(); ++k, scale *= 0.5) {
        const PaddedGrid& grid = *levels.grids[k];
        if (weighLevel(cycles, count, scale, k + 1 == levels.grids.size(), before, shares)) {
            placeInPatches(u, count, scale, grid.columns, patches.column, patches.s);
            placeInPatches(v, count, scale, grid.rows, patches.row, patches.t);
            lookUpPosts(grid, count, patches);
            addLevel<kHasSlopes>(patches, shares, count, scale, out);
        }
        if (areAllOne(before, count))
            break;
    }
    if constexpr (kHasSlopes)
        for (std::size_t i = 0; i < kBlock; ++i) {
            out.alongX[i] *= perMetre.x;
            out.alongY[i] *= perMetre.y;
        }
}

} // namespace

void sumLevelsOn(
    const HeightLevels& levels, const HeightPoints& points, bool hasSlopes, HeightSlopes& out)
{
    if (hasSlopes)
        sumLevelsOf<true>(levels, points, out);
    else
        sumLevelsOf<false>(levels, points, out);
}

} // namespace isofront::elevation::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::elevation {

HWY_EXPORT(sumLevelsOn);

double filterWeight(double x)
{
    if (!(x < kStopping))
        return 0;
    if (x < kPassing)
        return 1;
    const double t = x * x * 0.0625;
    double power = kSeries[0];
    for (std::size_t i = 1; i < kSeries.size(); ++i)
        power = power * t + kSeries[i];
    for (int i = 0; i < 4; ++i)
        power *= power;
    return power;
}

void sumLevels(
    const HeightLevels& levels, const HeightPoints& points, bool hasSlopes, HeightSlopes& out)
{
    HWY_DYNAMIC_DISPATCH(sumLevelsOn)(levels, points, hasSlopes, out);
}

} // namespace isofront::elevation
#endif

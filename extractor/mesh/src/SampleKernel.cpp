#include "SampleKernel.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "SampleKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::extractor::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <typename Tag>
HWY_INLINE void placeGroup(
    Tag d,
    const std::array<const double*, 4>& weights,
    const std::array<std::array<double, 3>, 4>& corners,
    const std::array<double, 3>& origin,
    double unit,
    std::size_t first,
    const std::array<double*, 3>& targets)
{
    const auto a = hn::LoadU(d, weights[0] + first);
    const auto b = hn::LoadU(d, weights[1] + first);
    const auto c = hn::LoadU(d, weights[2] + first);
    const auto e = hn::LoadU(d, weights[3] + first);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // integers below 2^53 all the way, so the order of the sum doesn't matter
        const auto p = hn::Add(
            hn::Add(
                hn::Mul(a, hn::Set(d, corners[0][axis])), hn::Mul(b, hn::Set(d, corners[1][axis]))),
            hn::Add(
                hn::Mul(c, hn::Set(d, corners[2][axis])),
                hn::Mul(e, hn::Set(d, corners[3][axis]))));
        const auto field = hn::Add(hn::Set(d, origin[axis]), hn::Mul(hn::Set(d, unit), p));
        hn::StoreU(field, d, targets[axis] + first);
    }
}

} // namespace

void placePointsOn(
    const std::array<const double*, 4>& weights,
    const std::array<std::array<double, 3>, 4>& corners,
    const std::array<double, 3>& origin,
    double unit,
    std::size_t count,
    const std::array<double*, 3>& targets)
{
    const hn::ScalableTag<double> d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t first = 0;
    for (; first + lanes <= count; first += lanes)
        placeGroup(d, weights, corners, origin, unit, first, targets);
    for (; first < count; ++first)
        placeGroup(hn::CappedTag<double, 1>(), weights, corners, origin, unit, first, targets);
}

} // namespace isofront::extractor::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::extractor {

HWY_EXPORT(placePointsOn);

void placePoints(
    const std::array<const double*, 4>& weights,
    const std::array<std::array<double, 3>, 4>& corners,
    const std::array<double, 3>& origin,
    double unit,
    std::size_t count,
    const std::array<double*, 3>& targets)
{
    HWY_DYNAMIC_DISPATCH(placePointsOn)(weights, corners, origin, unit, count, targets);
}

} // namespace isofront::extractor
#endif

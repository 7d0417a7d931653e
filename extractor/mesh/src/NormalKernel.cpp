#include "NormalKernel.h"

#include <limits>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "NormalKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::extractor::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// 1 with the sign of a number; zeros of either sign count as positive.
template <typename Tag>
HWY_INLINE hn::Vec<Tag> signOf(Tag d, hn::Vec<Tag> value)
{
    const auto one = hn::Set(d, 1.0);
    return hn::IfThenElse(hn::Lt(value, hn::Zero(d)), hn::Neg(one), one);
}

/// A coordinate in [-1, 1] as a number of 16 bits, halves away from zero.
template <typename Tag>
HWY_INLINE hn::Vec<hn::Rebind<std::int32_t, Tag>> codeOf(Tag d, hn::Vec<Tag> value)
{
    const auto one = hn::Set(d, 1.0);
    const auto half = hn::Set(d, 0.5);
    const auto clamped = hn::IfThenElse(
        hn::Lt(value, hn::Neg(one)), hn::Neg(one), hn::IfThenElse(hn::Lt(one, value), one, value));
    const auto scaled = hn::Mul(clamped, hn::Set(d, 32767.0));
    const auto whole = hn::Trunc(scaled);
    const auto rest = hn::Sub(scaled, whole);
    const auto up = hn::IfThenElseZero(hn::Ge(rest, half), one);
    const auto down = hn::IfThenElseZero(hn::Le(rest, hn::Neg(half)), one);
    return hn::DemoteTo(hn::Rebind<std::int32_t, Tag>(), hn::Sub(hn::Add(whole, up), down));
}

template <typename Tag>
HWY_INLINE void encodeGroup(
    Tag d, const std::array<const double*, 3>& gradients, std::size_t first, std::uint32_t* codes)
{
    const hn::Rebind<std::int32_t, Tag> i;
    const hn::Rebind<std::uint32_t, Tag> u;
    const auto gx = hn::LoadU(d, gradients[0] + first);
    const auto gy = hn::LoadU(d, gradients[1] + first);
    const auto gz = hn::LoadU(d, gradients[2] + first);
    const auto one = hn::Set(d, 1.0);
    const auto zero = hn::Zero(d);

    // scaled first: squares must neither vanish nor overflow
    const auto largest = hn::Max(hn::Max(hn::Abs(gx), hn::Abs(gy)), hn::Abs(gz));
    const auto all = hn::Add(hn::Add(gx, gy), gz); // NaN passes through, unlike above
    const auto isKnown = hn::And(
        hn::And(
            hn::Gt(largest, zero),
            hn::Lt(largest, hn::Set(d, std::numeric_limits<double>::infinity()))),
        hn::Eq(all, all));
    const auto sx = hn::IfThenElse(isKnown, hn::Div(hn::Neg(gx), largest), one);
    const auto sy = hn::IfThenElse(isKnown, hn::Div(hn::Neg(gy), largest), one);
    const auto sz = hn::IfThenElse(isKnown, hn::Div(hn::Neg(gz), largest), one);
    const auto squared = hn::Add(hn::Add(hn::Mul(sx, sx), hn::Mul(sy, sy)), hn::Mul(sz, sz));
    const auto scale = hn::Div(one, hn::Sqrt(squared));
    const auto x = hn::Mul(sx, scale);
    const auto y = hn::Mul(sy, scale);
    const auto z = hn::Mul(sz, scale);

    const auto sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
    const auto a = hn::Div(x, sum);
    const auto b = hn::Div(y, sum);
    const auto isBelow = hn::Lt(z, zero);
    const auto p = hn::IfThenElse(isBelow, hn::Mul(hn::Sub(one, hn::Abs(b)), signOf(d, a)), a);
    const auto q = hn::IfThenElse(isBelow, hn::Mul(hn::Sub(one, hn::Abs(a)), signOf(d, b)), b);

    const auto low = hn::And(hn::BitCast(u, codeOf(d, p)), hn::Set(u, 0xFFFFU));
    const auto high = hn::ShiftLeft<16>(hn::BitCast(u, codeOf(d, q)));
    // the mask narrowed by numbers, which every instruction set can do
    const auto known = hn::DemoteTo(i, hn::IfThenElseZero(isKnown, one));
    const auto isUnknown = hn::Eq(hn::BitCast(u, known), hn::Zero(u));
    hn::StoreU(
        hn::IfThenElse(isUnknown, hn::Set(u, kNoNormalCode), hn::Or(low, high)), u, codes + first);
}

} // namespace

void encodeNormalsOn(
    const std::array<const double*, 3>& gradients, std::size_t count, std::uint32_t* codes)
{
    const hn::ScalableTag<double> d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t first = 0;
    for (; first + lanes <= count; first += lanes)
        encodeGroup(d, gradients, first, codes);
    for (; first < count; ++first)
        encodeGroup(hn::CappedTag<double, 1>(), gradients, first, codes);
}

} // namespace isofront::extractor::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::extractor {

HWY_EXPORT(encodeNormalsOn);

void encodeNormals(
    const std::array<const double*, 3>& gradients, std::size_t count, std::uint32_t* codes)
{
    HWY_DYNAMIC_DISPATCH(encodeNormalsOn)(gradients, count, codes);
}

} // namespace isofront::extractor
#endif

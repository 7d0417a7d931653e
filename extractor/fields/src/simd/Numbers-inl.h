// Included once for each instruction set: a formula written once for a template number `N` gives
// its value (Value), an interval that encloses it over a box (Range), or its value and gradient
// (Slope), for as many points at once as a vector has lanes of float.
//
// No operation here rounds differently from one instruction set to another: additions, products,
// divisions, square roots and comparisons only, never a fused multiply-add or an approximation.

#if defined(ISOFRONT_FIELDS_NUMBERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_NUMBERS_INL_H
#undef ISOFRONT_FIELDS_NUMBERS_INL_H
#else
#define ISOFRONT_FIELDS_NUMBERS_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
#if HWY_TARGET == HWY_SCALAR
using DoubleTag = hn::Rebind<double, FloatTag>;
#else
using DoubleTag = hn::Repartition<double, FloatTag>;
#endif
using HalfTag = hn::Rebind<float, DoubleTag>;
using WordTag = hn::RebindToUnsigned<FloatTag>;
using SignedTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Doubles = hn::Vec<DoubleTag>;
using Words = hn::Vec<WordTag>;

HWY_INLINE Floats constant(float value)
{
    return hn::Set(FloatTag(), value);
}

/// One double for each lane of float. With a single lane both halves hold the same.
struct DoublePair {
    Doubles first;
    Doubles second;
};

HWY_INLINE Floats narrowed(const DoublePair& pair)
{
    const HalfTag half;
#if HWY_TARGET == HWY_SCALAR
    return hn::DemoteTo(half, pair.first);
#else
    return hn::Combine(FloatTag(), hn::DemoteTo(half, pair.second), hn::DemoteTo(half, pair.first));
#endif
}

HWY_INLINE DoublePair widened(Floats value)
{
#if HWY_TARGET == HWY_SCALAR
    const Doubles wide = hn::PromoteTo(DoubleTag(), value);
    return {wide, wide};
#else
    const HalfTag half;
    return {
        hn::PromoteTo(DoubleTag(), hn::LowerHalf(half, value)),
        hn::PromoteTo(DoubleTag(), hn::UpperHalf(half, value))};
#endif
}

HWY_INLINE DoublePair operator+(const DoublePair& a, const DoublePair& b)
{
    return {hn::Add(a.first, b.first), hn::Add(a.second, b.second)};
}

// ---- The three kinds of number ------------------------------------------------------------------

struct Value {
    Floats v;
};

struct Range {
    Floats low;
    Floats high;
};

struct Slope {
    Floats v;
    Floats x;
    Floats y;
    Floats z;
};

template <typename N>
N fromConstant(float value);
template <>
HWY_INLINE Value fromConstant<Value>(float value)
{
    return {constant(value)};
}
template <>
HWY_INLINE Range fromConstant<Range>(float value)
{
    return {constant(value), constant(value)};
}
template <>
HWY_INLINE Slope fromConstant<Slope>(float value)
{
    const Floats zero = hn::Zero(FloatTag());
    return {constant(value), zero, zero, zero};
}

// ---- Sums ---------------------------------------------------------------------------------------

HWY_INLINE Value operator+(const Value& a, const Value& b)
{
    return {hn::Add(a.v, b.v)};
}
HWY_INLINE Range operator+(const Range& a, const Range& b)
{
    return {hn::Add(a.low, b.low), hn::Add(a.high, b.high)};
}
HWY_INLINE Slope operator+(const Slope& a, const Slope& b)
{
    return {hn::Add(a.v, b.v), hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

HWY_INLINE Value operator-(const Value& a, const Value& b)
{
    return {hn::Sub(a.v, b.v)};
}
HWY_INLINE Range operator-(const Range& a, const Range& b)
{
    return {hn::Sub(a.low, b.high), hn::Sub(a.high, b.low)};
}
HWY_INLINE Slope operator-(const Slope& a, const Slope& b)
{
    return {hn::Sub(a.v, b.v), hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

template <typename N>
HWY_INLINE N operator+(const N& a, float b)
{
    return a + fromConstant<N>(b);
}
template <typename N>
HWY_INLINE N operator-(const N& a, float b)
{
    return a - fromConstant<N>(b);
}
template <typename N>
HWY_INLINE N operator-(float a, const N& b)
{
    return fromConstant<N>(a) - b;
}

// ---- Products -----------------------------------------------------------------------------------

HWY_INLINE Value operator*(const Value& a, const Value& b)
{
    return {hn::Mul(a.v, b.v)};
}
HWY_INLINE Range operator*(const Range& a, const Range& b)
{
    const Floats ll = hn::Mul(a.low, b.low);
    const Floats lh = hn::Mul(a.low, b.high);
    const Floats hl = hn::Mul(a.high, b.low);
    const Floats hh = hn::Mul(a.high, b.high);
    return {hn::Min(hn::Min(ll, lh), hn::Min(hl, hh)), hn::Max(hn::Max(ll, lh), hn::Max(hl, hh))};
}
HWY_INLINE Slope operator*(const Slope& a, const Slope& b)
{
    const auto sum = [&](Floats da, Floats db)
                         HWY_ATTR { return hn::Add(hn::Mul(da, b.v), hn::Mul(a.v, db)); };
    return {hn::Mul(a.v, b.v), sum(a.x, b.x), sum(a.y, b.y), sum(a.z, b.z)};
}

HWY_INLINE Value operator*(const Value& a, float b)
{
    return {hn::Mul(a.v, constant(b))};
}
HWY_INLINE Range operator*(const Range& a, float b)
{
    const Floats p = hn::Mul(a.low, constant(b));
    const Floats q = hn::Mul(a.high, constant(b));
    return {hn::Min(p, q), hn::Max(p, q)};
}
HWY_INLINE Slope operator*(const Slope& a, float b)
{
    const Floats f = constant(b);
    return {hn::Mul(a.v, f), hn::Mul(a.x, f), hn::Mul(a.y, f), hn::Mul(a.z, f)};
}

/// Scales the derivatives of a number whose value has been mapped.
HWY_INLINE Slope mapped(const Slope& a, Floats value, Floats derivative)
{
    return {value, hn::Mul(a.x, derivative), hn::Mul(a.y, derivative), hn::Mul(a.z, derivative)};
}

HWY_INLINE Slope selected(hn::Mask<FloatTag> mask, const Slope& yes, const Slope& no)
{
    return {
        hn::IfThenElse(mask, yes.v, no.v),
        hn::IfThenElse(mask, yes.x, no.x),
        hn::IfThenElse(mask, yes.y, no.y),
        hn::IfThenElse(mask, yes.z, no.z)};
}

// ---- Least and most -----------------------------------------------------------------------------

HWY_INLINE Value least(const Value& a, const Value& b)
{
    return {hn::Min(a.v, b.v)};
}
HWY_INLINE Range least(const Range& a, const Range& b)
{
    return {hn::Min(a.low, b.low), hn::Min(a.high, b.high)};
}
HWY_INLINE Slope least(const Slope& a, const Slope& b)
{
    return selected(hn::Lt(a.v, b.v), a, b);
}

HWY_INLINE Value most(const Value& a, const Value& b)
{
    return {hn::Max(a.v, b.v)};
}
HWY_INLINE Range most(const Range& a, const Range& b)
{
    return {hn::Max(a.low, b.low), hn::Max(a.high, b.high)};
}
HWY_INLINE Slope most(const Slope& a, const Slope& b)
{
    return selected(hn::Gt(a.v, b.v), a, b);
}

// ---- Magnitude, square and root -----------------------------------------------------------------

HWY_INLINE Value magnitude(const Value& a)
{
    return {hn::Abs(a.v)};
}
HWY_INLINE Range magnitude(const Range& a)
{
    const Floats zero = hn::Zero(FloatTag());
    return {hn::Max(zero, hn::Max(a.low, hn::Neg(a.high))), hn::Max(hn::Neg(a.low), a.high)};
}
HWY_INLINE Slope magnitude(const Slope& a)
{
    const Floats sign =
        hn::IfThenElse(hn::Lt(a.v, hn::Zero(FloatTag())), constant(-1.0F), constant(1.0F));
    return mapped(a, hn::Abs(a.v), sign);
}

HWY_INLINE Value squared(const Value& a)
{
    return a * a;
}
HWY_INLINE Range squared(const Range& a)
{
    const Range m = magnitude(a);
    return {hn::Mul(m.low, m.low), hn::Mul(m.high, m.high)};
}
HWY_INLINE Slope squared(const Slope& a)
{
    return a * a;
}

/// The square root of a number that is nowhere below zero.
HWY_INLINE Value root(const Value& a)
{
    return {hn::Sqrt(a.v)};
}
HWY_INLINE Range root(const Range& a)
{
    return {hn::Sqrt(a.low), hn::Sqrt(a.high)};
}
HWY_INLINE Slope root(const Slope& a)
{
    const Floats value = hn::Sqrt(a.v);
    // At zero the root has no slope; a large finite one keeps the gradient usable.
    const Floats safe = hn::Max(value, constant(1e-6F));
    return mapped(a, value, hn::Div(constant(0.5F), safe));
}

// ---- Smooth steps and joins ---------------------------------------------------------------------

/// 0 below `begin`, 1 above `end`, a cubic between.
HWY_INLINE Value smoothStep(const Value& a, float begin, float end)
{
    const Floats scaled = hn::Mul(hn::Sub(a.v, constant(begin)), constant(1.0F / (end - begin)));
    const Floats t = hn::Min(hn::Max(scaled, hn::Zero(FloatTag())), constant(1.0F));
    return {hn::Mul(hn::Mul(t, t), hn::Sub(constant(3.0F), hn::Add(t, t)))};
}
HWY_INLINE Range smoothStep(const Range& a, float begin, float end)
{
    return {smoothStep(Value{a.low}, begin, end).v, smoothStep(Value{a.high}, begin, end).v};
}
HWY_INLINE Slope smoothStep(const Slope& a, float begin, float end)
{
    const float scale = 1.0F / (end - begin);
    const Floats scaled = hn::Mul(hn::Sub(a.v, constant(begin)), constant(scale));
    const Floats t = hn::Min(hn::Max(scaled, hn::Zero(FloatTag())), constant(1.0F));
    const Floats slope = hn::Mul(constant(6.0F * scale), hn::Mul(t, hn::Sub(constant(1.0F), t)));
    return mapped(a, hn::Mul(hn::Mul(t, t), hn::Sub(constant(3.0F), hn::Add(t, t))), slope);
}

/// The lesser of two numbers, rounded off where they differ by less than `width`; there it lies up
/// to `width / 4` below both. Grows with either number.
HWY_INLINE Value smoothLeast(const Value& a, const Value& b, float width)
{
    const Floats zero = hn::Zero(FloatTag());
    const Floats overlap = hn::Max(zero, hn::Sub(constant(width), hn::Abs(hn::Sub(a.v, b.v))));
    return {
        hn::Sub(hn::Min(a.v, b.v), hn::Mul(hn::Mul(overlap, overlap), constant(0.25F / width)))};
}
HWY_INLINE Range smoothLeast(const Range& a, const Range& b, float width)
{
    return {
        smoothLeast(Value{a.low}, Value{b.low}, width).v,
        smoothLeast(Value{a.high}, Value{b.high}, width).v};
}
HWY_INLINE Slope smoothLeast(const Slope& a, const Slope& b, float width)
{
    // In the same order as above, so that the value has the same bits.
    const Slope overlap = most(fromConstant<Slope>(0.0F), width - magnitude(a - b));
    return least(a, b) - squared(overlap) * (0.25F / width);
}

template <typename N>
HWY_INLINE N smoothMost(const N& a, const N& b, float width)
{
    const N zero = fromConstant<N>(0.0F);
    return zero - smoothLeast(zero - a, zero - b, width);
}

// ---- Where formulas may stop --------------------------------------------------------------------

/// True if the number, known to be nowhere below zero, is zero in every lane, with all that it
/// carries.
HWY_INLINE bool vanishes(const Value& a)
{
    return hn::AllFalse(FloatTag(), hn::Gt(a.v, hn::Zero(FloatTag())));
}
HWY_INLINE bool vanishes(const Range& a)
{
    return vanishes(Value{a.high});
}
HWY_INLINE bool vanishes(const Slope& a)
{
    // Just before its end a smooth step is rounded to 1 while it still has a slope.
    const Floats zero = hn::Zero(FloatTag());
    const Floats slope = hn::Max(hn::Max(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z));
    return vanishes(Value{a.v}) && hn::AllTrue(FloatTag(), hn::Eq(slope, zero));
}

// ---- Filter weights -----------------------------------------------------------------------------

/// The filter radius in each lane [field]; `low` and `high` differ only for Range.
struct Radius {
    Floats low;
    Floats high;
};

/// exp(-x * x), lowered by a straight line in x * x that makes it zero from x = 3 on: at most
/// 1.3e-4 below the exponential, falling, continuous, and exactly 1 at 0.
HWY_INLINE Floats filterWeight(Floats x)
{
    constexpr float kCutoff = 9.0F;
    constexpr float kLine = 1.2340980e-4F / kCutoff;
    const FloatTag d;
    const Floats square = hn::Mul(x, x);
    if (hn::AllFalse(d, hn::Gt(square, hn::Zero(d))))
        return constant(1.0F);
    const Floats u = hn::Min(square, constant(kCutoff));
    // exp(-u) = 2^-n e^-g with whole n and 0 <= g < log 2; the Taylor series of e^-g is good to
    // 1e-7 there.
    const Floats t = hn::Mul(u, constant(1.44269504F));
    const Floats n = hn::Floor(t);
    const Floats g = hn::Mul(hn::Sub(t, n), constant(0.693147181F));
    Floats series = constant(2.48015873e-5F);
    series = hn::Sub(constant(1.98412698e-4F), hn::Mul(series, g));
    series = hn::Sub(constant(1.38888889e-3F), hn::Mul(series, g));
    series = hn::Sub(constant(8.33333333e-3F), hn::Mul(series, g));
    series = hn::Sub(constant(4.16666667e-2F), hn::Mul(series, g));
    series = hn::Sub(constant(1.66666667e-1F), hn::Mul(series, g));
    series = hn::Sub(constant(0.5F), hn::Mul(series, g));
    series = hn::Sub(constant(1.0F), hn::Mul(series, g));
    series = hn::Sub(constant(1.0F), hn::Mul(series, g));
    const SignedTag signedTag;
    const auto exponent = hn::Sub(hn::Set(signedTag, 127), hn::ConvertTo(signedTag, n));
    const Floats power = hn::BitCast(d, hn::ShiftLeft<23>(exponent));
    const Floats weight = hn::Sub(hn::Mul(series, power), hn::Mul(u, constant(kLine)));
    return hn::IfThenElseZero(hn::Lt(square, constant(kCutoff)), hn::Max(weight, hn::Zero(d)));
}

template <typename N>
N weight(const Radius& radius, float filterCycles);
template <>
HWY_INLINE Value weight<Value>(const Radius& radius, float filterCycles)
{
    return {filterWeight(hn::Mul(radius.low, constant(filterCycles)))};
}
template <>
HWY_INLINE Range weight<Range>(const Radius& radius, float filterCycles)
{
    return {
        filterWeight(hn::Mul(radius.high, constant(filterCycles))),
        filterWeight(hn::Mul(radius.low, constant(filterCycles)))};
}
template <>
HWY_INLINE Slope weight<Slope>(const Radius& radius, float filterCycles)
{
    const Floats zero = hn::Zero(FloatTag());
    return {filterWeight(hn::Mul(radius.low, constant(filterCycles))), zero, zero, zero};
}

// ---- Coordinates --------------------------------------------------------------------------------

/// A coordinate of a point as a number: in double, and with what the number adds to a value. How a
/// coordinate differs over a box (Range: +- extent) or changes with x, y and z (Slope).
template <typename N>
struct Coordinate;
template <>
struct Coordinate<Value> {
    DoublePair at;
};
template <>
struct Coordinate<Range> {
    DoublePair at;
    Floats extent;
};
template <>
struct Coordinate<Slope> {
    DoublePair at;
    Floats x;
    Floats y;
    Floats z;
};

template <typename N>
struct Point {
    Coordinate<N> x;
    Coordinate<N> y;
    Coordinate<N> z;
};

HWY_INLINE Coordinate<Value> operator+(const Coordinate<Value>& c, const Value& n)
{
    return {c.at + widened(n.v)};
}
HWY_INLINE Coordinate<Range> operator+(const Coordinate<Range>& c, const Range& n)
{
    const Floats half = constant(0.5F);
    const Floats middle = hn::Mul(half, hn::Add(n.low, n.high));
    const Floats reach = hn::Max(hn::Sub(n.high, middle), hn::Sub(middle, n.low));
    return {c.at + widened(middle), hn::Add(c.extent, reach)};
}
HWY_INLINE Coordinate<Slope> operator+(const Coordinate<Slope>& c, const Slope& n)
{
    return {c.at + widened(n.v), hn::Add(c.x, n.x), hn::Add(c.y, n.y), hn::Add(c.z, n.z)};
}

/// The coordinate as a number in float.
HWY_INLINE Value asNumber(const Coordinate<Value>& c)
{
    return {narrowed(c.at)};
}
HWY_INLINE Range asNumber(const Coordinate<Range>& c)
{
    const Floats at = narrowed(c.at);
    return {hn::Sub(at, c.extent), hn::Add(at, c.extent)};
}
HWY_INLINE Slope asNumber(const Coordinate<Slope>& c)
{
    return {narrowed(c.at), c.x, c.y, c.z};
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

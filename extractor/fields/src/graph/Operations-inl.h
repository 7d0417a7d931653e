// What the instructions of a program do to a number, for each kind of number and instruction set.

#if defined(ISOFRONT_FIELDS_GRAPH_OPERATIONS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRAPH_OPERATIONS_INL_H
#undef ISOFRONT_FIELDS_GRAPH_OPERATIONS_INL_H
#else
#define ISOFRONT_FIELDS_GRAPH_OPERATIONS_INL_H
#endif

#include "graph/MachineNumbers-inl.h"
#include "graph/Program.h"
#include "simd/Noise-inl.h"

#include <cmath>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

// ---- What rounding adds to ranges ---------------------------------------------------------------

// A single rounded operation is as monotone as the exact one, so the rounded ends enclose all
// rounded values. Where more than one rounding comes together, a range is widened.

HWY_INLINE Value outward(const Value& n, float /*slack*/)
{
    return n;
}
HWY_INLINE Slope outward(const Slope& n, float /*slack*/)
{
    return n;
}
HWY_INLINE Range outward(const Range& n, float slack)
{
    const Floats ulps = constant(5e-7F);
    const Floats s = constant(slack);
    return {
        hn::Sub(n.low, hn::Add(hn::Mul(hn::Abs(n.low), ulps), s)),
        hn::Add(n.high, hn::Add(hn::Mul(hn::Abs(n.high), ulps), s))};
}

template <typename N>
HWY_INLINE N stepped(const N& a, float begin, float end)
{
    return smoothStep(a, begin, end);
}
template <>
HWY_INLINE Range stepped(const Range& a, float begin, float end)
{
    // A step that has ended is exactly 0 or 1 and must stay so: factors are left out by it.
    const Range exact = smoothStep(a, begin, end);
    const Range wide = outward(exact, 0.0F);
    const Mask flat = hn::Eq(exact.low, exact.high);
    return {hn::IfThenElse(flat, exact.low, wide.low), hn::IfThenElse(flat, exact.high, wide.high)};
}

template <typename N>
HWY_INLINE N weighted(const Radius& radius, float cycles)
{
    return weight<N>(radius, cycles);
}
template <>
HWY_INLINE Range weighted<Range>(const Radius& radius, float cycles)
{
    const Range exact = weight<Range>(radius, cycles);
    const Floats zero = hn::Zero(FloatTag());
    const Floats slack = constant(1e-6F);
    return {
        hn::Max(zero, hn::Sub(exact.low, slack)),
        hn::IfThenElseZero(hn::Gt(exact.high, zero), hn::Add(exact.high, slack))};
}

template <typename N>
HWY_INLINE N placeAsNumber(const Coordinate<N>& c)
{
    return asNumber(c);
}
template <>
HWY_INLINE Range placeAsNumber(const Coordinate<Range>& c)
{
    const Floats rounding = hn::Mul(hn::Abs(narrowed(c.at)), constant(3e-7F));
    return asNumber(Coordinate<Range>{c.at, hn::Add(c.extent, hn::Add(rounding, rounding))});
}

// ---- Moved places -------------------------------------------------------------------------------

/// Twice the relative error of a few operations in float.
inline constexpr float kGrown = 1.000001F;

template <typename N>
HWY_INLINE Coordinate<N> moved(const Coordinate<N>& c, const N& by)
{
    return c + by;
}
template <>
HWY_INLINE Coordinate<Range> moved(const Coordinate<Range>& c, const Range& by)
{
    Coordinate<Range> sum = c + by;
    sum.extent = hn::Mul(sum.extent, constant(kGrown));
    return sum;
}

HWY_INLINE DoublePair within(const DoublePair& at, double origin, double inverse)
{
    const DoubleTag d;
    const Doubles o = hn::Set(d, origin);
    const Doubles i = hn::Set(d, inverse);
    return {hn::Mul(hn::Sub(at.first, o), i), hn::Mul(hn::Sub(at.second, o), i)};
}
HWY_INLINE Coordinate<Value> placedAt(const Coordinate<Value>& c, double origin, double inverse)
{
    return {within(c.at, origin, inverse)};
}
HWY_INLINE Coordinate<Range> placedAt(const Coordinate<Range>& c, double origin, double inverse)
{
    const auto factor = static_cast<float>(inverse);
    // What the difference loses in double.
    const Floats lost = hn::Mul(
        hn::Add(hn::Abs(narrowed(c.at)), constant(static_cast<float>(std::abs(origin)))),
        constant(1e-15F));
    return {
        within(c.at, origin, inverse), hn::Mul(hn::Add(c.extent, lost), constant(factor * kGrown))};
}
HWY_INLINE Coordinate<Slope> placedAt(const Coordinate<Slope>& c, double origin, double inverse)
{
    const Floats f = constant(static_cast<float>(inverse));
    return {within(c.at, origin, inverse), hn::Mul(c.x, f), hn::Mul(c.y, f), hn::Mul(c.z, f)};
}

// ---- Tests --------------------------------------------------------------------------------------

HWY_INLINE Mask decided(const Value& n, Test test, float threshold)
{
    const Floats t = constant(threshold);
    switch (test) {
    case Test::below:
        return hn::Lt(n.v, t);
    case Test::above:
        return hn::Gt(n.v, t);
    case Test::beyond:
        return hn::Gt(hn::Abs(n.v), t);
    case Test::zero:
        break;
    }
    return hn::Eq(n.v, hn::Zero(FloatTag()));
}
HWY_INLINE Mask decided(const Range& n, Test test, float threshold)
{
    const Floats t = constant(threshold);
    const Floats zero = hn::Zero(FloatTag());
    switch (test) {
    case Test::below:
        return hn::Lt(n.high, t);
    case Test::above:
        return hn::Gt(n.low, t);
    case Test::beyond:
        return hn::Or(hn::Gt(n.low, t), hn::Lt(n.high, hn::Neg(t)));
    case Test::zero:
        break;
    }
    return hn::And(hn::Eq(n.low, zero), hn::Eq(n.high, zero));
}
HWY_INLINE Mask decided(const Slope& n, Test test, float threshold)
{
    const Mask value = decided(Value{n.v}, test, threshold);
    if (test != Test::zero)
        return value;
    const Floats slope = hn::Max(hn::Max(hn::Abs(n.x), hn::Abs(n.y)), hn::Abs(n.z));
    return hn::And(value, hn::Eq(slope, hn::Zero(FloatTag())));
}

HWY_INLINE Value chosen(Mask mask, const Value& yes, const Value& no)
{
    return {hn::IfThenElse(mask, yes.v, no.v)};
}
HWY_INLINE Range chosen(Mask mask, const Range& yes, const Range& no)
{
    return {hn::IfThenElse(mask, yes.low, no.low), hn::IfThenElse(mask, yes.high, no.high)};
}
HWY_INLINE Slope chosen(Mask mask, const Slope& yes, const Slope& no)
{
    return selected(mask, yes, no);
}

// ---- Curves -------------------------------------------------------------------------------------

struct CurveSpan {
    const CurvePiece* pieces;
    std::size_t count;
};

struct CurveSample {
    Floats value;
    Floats slope;
};
HWY_INLINE CurveSample curveAt(const CurveSpan& curve, Floats x)
{
    CurveSample sample{constant(curve.pieces[0].coefficients[0]), hn::Zero(FloatTag())};
    for (std::size_t i = 0; i < curve.count; ++i) {
        const CurvePiece& piece = curve.pieces[i];
        const auto c = [&](std::size_t k) HWY_ATTR { return constant(piece.coefficients[k]); };
        const Mask here = hn::Ge(x, constant(piece.begin));
        const Floats t = hn::Sub(x, constant(piece.begin));
        const Floats inner = hn::Add(c(2), hn::Mul(t, c(3)));
        const Floats value = hn::Add(c(0), hn::Mul(t, hn::Add(c(1), hn::Mul(t, inner))));
        // Rounding must not leave what lies between the two points.
        const Floats kept = hn::Min(hn::Max(value, constant(piece.low)), constant(piece.high));
        const Floats slope = hn::Add(
            c(1),
            hn::Mul(t, hn::Add(hn::Add(c(2), c(2)), hn::Mul(t, hn::Mul(constant(3.0F), c(3))))));
        sample.value = hn::IfThenElse(here, kept, sample.value);
        sample.slope = hn::IfThenElse(here, slope, sample.slope);
    }
    return sample;
}
HWY_INLINE Value curved(const CurveSpan& curve, const Value& a)
{
    return {curveAt(curve, a.v).value};
}
HWY_INLINE Slope curved(const CurveSpan& curve, const Slope& a)
{
    const CurveSample sample = curveAt(curve, a.v);
    return mapped(a, sample.value, sample.slope);
}
HWY_INLINE Range curved(const CurveSpan& curve, const Range& a)
{
    // Between points it is monotone: the ends of the range, and the points within.
    const Floats atLow = curveAt(curve, a.low).value;
    const Floats atHigh = curveAt(curve, a.high).value;
    Floats low = hn::Min(atLow, atHigh);
    Floats high = hn::Max(atLow, atHigh);
    for (std::size_t i = 0; i < curve.count; ++i) {
        const Floats at = constant(curve.pieces[i].begin);
        const Floats value = constant(curve.pieces[i].coefficients[0]);
        const Mask inside = hn::And(hn::Le(a.low, at), hn::Le(at, a.high));
        low = hn::IfThenElse(inside, hn::Min(low, value), low);
        high = hn::IfThenElse(inside, hn::Max(high, value), high);
    }
    return {low, high};
}

// ---- Noise --------------------------------------------------------------------------------------

/// A kind of noise as a function: programs say which while they run.
template <typename N, typename Octave>
using NoiseCall = N (*)(const Octave&, const Point<N>&);

template <typename N, typename Octave>
HWY_INLINE NoiseCall<N, Octave> noiseOf(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return &calledNoise<NoiseKind::value, N, Octave>;
    case NoiseKind::gradient:
        break;
    case NoiseKind::simplex:
        return &calledNoise<NoiseKind::simplex, N, Octave>;
    case NoiseKind::cellular:
        return &calledNoise<NoiseKind::cellular, N, Octave>;
    case NoiseKind::border:
        return &calledNoise<NoiseKind::border, N, Octave>;
    }
    return &calledNoise<NoiseKind::gradient, N, Octave>;
}

/// The same as fractalSum of a kind and norms that are known beforehand.
template <FractalKind kFractal, typename N, typename Octave>
HWY_INLINE N putTogether(
    NoiseCall<N, Octave> call,
    const Octave* octaves,
    std::size_t count,
    const FractalNorms& norms,
    const Point<N>& p,
    const Radius& radius)
{
    FractalSum<kFractal, N> fractal{fromConstant<N>(0.0F), fromConstant<N>(1.0F)};
    for (std::size_t i = 0; i < count; ++i) {
        const N factor = weight<N>(radius, octaves[i].filterCycles);
        // Shorter waves are filtered away as well, in the same lanes.
        if (vanishes(factor))
            break;
        fractal.add(call(octaves[i], p), octaves[i].amplitude, factor, norms);
    }
    return chained(fractal.sum, p);
}

template <typename N>
HWY_INLINE N detailed(
    N value,
    const DetailOctave* octaves,
    std::size_t count,
    const N& strength,
    const Point<N>& p,
    const Radius& radius)
{
    for (std::size_t i = 0; i < count; ++i) {
        const DetailOctave& octave = octaves[i];
        const N open =
            1.0F - smoothStep(magnitude(value), octave.remaining, 2.0F * octave.remaining);
        // What is too far from zero for this octave is too far for the weaker ones that follow.
        if (vanishes(open))
            break;
        const N near = open * weight<N>(radius, octave.noise.filterCycles);
        if (vanishes(near))
            continue;
        const N noise = chained(noiseOf<N, SpaceOctave>(octave.kind)(octave.noise, p), p);
        value = value + noise * octave.noise.amplitude * near * strength;
    }
    return value;
}

} // namespace isofront::fields::graph::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

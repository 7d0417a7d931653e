// Octaves of noise, and sums of them, for each kind of number and each instruction set.

#if defined(ISOFRONT_FIELDS_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_NOISE_INL_H
#undef ISOFRONT_FIELDS_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_NOISE_INL_H
#endif

#include "Octaves.h"
#include "simd/CellularNoise-inl.h"
#include "simd/GradientNoise-inl.h"
#include "simd/SimplexNoise-inl.h"
#include "simd/ValueNoise-inl.h"

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

// ---- Noise in field coordinates -----------------------------------------------------------------

template <NoiseKind kKind, bool kWithSlope, typename N>
HWY_INLINE NoiseSample latticeNoise(const SpaceOctave& o, const Point<N>& p)
{
    return Noise<kKind>::template at<kWithSlope>(
        cellOf(scaled(p.x.at, o.frequency[0], o.offset[0])),
        cellOf(scaled(p.y.at, o.frequency[1], o.offset[1])),
        cellOf(scaled(p.z.at, o.frequency[2], o.offset[2])),
        o.seed);
}

template <NoiseKind kKind, bool kWithSlope, typename N>
HWY_INLINE NoiseSample latticeNoise(const PlaneOctave& o, const Point<N>& p)
{
    return Noise<kKind>::template at<kWithSlope>(
        cellOf(combined(p.x.at, o.first[0], p.y.at, o.first[1], o.offset[0])),
        cellOf(combined(p.x.at, o.second[0], p.y.at, o.second[1], o.offset[1])),
        o.seed);
}

/// Turns slopes in lattice coordinates to those along x, y and z.
HWY_INLINE Slope unscaled(const SpaceOctave& o, const NoiseSample& s)
{
    return {
        s.value,
        hn::Mul(s.slope[0], constant(float(o.frequency[0]))),
        hn::Mul(s.slope[1], constant(float(o.frequency[1]))),
        hn::Mul(s.slope[2], constant(float(o.frequency[2])))};
}

HWY_INLINE Slope unscaled(const PlaneOctave& o, const NoiseSample& s)
{
    const auto along = [&](std::size_t i) HWY_ATTR {
        return hn::Add(
            hn::Mul(s.slope[0], constant(float(o.first[i]))),
            hn::Mul(s.slope[1], constant(float(o.second[i]))));
    };
    return {s.value, along(0), along(1), hn::Zero(FloatTag())};
}

// ---- Ranges -------------------------------------------------------------------------------------

/// The range of noise within `extent` of a place where value and slope are known: whichever is
/// narrowest of the global limits, a Lipschitz bound, and Taylor's formula with the largest second
/// derivative as remainder.
HWY_INLINE Range enclosed(
    const NoiseSample& sample, const Floats* extent, std::size_t axes, const NoiseLimits& limits)
{
    // Rounding in the noise itself stays below this.
    const Floats slack = constant(1e-5F);
    Floats squares = hn::Zero(FloatTag());
    Floats linear = hn::Zero(FloatTag());
    for (std::size_t i = 0; i < axes; ++i) {
        squares = hn::Add(squares, hn::Mul(extent[i], extent[i]));
        linear = hn::Add(linear, hn::Mul(hn::Abs(sample.slope[i]), extent[i]));
    }
    const Floats taylor = hn::Add(linear, hn::Mul(constant(0.5F * limits.curvature), squares));
    const Floats lipschitz = hn::Mul(constant(limits.slope), hn::Sqrt(squares));
    const Floats reach = hn::Add(hn::Min(taylor, lipschitz), slack);
    const Floats most = constant(limits.magnitude);
    return {
        hn::Max(hn::Sub(sample.value, reach), hn::Neg(most)),
        hn::Min(hn::Add(sample.value, reach), most)};
}

/// The limits in the lanes of the mask.
HWY_INLINE Range
limitedWhere(hn::Mask<FloatTag> mask, const Range& range, const NoiseLimits& limits)
{
    const Floats most = constant(limits.magnitude);
    return {hn::IfThenElse(mask, hn::Neg(most), range.low), hn::IfThenElse(mask, most, range.high)};
}

/// Lanes in which two places of the box may have nothing to say about one another.
HWY_INLINE hn::Mask<FloatTag> beyond(Floats extent, const NoiseLimits& limits)
{
    return hn::Gt(extent, constant(2.0F * limits.magnitude / limits.slope));
}

template <NoiseKind kKind>
HWY_INLINE Range enclosedNoise(const SpaceOctave& o, const Point<Range>& p)
{
    constexpr NoiseLimits kLimits = spaceLimits(kKind);
    const Floats extent[3] = {
        hn::Mul(p.x.extent, constant(float(o.frequency[0]))),
        hn::Mul(p.y.extent, constant(float(o.frequency[1]))),
        hn::Mul(p.z.extent, constant(float(o.frequency[2])))};
    const auto unknown = beyond(hn::Max(hn::Max(extent[0], extent[1]), extent[2]), kLimits);
    if (hn::AllTrue(FloatTag(), unknown))
        return limitedWhere(unknown, Range{extent[0], extent[0]}, kLimits);
    const NoiseSample sample = latticeNoise<kKind, true>(o, p);
    return limitedWhere(unknown, enclosed(sample, extent, 3, kLimits), kLimits);
}

template <NoiseKind kKind>
HWY_INLINE Range enclosedNoise(const PlaneOctave& o, const Point<Range>& p)
{
    constexpr NoiseLimits kLimits = planeLimits(kKind);
    const auto reach = [&](const double* factors) HWY_ATTR {
        return hn::Add(
            hn::Mul(p.x.extent, hn::Abs(constant(float(factors[0])))),
            hn::Mul(p.y.extent, hn::Abs(constant(float(factors[1])))));
    };
    const Floats extent[2] = {reach(o.first), reach(o.second)};
    const auto unknown = beyond(hn::Max(extent[0], extent[1]), kLimits);
    if (hn::AllTrue(FloatTag(), unknown))
        return limitedWhere(unknown, Range{extent[0], extent[0]}, kLimits);
    const NoiseSample sample = latticeNoise<kKind, true>(o, p);
    return limitedWhere(unknown, enclosed(sample, extent, 2, kLimits), kLimits);
}

// ---- An octave at a point, for each kind of number ----------------------------------------------

/// The noise with its slopes along the point's own x, y and z, whatever these depend on in turn:
/// `chained` brings that in, once for a whole sum.
template <NoiseKind kKind, typename Octave>
HWY_INLINE Value localNoise(const Octave& o, const Point<Value>& p)
{
    return {latticeNoise<kKind, false>(o, p).value};
}
template <NoiseKind kKind, typename Octave>
HWY_INLINE Range localNoise(const Octave& o, const Point<Range>& p)
{
    return enclosedNoise<kKind>(o, p);
}
template <NoiseKind kKind, typename Octave>
HWY_INLINE Slope localNoise(const Octave& o, const Point<Slope>& p)
{
    return unscaled(o, latticeNoise<kKind, true>(o, p));
}

HWY_INLINE Value chained(const Value& local, const Point<Value>& /*p*/)
{
    return local;
}
HWY_INLINE Range chained(const Range& local, const Point<Range>& /*p*/)
{
    return local;
}
HWY_INLINE Slope chained(const Slope& local, const Point<Slope>& p)
{
    const auto sum = [&](Floats x, Floats y, Floats z) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(local.x, x), hn::Mul(local.y, y)), hn::Mul(local.z, z));
    };
    return {local.v, sum(p.x.x, p.y.x, p.z.x), sum(p.x.y, p.y.y, p.z.y), sum(p.x.z, p.y.z, p.z.z)};
}

/// Not inlined: formulas have many of them.
template <NoiseKind kKind, typename N, typename Octave>
HWY_NOINLINE N calledNoise(const Octave& octave, const Point<N>& p)
{
    return localNoise<kKind>(octave, p);
}

/// One octave's noise, without its amplitude and weight.
template <NoiseKind kKind = NoiseKind::gradient, typename N, typename Octave>
HWY_INLINE N noiseAt(const Octave& octave, const Point<N>& p)
{
    return chained(calledNoise<kKind>(octave, p), p);
}

// ---- Sums of octaves ----------------------------------------------------------------------------

/// The magnitude, rounded off at zero so that it has a slope there.
template <typename N>
HWY_INLINE N creased(const N& a)
{
    return root(squared(a) + kCreaseRounding);
}

/// What has been summed up, and what the next octave needs to know of those before.
template <FractalKind kFractal, typename N>
struct FractalSum {
    N sum;
    N carrier; ///< of ridges only: how much of the next octave is wanted

    /// @param noise  the octave's
    /// @param factor  its weight
    HWY_INLINE void add(const N& noise, float amplitude, const N& factor, const FractalNorms& norms)
    {
        if constexpr (kFractal == FractalKind::brownian) {
            sum = sum + noise * amplitude * factor;
        } else if constexpr (kFractal == FractalKind::billow) {
            const N bulge = creased(noise * norms.scale) - norms.billowMean;
            sum = sum + bulge * amplitude * factor;
        } else {
            const N crest = 1.0F - creased(noise * norms.scale);
            const N signal = squared(most(crest, fromConstant<N>(0.0F)));
            sum = sum + (signal - norms.ridgeMean) * carrier * amplitude * factor;
            carrier = smoothStep(signal * norms.carry * carrier, 0.0F, 1.0F);
        }
    }
};

template <NoiseKind kKind>
HWY_INLINE constexpr FractalNorms normsFor(const SpaceOctave* /*octaves*/)
{
    return spaceNorms(kKind);
}
template <NoiseKind kKind>
HWY_INLINE constexpr FractalNorms normsFor(const PlaneOctave* /*octaves*/)
{
    return planeNorms(kKind);
}

/// The weighted sum of some octaves. An octave that the filter removes in every lane costs nothing,
/// and adds exactly nothing in any lane. Octaves are ordered from long waves to short ones: what is
/// left out of ridges is left out in all that follow.
template <
    NoiseKind kKind = NoiseKind::gradient,
    FractalKind kFractal = FractalKind::brownian,
    typename N,
    typename Octave>
HWY_INLINE N
fractalSum(const Octave* octaves, std::size_t count, const Point<N>& p, const Radius& radius)
{
    FractalSum<kFractal, N> fractal{fromConstant<N>(0.0F), fromConstant<N>(1.0F)};
    for (std::size_t i = 0; i < count; ++i) {
        const N factor = weight<N>(radius, octaves[i].filterCycles);
        if (vanishes(factor))
            continue;
        fractal.add(
            calledNoise<kKind>(octaves[i], p),
            octaves[i].amplitude,
            factor,
            normsFor<kKind>(octaves));
    }
    return chained(fractal.sum, p);
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

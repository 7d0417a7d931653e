// Gradient noise on vectors, for each instruction set. See Numbers-inl.h for the numbers.
//
// Based on: Perlin, "Improving Noise" (2002): the quintic fade and the twelve gradients towards the
// edges of a cube. Differs: the corners are hashed by integer mixing instead of a table of
// permutations, all twelve gradients are equally likely, and noise in the plane has eight gradients
// of its own.

#if defined(ISOFRONT_FIELDS_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_NOISE_INL_H
#undef ISOFRONT_FIELDS_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_NOISE_INL_H
#endif

#include "Octaves.h"
#include "simd/Numbers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

// ---- The lattice --------------------------------------------------------------------------------

/// Where a lattice coordinate lies: the low 32 bits of its cell, and the fraction in [0, 1].
struct Cell {
    Words index;
    Floats fraction;
};

/// Exact while the magnitude is below 2^51; beyond, the same on every machine.
HWY_INLINE Cell cellOf(const DoublePair& t)
{
    const DoubleTag d;
    const Doubles floor0 = hn::Floor(t.first);
    const Doubles floor1 = hn::Floor(t.second);
    // Adding 1.5 * 2^52 leaves a whole number, in two's complement, in the low bits.
    const Doubles magic = hn::Set(d, 6755399441055744.0);
#if HWY_TARGET == HWY_SCALAR
    const auto bits = hn::BitCast(hn::RebindToUnsigned<DoubleTag>(), hn::Add(floor0, magic));
    const Words index = hn::Set(WordTag(), static_cast<std::uint32_t>(hn::GetLane(bits)));
#else
    const hn::Repartition<std::uint32_t, DoubleTag> words;
    const auto bits0 = hn::BitCast(words, hn::Add(floor0, magic));
    const auto bits1 = hn::BitCast(words, hn::Add(floor1, magic));
    const Words index = hn::ConcatEven(words, bits1, bits0);
#endif
    return {index, narrowed({hn::Sub(t.first, floor0), hn::Sub(t.second, floor1)})};
}

HWY_INLINE DoublePair scaled(const DoublePair& c, double factor, double offset)
{
    const DoubleTag d;
    const Doubles f = hn::Set(d, factor);
    const Doubles o = hn::Set(d, offset);
    return {hn::Add(hn::Mul(c.first, f), o), hn::Add(hn::Mul(c.second, f), o)};
}

HWY_INLINE DoublePair
combined(const DoublePair& x, double fx, const DoublePair& y, double fy, double offset)
{
    const DoublePair scaledX = scaled(x, fx, offset);
    const DoubleTag d;
    const Doubles f = hn::Set(d, fy);
    return {
        hn::Add(hn::Mul(y.first, f), scaledX.first), hn::Add(hn::Mul(y.second, f), scaledX.second)};
}

/// Mixes the cells along one axis, so that neighbouring cells have nothing in common.
HWY_INLINE Words stirred(Words cell, std::uint32_t seed)
{
    const WordTag w;
    Words hash = hn::Xor(cell, hn::Set(w, seed));
    hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<16>(hash)), hn::Set(w, 0x7feb352dU));
    hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<15>(hash)), hn::Set(w, 0x846ca68bU));
    return hn::Xor(hash, hn::ShiftRight<16>(hash));
}

/// The hash of a corner from the sum of those of its coordinates. The sum alone would give four
/// corners of a face that depend on one another.
HWY_INLINE Words finished(Words sum)
{
    const Words product = hn::Mul(sum, hn::Set(WordTag(), 0x9e3779b1U));
    return hn::Xor(product, hn::ShiftRight<15>(product));
}

// The same cell along another axis must hash to something else.
inline constexpr std::uint32_t kSeedY = 0x68e31da4U;
inline constexpr std::uint32_t kSeedZ = 0xb5297a4dU;

HWY_INLINE Floats signedBy(Floats value, Words signBit)
{
    return hn::Xor(value, hn::BitCast(FloatTag(), signBit));
}

HWY_INLINE Floats lerp(Floats a, Floats b, Floats t)
{
    return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

/// 6 t^5 - 15 t^4 + 10 t^3, about t = 1/2: from powers of t it would lose four bits near 1.
HWY_INLINE Floats fade(Floats t)
{
    const Floats u = hn::Sub(t, constant(0.5F));
    const Floats v = hn::Mul(u, u);
    const Floats inner = hn::Mul(v, hn::Sub(hn::Mul(v, constant(6.0F)), constant(5.0F)));
    return hn::Add(hn::Mul(u, hn::Add(inner, constant(1.875F))), constant(0.5F));
}

/// 30 t^2 (t - 1)^2
HWY_INLINE Floats fadeSlope(Floats t)
{
    const Floats product = hn::Mul(t, hn::Sub(t, constant(1.0F)));
    return hn::Mul(constant(30.0F), hn::Mul(product, product));
}

/// Value and, where asked for, gradient in lattice coordinates.
struct NoiseSample {
    Floats value;
    Floats slope[3];
};

// ---- Noise in space -----------------------------------------------------------------------------

template <bool kWithSlope>
HWY_INLINE NoiseSample noise(const Cell& x, const Cell& y, const Cell& z, std::uint32_t seed)
{
    const FloatTag d;
    const WordTag w;
    const SignedTag s;
    const Words one = hn::Set(w, 1U);
    const Floats whole = constant(1.0F);
    const Words signBit = hn::Set(w, 0x80000000U);
    const auto third = hn::Set(s, -715827883);
    const auto twoThirds = hn::Set(s, 715827882);

    const Floats px[2] = {x.fraction, hn::Sub(x.fraction, whole)};
    const Floats py[2] = {y.fraction, hn::Sub(y.fraction, whole)};
    const Floats pz[2] = {z.fraction, hn::Sub(z.fraction, whole)};
    const Words hashX[2] = {stirred(x.index, seed), stirred(hn::Add(x.index, one), seed)};
    const Words hashY[2] = {
        stirred(y.index, seed ^ kSeedY), stirred(hn::Add(y.index, one), seed ^ kSeedY)};
    const Words hashZ[2] = {
        stirred(z.index, seed ^ kSeedZ), stirred(hn::Add(z.index, one), seed ^ kSeedZ)};

    Floats dots[8];
    Floats gx[8];
    Floats gy[8];
    Floats gz[8];
    for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < 2; ++j) {
            const Words hashXy = hn::Add(hashX[i], hashY[j]);
            for (std::size_t k = 0; k < 2; ++k) {
                const Words hash = finished(hn::Add(hashXy, hashZ[k]));
                // The hash, as a signed number, picks one of three pairs of axes; two low bits
                // give the signs.
                const auto number = hn::BitCast(s, hash);
                const auto inFirst = hn::RebindMask(d, hn::Lt(number, third));
                const auto inFirstTwo = hn::RebindMask(d, hn::Lt(number, twoThirds));
                const Words signU = hn::ShiftLeft<31>(hash);
                const Words signV = hn::And(hn::ShiftLeft<30>(hash), signBit);
                const Floats u = hn::IfThenElse(inFirstTwo, px[i], py[j]);
                const Floats v = hn::IfThenElse(inFirst, py[j], pz[k]);
                const std::size_t corner = 4 * i + 2 * j + k;
                dots[corner] = hn::Add(signedBy(u, signU), signedBy(v, signV));
                if constexpr (kWithSlope) {
                    const Floats oneU = signedBy(whole, signU);
                    const Floats oneV = signedBy(whole, signV);
                    gx[corner] = hn::IfThenElseZero(inFirstTwo, oneU);
                    gy[corner] =
                        hn::IfThenElse(inFirst, oneV, hn::IfThenZeroElse(inFirstTwo, oneU));
                    gz[corner] = hn::IfThenZeroElse(inFirst, oneV);
                }
            }
        }
    }

    const Floats fx = fade(x.fraction);
    const Floats fy = fade(y.fraction);
    const Floats fz = fade(z.fraction);
    Floats alongX[4];
    for (std::size_t i = 0; i < 4; ++i)
        alongX[i] = lerp(dots[i], dots[i + 4], fx);
    const Floats alongY[2] = {lerp(alongX[0], alongX[2], fy), lerp(alongX[1], alongX[3], fy)};
    NoiseSample sample{};
    sample.value = lerp(alongY[0], alongY[1], fz);
    if constexpr (kWithSlope) {
        const auto mixed = [&](const Floats* g) HWY_ATTR {
            const Floats a = lerp(lerp(g[0], g[4], fx), lerp(g[2], g[6], fx), fy);
            const Floats b = lerp(lerp(g[1], g[5], fx), lerp(g[3], g[7], fx), fy);
            return lerp(a, b, fz);
        };
        const auto step = [&](std::size_t i) HWY_ATTR { return hn::Sub(dots[i + 4], dots[i]); };
        const Floats stepX = lerp(lerp(step(0), step(2), fy), lerp(step(1), step(3), fy), fz);
        const Floats stepY = lerp(hn::Sub(alongX[2], alongX[0]), hn::Sub(alongX[3], alongX[1]), fz);
        const Floats stepZ = hn::Sub(alongY[1], alongY[0]);
        sample.slope[0] = hn::Add(mixed(gx), hn::Mul(fadeSlope(x.fraction), stepX));
        sample.slope[1] = hn::Add(mixed(gy), hn::Mul(fadeSlope(y.fraction), stepY));
        sample.slope[2] = hn::Add(mixed(gz), hn::Mul(fadeSlope(z.fraction), stepZ));
    }
    return sample;
}

// ---- Noise in the plane -------------------------------------------------------------------------

template <bool kWithSlope>
HWY_INLINE NoiseSample noise(const Cell& x, const Cell& y, std::uint32_t seed)
{
    const FloatTag d;
    const WordTag w;
    const Words one = hn::Set(w, 1U);
    const Words two = hn::Set(w, 2U);
    const Words signBit = hn::Set(w, 0x80000000U);
    const Floats whole = constant(1.0F);
    // Cosine and sine of 22.5 degrees: eight directions, 45 degrees apart, none along an axis.
    const Floats cosine = constant(0.923879533F);
    const Floats sine = constant(0.382683432F);

    const Floats px[2] = {x.fraction, hn::Sub(x.fraction, whole)};
    const Floats py[2] = {y.fraction, hn::Sub(y.fraction, whole)};
    const Words hashX[2] = {stirred(x.index, seed), stirred(hn::Add(x.index, one), seed)};
    const Words hashY[2] = {
        stirred(y.index, seed ^ kSeedY), stirred(hn::Add(y.index, one), seed ^ kSeedY)};
    Floats dots[4];
    Floats gx[4];
    Floats gy[4];
    for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < 2; ++j) {
            const Words hash = finished(hn::Add(hashX[i], hashY[j]));
            const auto steep = hn::RebindMask(d, hn::Ne(hn::And(hash, two), hn::Zero(w)));
            const Words signX = hn::ShiftLeft<31>(hash);
            const Words signY = hn::And(hash, signBit);
            const std::size_t corner = 2 * i + j;
            gx[corner] = signedBy(hn::IfThenElse(steep, sine, cosine), signX);
            gy[corner] = signedBy(hn::IfThenElse(steep, cosine, sine), signY);
            dots[corner] = hn::Add(hn::Mul(gx[corner], px[i]), hn::Mul(gy[corner], py[j]));
        }
    }
    const Floats fx = fade(x.fraction);
    const Floats fy = fade(y.fraction);
    const Floats along[2] = {lerp(dots[0], dots[2], fx), lerp(dots[1], dots[3], fx)};
    NoiseSample sample{};
    sample.value = lerp(along[0], along[1], fy);
    if constexpr (kWithSlope) {
        const auto mixed = [&](const Floats* g) HWY_ATTR {
            return lerp(lerp(g[0], g[2], fx), lerp(g[1], g[3], fx), fy);
        };
        const Floats stepX = lerp(hn::Sub(dots[2], dots[0]), hn::Sub(dots[3], dots[1]), fy);
        const Floats stepY = hn::Sub(along[1], along[0]);
        sample.slope[0] = hn::Add(mixed(gx), hn::Mul(fadeSlope(x.fraction), stepX));
        sample.slope[1] = hn::Add(mixed(gy), hn::Mul(fadeSlope(y.fraction), stepY));
        sample.slope[2] = hn::Zero(d);
    }
    return sample;
}

// ---- An octave at a point, for each kind of number ----------------------------------------------

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

inline HWY_NOINLINE Value noiseAt(const SpaceOctave& o, const Point<Value>& p)
{
    return {noise<false>(
                cellOf(scaled(p.x.at, o.frequency[0], o.offset[0])),
                cellOf(scaled(p.y.at, o.frequency[1], o.offset[1])),
                cellOf(scaled(p.z.at, o.frequency[2], o.offset[2])),
                o.seed)
                .value};
}

inline HWY_NOINLINE Range noiseAt(const SpaceOctave& o, const Point<Range>& p)
{
    const Floats extent[3] = {
        hn::Mul(p.x.extent, constant(float(o.frequency[0]))),
        hn::Mul(p.y.extent, constant(float(o.frequency[1]))),
        hn::Mul(p.z.extent, constant(float(o.frequency[2])))};
    const auto unknown = beyond(hn::Max(hn::Max(extent[0], extent[1]), extent[2]), kSpaceNoise);
    if (hn::AllTrue(FloatTag(), unknown))
        return limitedWhere(unknown, Range{extent[0], extent[0]}, kSpaceNoise);
    const NoiseSample sample = noise<true>(
        cellOf(scaled(p.x.at, o.frequency[0], o.offset[0])),
        cellOf(scaled(p.y.at, o.frequency[1], o.offset[1])),
        cellOf(scaled(p.z.at, o.frequency[2], o.offset[2])),
        o.seed);
    return limitedWhere(unknown, enclosed(sample, extent, 3, kSpaceNoise), kSpaceNoise);
}

inline HWY_NOINLINE Slope noiseAt(const SpaceOctave& o, const Point<Slope>& p)
{
    const NoiseSample sample = noise<true>(
        cellOf(scaled(p.x.at, o.frequency[0], o.offset[0])),
        cellOf(scaled(p.y.at, o.frequency[1], o.offset[1])),
        cellOf(scaled(p.z.at, o.frequency[2], o.offset[2])),
        o.seed);
    const Floats sx = hn::Mul(sample.slope[0], constant(float(o.frequency[0])));
    const Floats sy = hn::Mul(sample.slope[1], constant(float(o.frequency[1])));
    const Floats sz = hn::Mul(sample.slope[2], constant(float(o.frequency[2])));
    const auto chained = [&](Floats x, Floats y, Floats z) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(sx, x), hn::Mul(sy, y)), hn::Mul(sz, z));
    };
    return {
        sample.value,
        chained(p.x.x, p.y.x, p.z.x),
        chained(p.x.y, p.y.y, p.z.y),
        chained(p.x.z, p.y.z, p.z.z)};
}

template <typename N>
HWY_INLINE Cell planeCell(const Point<N>& p, const double* factors, double offset)
{
    return cellOf(combined(p.x.at, factors[0], p.y.at, factors[1], offset));
}

inline HWY_NOINLINE Value noiseAt(const PlaneOctave& o, const Point<Value>& p)
{
    return {noise<false>(
                planeCell(p, o.first, o.offset[0]), planeCell(p, o.second, o.offset[1]), o.seed)
                .value};
}

inline HWY_NOINLINE Range noiseAt(const PlaneOctave& o, const Point<Range>& p)
{
    const auto reach = [&](const double* factors) HWY_ATTR {
        return hn::Add(
            hn::Mul(p.x.extent, hn::Abs(constant(float(factors[0])))),
            hn::Mul(p.y.extent, hn::Abs(constant(float(factors[1])))));
    };
    const Floats extent[2] = {reach(o.first), reach(o.second)};
    const auto unknown = beyond(hn::Max(extent[0], extent[1]), kPlaneNoise);
    if (hn::AllTrue(FloatTag(), unknown))
        return limitedWhere(unknown, Range{extent[0], extent[0]}, kPlaneNoise);
    const NoiseSample sample = noise<true>(
        planeCell(p, o.first, o.offset[0]), planeCell(p, o.second, o.offset[1]), o.seed);
    return limitedWhere(unknown, enclosed(sample, extent, 2, kPlaneNoise), kPlaneNoise);
}

inline HWY_NOINLINE Slope noiseAt(const PlaneOctave& o, const Point<Slope>& p)
{
    const NoiseSample sample = noise<true>(
        planeCell(p, o.first, o.offset[0]), planeCell(p, o.second, o.offset[1]), o.seed);
    const auto chained = [&](Floats x, Floats y) HWY_ATTR {
        const Floats first = hn::Add(
            hn::Mul(x, constant(float(o.first[0]))), hn::Mul(y, constant(float(o.first[1]))));
        const Floats second = hn::Add(
            hn::Mul(x, constant(float(o.second[0]))), hn::Mul(y, constant(float(o.second[1]))));
        return hn::Add(hn::Mul(sample.slope[0], first), hn::Mul(sample.slope[1], second));
    };
    return {sample.value, chained(p.x.x, p.y.x), chained(p.x.y, p.y.y), chained(p.x.z, p.y.z)};
}

/// The weighted sum of some octaves. An octave that the filter removes in every lane costs nothing,
/// and adds exactly nothing in any lane.
template <typename N, typename Octave>
HWY_INLINE N
fractalSum(const Octave* octaves, std::size_t count, const Point<N>& p, const Radius& radius)
{
    N sum = fromConstant<N>(0.0F);
    for (std::size_t i = 0; i < count; ++i) {
        const N factor = weight<N>(radius, octaves[i].filterCycles);
        if (vanishes(factor))
            continue;
        sum = sum + noiseAt(octaves[i], p) * octaves[i].amplitude * factor;
    }
    return sum;
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

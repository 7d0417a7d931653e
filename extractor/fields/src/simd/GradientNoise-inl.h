// Gradient noise on vectors, for each instruction set.
//
// Based on: Perlin, "Improving Noise" (2002): the quintic fade and the twelve gradients towards the
// edges of a cube. Differs: the corners are hashed by multiplication instead of a table of
// permutations, all twelve gradients are equally likely, and noise in the plane has eight gradients
// of its own.

#if defined(ISOFRONT_FIELDS_GRADIENT_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRADIENT_NOISE_INL_H
#undef ISOFRONT_FIELDS_GRADIENT_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_GRADIENT_NOISE_INL_H
#endif

#include "simd/Lattice-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// One of the twelve gradients towards the edges of a cube, (+-1, +-1, 0) and its turns, all
/// equally likely: a pair of axes, u before v, and their signs.
struct EdgeGradient {
    hn::Mask<FloatTag> uIsX; ///< else y
    hn::Mask<FloatTag> vIsY; ///< else z; uIsX where this holds
    Words signU;             ///< in the top bit
    Words signV;

    HWY_INLINE explicit EdgeGradient(Words hash) : signU(hash), signV(hn::ShiftLeft<1>(hash))
    {
        const SignedTag s;
        // The hash without the bits of the signs picks one of three pairs, by thirds.
        const auto number = hn::BitCast(s, hn::ShiftLeft<2>(hash));
        vIsY = hn::RebindMask(FloatTag(), hn::Lt(number, hn::Set(s, -715827883)));
        uIsX = hn::RebindMask(FloatTag(), hn::Lt(number, hn::Set(s, 715827882)));
    }

    [[nodiscard]] HWY_INLINE Floats dot(Floats x, Floats y, Floats z) const
    {
        return hn::Add(
            signedBy(hn::IfThenElse(uIsX, x, y), signU),
            signedBy(hn::IfThenElse(vIsY, y, z), signV));
    }

    /// Adds `factor` times the gradient.
    HWY_INLINE void addTo(Floats* sum, Floats factor) const
    {
        const Floats u = signedBy(factor, signU);
        const Floats v = signedBy(factor, signV);
        sum[0] = hn::Add(sum[0], hn::IfThenElseZero(uIsX, u));
        sum[1] = hn::Add(sum[1], hn::IfThenElse(vIsY, v, hn::IfThenZeroElse(uIsX, u)));
        sum[2] = hn::Add(sum[2], hn::IfThenZeroElse(vIsY, v));
    }
};

/// One of eight gradients of length 1 in the plane, 45 degrees apart, none along an axis.
struct TurnGradient {
    Floats x;
    Floats y;

    HWY_INLINE explicit TurnGradient(Words hash)
    {
        // Cosine and sine of 22.5 degrees.
        const Floats cosine = constant(0.923879533F);
        const Floats sine = constant(0.382683432F);
        const SignedTag s;
        const auto steep =
            hn::RebindMask(FloatTag(), hn::Lt(hn::BitCast(s, hn::ShiftLeft<2>(hash)), hn::Zero(s)));
        x = signedBy(hn::IfThenElse(steep, sine, cosine), hash);
        y = signedBy(hn::IfThenElse(steep, cosine, sine), hn::ShiftLeft<1>(hash));
    }

    [[nodiscard]] HWY_INLINE Floats dot(Floats dx, Floats dy) const
    {
        return hn::Add(hn::Mul(x, dx), hn::Mul(y, dy));
    }
};

template <>
struct Noise<NoiseKind::gradient> {
    template <bool kWithSlope>
    static HWY_INLINE NoiseSample
    at(const Cell& x, const Cell& y, const Cell& z, std::uint32_t seed)
    {
        const Floats half = constant(0.5F);
        const Floats px[2] = {hn::Add(x.centred, half), hn::Sub(x.centred, half)};
        const Floats py[2] = {hn::Add(y.centred, half), hn::Sub(y.centred, half)};
        const Floats pz[2] = {hn::Add(z.centred, half), hn::Sub(z.centred, half)};
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hz = hashedZ(z.index, seed);
        const Words hashX[2] = {hx, next(hx, kPrimeX)};
        const Words hashY[2] = {hy, next(hy, kPrimeY)};
        const Words hashZ[2] = {hz, next(hz, kPrimeZ)};
        const Floats fx = fade(x.centred);
        const Floats fy = fade(y.centred);
        const Floats fz = fade(z.centred);
        const Floats one = constant(1.0F);
        const Floats wx[2] = {hn::Sub(one, fx), fx};
        const Floats wy[2] = {hn::Sub(one, fy), fy};
        const Floats wz[2] = {hn::Sub(one, fz), fz};

        NoiseSample sample{};
        if constexpr (kWithSlope)
            sample.slope[0] = sample.slope[1] = sample.slope[2] = hn::Zero(FloatTag());
        Floats dots[8];
        for (std::size_t j = 0; j < 2; ++j) {
            for (std::size_t k = 0; k < 2; ++k) {
                const Words hashYz = hn::Xor(hashY[j], hashZ[k]);
                for (std::size_t i = 0; i < 2; ++i) {
                    const EdgeGradient gradient(finished(hn::Xor(hashX[i], hashYz)));
                    dots[4 * i + 2 * j + k] = gradient.dot(px[i], py[j], pz[k]);
                    if constexpr (kWithSlope) {
                        const Floats weightYz = hn::Mul(wy[j], wz[k]);
                        gradient.addTo(sample.slope, hn::Mul(wx[i], weightYz));
                    }
                }
            }
        }
        Floats alongX[4];
        for (std::size_t i = 0; i < 4; ++i)
            alongX[i] = lerp(dots[i], dots[i + 4], fx);
        const Floats alongY[2] = {lerp(alongX[0], alongX[2], fy), lerp(alongX[1], alongX[3], fy)};
        sample.value = lerp(alongY[0], alongY[1], fz);
        if constexpr (kWithSlope) {
            const auto step = [&](std::size_t i) HWY_ATTR { return hn::Sub(dots[i + 4], dots[i]); };
            const Floats stepX = lerp(lerp(step(0), step(2), fy), lerp(step(1), step(3), fy), fz);
            const Floats stepY =
                lerp(hn::Sub(alongX[2], alongX[0]), hn::Sub(alongX[3], alongX[1]), fz);
            const Floats stepZ = hn::Sub(alongY[1], alongY[0]);
            const auto add = [&](std::size_t axis, Floats u, Floats steps) HWY_ATTR {
                sample.slope[axis] = hn::Add(sample.slope[axis], hn::Mul(fadeSlope(u), steps));
            };
            add(0, x.centred, stepX);
            add(1, y.centred, stepY);
            add(2, z.centred, stepZ);
        }
        return sample;
    }

    template <bool kWithSlope>
    static HWY_INLINE NoiseSample at(const Cell& x, const Cell& y, std::uint32_t seed)
    {
        const Floats half = constant(0.5F);
        const Floats px[2] = {hn::Add(x.centred, half), hn::Sub(x.centred, half)};
        const Floats py[2] = {hn::Add(y.centred, half), hn::Sub(y.centred, half)};
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hashX[2] = {hx, next(hx, kPrimeX)};
        const Words hashY[2] = {hy, next(hy, kPrimeY)};
        Floats dots[4];
        Floats gx[4];
        Floats gy[4];
        for (std::size_t i = 0; i < 2; ++i) {
            for (std::size_t j = 0; j < 2; ++j) {
                const TurnGradient gradient(finished(hn::Xor(hashX[i], hashY[j])));
                const std::size_t corner = 2 * i + j;
                gx[corner] = gradient.x;
                gy[corner] = gradient.y;
                dots[corner] = gradient.dot(px[i], py[j]);
            }
        }
        const Floats fx = fade(x.centred);
        const Floats fy = fade(y.centred);
        const Floats along[2] = {lerp(dots[0], dots[2], fx), lerp(dots[1], dots[3], fx)};
        NoiseSample sample{};
        sample.value = lerp(along[0], along[1], fy);
        if constexpr (kWithSlope) {
            const auto mixed = [&](const Floats* g) HWY_ATTR {
                return lerp(lerp(g[0], g[2], fx), lerp(g[1], g[3], fx), fy);
            };
            const Floats stepX = lerp(hn::Sub(dots[2], dots[0]), hn::Sub(dots[3], dots[1]), fy);
            const Floats stepY = hn::Sub(along[1], along[0]);
            sample.slope[0] = hn::Add(mixed(gx), hn::Mul(fadeSlope(x.centred), stepX));
            sample.slope[1] = hn::Add(mixed(gy), hn::Mul(fadeSlope(y.centred), stepY));
            sample.slope[2] = hn::Zero(FloatTag());
        }
        return sample;
    }
};

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

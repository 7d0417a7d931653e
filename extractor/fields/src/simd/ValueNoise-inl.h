// Value noise on vectors, for each instruction set: a random number at each corner of the lattice,
// and between them the quintic fade of Perlin, "Improving Noise" (2002).

#if defined(ISOFRONT_FIELDS_VALUE_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_VALUE_NOISE_INL_H
#undef ISOFRONT_FIELDS_VALUE_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_VALUE_NOISE_INL_H
#endif

#include "simd/Lattice-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// The value of a corner, in [-2^31, 2^31].
HWY_INLINE Floats cornerValue(Words axes)
{
    return hn::ConvertTo(FloatTag(), hn::BitCast(SignedTag(), finished(axes)));
}

template <>
struct Noise<NoiseKind::value> {
    /// Brings the corners' values to [-1, 1].
    static constexpr float kScale = 0x1p-31F;

    template <bool kWithSlope>
    static HWY_INLINE NoiseSample
    at(const Cell& x, const Cell& y, const Cell& z, std::uint32_t seed)
    {
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hz = hashedZ(z.index, seed);
        const Words hashX[2] = {hx, next(hx, kPrimeX)};
        const Words hashY[2] = {hy, next(hy, kPrimeY)};
        const Words hashZ[2] = {hz, next(hz, kPrimeZ)};
        Floats corners[8];
        for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t j = 0; j < 2; ++j)
                for (std::size_t k = 0; k < 2; ++k)
                    corners[4 * i + 2 * j + k] =
                        cornerValue(hn::Xor(hn::Xor(hashY[j], hashZ[k]), hashX[i]));
        const Floats fx = fade(x.centred);
        const Floats fy = fade(y.centred);
        const Floats fz = fade(z.centred);
        const Floats scale = constant(kScale);
        Floats alongX[4];
        for (std::size_t i = 0; i < 4; ++i)
            alongX[i] = lerp(corners[i], corners[i + 4], fx);
        const Floats alongY[2] = {lerp(alongX[0], alongX[2], fy), lerp(alongX[1], alongX[3], fy)};
        NoiseSample sample{};
        sample.value = hn::Mul(scale, lerp(alongY[0], alongY[1], fz));
        if constexpr (kWithSlope) {
            const auto step = [&](std::size_t i)
                                  HWY_ATTR { return hn::Sub(corners[i + 4], corners[i]); };
            const Floats stepX = lerp(lerp(step(0), step(2), fy), lerp(step(1), step(3), fy), fz);
            const Floats stepY =
                lerp(hn::Sub(alongX[2], alongX[0]), hn::Sub(alongX[3], alongX[1]), fz);
            const Floats stepZ = hn::Sub(alongY[1], alongY[0]);
            sample.slope[0] = hn::Mul(hn::Mul(scale, fadeSlope(x.centred)), stepX);
            sample.slope[1] = hn::Mul(hn::Mul(scale, fadeSlope(y.centred)), stepY);
            sample.slope[2] = hn::Mul(hn::Mul(scale, fadeSlope(z.centred)), stepZ);
        }
        return sample;
    }

    template <bool kWithSlope>
    static HWY_INLINE NoiseSample at(const Cell& x, const Cell& y, std::uint32_t seed)
    {
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hashX[2] = {hx, next(hx, kPrimeX)};
        const Words hashY[2] = {hy, next(hy, kPrimeY)};
        Floats corners[4];
        for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t j = 0; j < 2; ++j)
                corners[2 * i + j] = cornerValue(hn::Xor(hashX[i], hashY[j]));
        const Floats fx = fade(x.centred);
        const Floats fy = fade(y.centred);
        const Floats scale = constant(kScale);
        const Floats along[2] = {
            lerp(corners[0], corners[2], fx), lerp(corners[1], corners[3], fx)};
        NoiseSample sample{};
        sample.value = hn::Mul(scale, lerp(along[0], along[1], fy));
        if constexpr (kWithSlope) {
            const Floats stepX =
                lerp(hn::Sub(corners[2], corners[0]), hn::Sub(corners[3], corners[1]), fy);
            const Floats stepY = hn::Sub(along[1], along[0]);
            sample.slope[0] = hn::Mul(hn::Mul(scale, fadeSlope(x.centred)), stepX);
            sample.slope[1] = hn::Mul(hn::Mul(scale, fadeSlope(y.centred)), stepY);
            sample.slope[2] = hn::Zero(FloatTag());
        }
        return sample;
    }
};

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

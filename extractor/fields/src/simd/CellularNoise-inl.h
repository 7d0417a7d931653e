// Cellular noise on vectors, for each instruction set: the distance to the nearest of some
// scattered points, and how much farther the second nearest is.
//
// Based on: Worley, "A cellular texture basis function" (1996). Differs: one point a cell, kept
// within the middle three quarters of it, and distances capped at 1 1/8 cells, which no point left
// out can lie within: the noise is exactly continuous, and its slope never above 1 (2 for
// `border`).

#if defined(ISOFRONT_FIELDS_CELLULAR_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_CELLULAR_NOISE_INL_H
#undef ISOFRONT_FIELDS_CELLULAR_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_CELLULAR_NOISE_INL_H
#endif

#include "Octaves.h"
#include "simd/Lattice-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// The nearest feature points met so far: squared distances, capped, and displacements from them.
template <bool kSecond, bool kWithSlope>
struct Nearest {
    Floats first;
    Floats second;
    Floats toFirst[3];
    Floats toSecond[3];

    HWY_INLINE Nearest()
    {
        first = second = constant(kCellularCap * kCellularCap);
        for (std::size_t i = 0; i < 3; ++i)
            toFirst[i] = toSecond[i] = hn::Zero(FloatTag());
    }

    HWY_INLINE void meet(Floats square, const Floats* from, std::size_t axes)
    {
        const auto isFirst = hn::Lt(square, first);
        if constexpr (kSecond && kWithSlope) {
            const auto isSecond = hn::Lt(square, second);
            for (std::size_t i = 0; i < axes; ++i)
                toSecond[i] = hn::IfThenElse(
                    isFirst, toFirst[i], hn::IfThenElse(isSecond, from[i], toSecond[i]));
        }
        if constexpr (kWithSlope)
            for (std::size_t i = 0; i < axes; ++i)
                toFirst[i] = hn::IfThenElse(isFirst, from[i], toFirst[i]);
        if constexpr (kSecond)
            second = hn::Min(second, hn::Max(first, square));
        first = hn::Min(first, square);
    }

    [[nodiscard]] HWY_INLINE NoiseSample result(float mean) const
    {
        const Floats one = hn::Sqrt(first);
        NoiseSample sample{};
        sample.value = hn::Sub(one, constant(mean));
        // At the feature point itself the slope has no direction; any is as good.
        const auto over = [&](Floats distance)
                              HWY_ATTR { return hn::Max(distance, constant(1e-9F)); };
        if constexpr (kWithSlope)
            for (std::size_t i = 0; i < 3; ++i)
                sample.slope[i] = hn::Div(toFirst[i], over(one));
        if constexpr (kSecond) {
            const Floats two = hn::Sqrt(second);
            sample.value = hn::Sub(hn::Sub(two, one), constant(mean));
            if constexpr (kWithSlope)
                for (std::size_t i = 0; i < 3; ++i)
                    sample.slope[i] = hn::Sub(hn::Div(toSecond[i], over(two)), sample.slope[i]);
        }
        return sample;
    }
};

/// How far a feature point lies from the middle of its cell along one axis, from the upper bits.
HWY_INLINE Floats jitterOf(Words hash)
{
    return hn::Mul(
        hn::ConvertTo(FloatTag(), hn::BitCast(SignedTag(), hash)),
        constant(kCellularJitter * 0x1p-31F));
}

/// One feature point a cell. Points two cells away are left out: they are farther than the cap.
template <bool kSecond>
struct CellularNoise {
    template <bool kWithSlope>
    static HWY_INLINE NoiseSample
    at(const Cell& x, const Cell& y, const Cell& z, std::uint32_t seed)
    {
        constexpr float kMean = kSecond ? kBorderMeanSpace : kCellularMeanSpace;
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hz = hashedZ(z.index, seed);
        const Words hashX[3] = {previous(hx, kPrimeX), hx, next(hx, kPrimeX)};
        const Words hashY[3] = {previous(hy, kPrimeY), hy, next(hy, kPrimeY)};
        const Words hashZ[3] = {previous(hz, kPrimeZ), hz, next(hz, kPrimeZ)};
        const Floats one = constant(1.0F);
        const Floats fromX[3] = {hn::Add(x.centred, one), x.centred, hn::Sub(x.centred, one)};
        const Floats fromY[3] = {hn::Add(y.centred, one), y.centred, hn::Sub(y.centred, one)};
        const Floats fromZ[3] = {hn::Add(z.centred, one), z.centred, hn::Sub(z.centred, one)};
        Nearest<kSecond, kWithSlope> nearest;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                const Words hashXy = hn::Xor(hashX[i], hashY[j]);
                for (std::size_t k = 0; k < 3; ++k) {
                    const Words hash = spread(finished(hn::Xor(hashXy, hashZ[k])));
                    const Floats from[3] = {
                        hn::Sub(fromX[i], jitterOf(hash)),
                        hn::Sub(fromY[j], jitterOf(hn::ShiftLeft<11>(hash))),
                        hn::Sub(fromZ[k], jitterOf(hn::ShiftLeft<22>(hash)))};
                    const Floats square = hn::Add(
                        hn::Add(hn::Mul(from[0], from[0]), hn::Mul(from[1], from[1])),
                        hn::Mul(from[2], from[2]));
                    nearest.meet(square, from, 3);
                }
            }
        }
        return nearest.result(kMean);
    }

    template <bool kWithSlope>
    static HWY_INLINE NoiseSample at(const Cell& x, const Cell& y, std::uint32_t seed)
    {
        constexpr float kMean = kSecond ? kBorderMeanPlane : kCellularMeanPlane;
        const Words hx = hashedX(x.index, seed);
        const Words hy = hashedY(y.index, seed);
        const Words hashX[3] = {previous(hx, kPrimeX), hx, next(hx, kPrimeX)};
        const Words hashY[3] = {previous(hy, kPrimeY), hy, next(hy, kPrimeY)};
        const Floats one = constant(1.0F);
        const Floats fromX[3] = {hn::Add(x.centred, one), x.centred, hn::Sub(x.centred, one)};
        const Floats fromY[3] = {hn::Add(y.centred, one), y.centred, hn::Sub(y.centred, one)};
        Nearest<kSecond, kWithSlope> nearest;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                const Words hash = spread(finished(hn::Xor(hashX[i], hashY[j])));
                const Floats from[2] = {
                    hn::Sub(fromX[i], jitterOf(hash)),
                    hn::Sub(fromY[j], jitterOf(hn::ShiftLeft<16>(hash)))};
                const Floats square = hn::Add(hn::Mul(from[0], from[0]), hn::Mul(from[1], from[1]));
                nearest.meet(square, from, 2);
            }
        }
        return nearest.result(kMean);
    }
};

template <>
struct Noise<NoiseKind::cellular> : CellularNoise<false> {
};
template <>
struct Noise<NoiseKind::border> : CellularNoise<true> {
};

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

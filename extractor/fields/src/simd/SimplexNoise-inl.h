// Noise on simplices, on vectors, for each instruction set: gradients at the corners of a lattice
// of tetrahedra (triangles in the plane), each with a round kernel that ends at the opposite face.
//
// Based on: Perlin, "Noise hardware" (2001) and Gustavson, "Simplex noise demystified" (2005).
// Differs: no point is skewed into a cube. In space the lattice of simplex noise is the
// body-centred cubic one, two cubic lattices half a cell apart, whose corners are dyadic: cells are
// exact however far from the origin. In the plane the octave's own linear map carries the skew. The
// kernels end where the simplex does, so that value, slope and curvature have no jumps.

#if defined(ISOFRONT_FIELDS_SIMPLEX_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_SIMPLEX_NOISE_INL_H
#undef ISOFRONT_FIELDS_SIMPLEX_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_SIMPLEX_NOISE_INL_H
#endif

#include "simd/GradientNoise-inl.h"

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// The share of one corner: (r^2 - d^2)^4 times gradient and displacement, and zero beyond r.
struct Kernel {
    Floats power4;
    Floats power3;

    HWY_INLINE Kernel(Floats squaredRadius, Floats squaredDistance)
    {
        const Floats rest = hn::Max(hn::Sub(squaredRadius, squaredDistance), hn::Zero(FloatTag()));
        const Floats power2 = hn::Mul(rest, rest);
        power3 = hn::Mul(power2, rest);
        power4 = hn::Mul(power2, power2);
    }

    /// d(power4) / d(displacement), over the displacement
    [[nodiscard]] HWY_INLINE Floats slope() const { return hn::Mul(power3, constant(-8.0F)); }
};

template <>
struct Noise<NoiseKind::simplex> {
    // In space the largest possible value becomes 1; in the plane both have the same spread.
    static constexpr float kSpaceScale = 76.88075F;
    static constexpr float kPlaneScale = 11.66F;

    /// The body-centred cubic lattice: whole numbers, and those plus one half. Its Delaunay
    /// tetrahedra have two corners of either kind: the nearest, and the one beyond the point along
    /// one axis. The distance of a corner from the opposite face, 1 / sqrt(2), is the radius.
    template <bool kWithSlope>
    static HWY_INLINE NoiseSample
    at(const Cell& x, const Cell& y, const Cell& z, std::uint32_t seed)
    {
        const FloatTag d;
        const Floats half = constant(0.5F);
        const Floats zero = hn::Zero(d);
        const Cell* const cells[3] = {&x, &y, &z};
        const Words low[3] = {
            hashedX(x.index, seed), hashedY(y.index, seed), hashedZ(z.index, seed)};
        constexpr std::uint32_t kPrimes[3] = {kPrimeX, kPrimeY, kPrimeZ};

        Floats size[3];  // distance from the middle of the cell along each axis
        Floats outer[3]; // to the nearest whole corner
        Floats beyond[3];
        Floats past[3]; // to the middle of the neighbouring cell
        Words near[3];
        Words nearToFar[3];
        Words toNeighbour[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const Floats u = cells[i]->centred;
            const auto negative = hn::Lt(u, zero);
            const auto words = hn::RebindMask(WordTag(), negative);
            size[i] = hn::Abs(u);
            const Floats signedHalf = hn::IfThenElse(negative, hn::Neg(half), half);
            outer[i] = hn::Sub(u, signedHalf);
            beyond[i] = hn::Add(u, signedHalf);
            past[i] = hn::Sub(outer[i], signedHalf);
            const Words high = next(low[i], kPrimes[i]);
            near[i] = hn::IfThenElse(words, low[i], high);
            nearToFar[i] = hn::Xor(low[i], high);
            const Words neighbour = hn::IfThenElse(words, previous(low[i], kPrimes[i]), high);
            toNeighbour[i] = hn::Xor(low[i], neighbour);
        }
        // The whole corner beyond lies along the axis nearest to the cell's middle, the neighbour
        // along that farthest from it.
        const auto xLeast = hn::And(hn::Le(size[0], size[1]), hn::Le(size[0], size[2]));
        const auto yLeast = hn::AndNot(xLeast, hn::Le(size[1], size[2]));
        const auto zLeast = hn::Not(hn::Or(xLeast, yLeast));
        const auto xMost = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
        const auto yMost = hn::AndNot(xMost, hn::Ge(size[1], size[2]));
        const auto zMost = hn::Not(hn::Or(xMost, yMost));

        const auto pick = [&](auto inX, auto inY, const Words* of) HWY_ATTR {
            const WordTag w;
            return hn::IfThenElse(
                hn::RebindMask(w, inX),
                of[0],
                hn::IfThenElse(hn::RebindMask(w, inY), of[1], of[2]));
        };
        const Words whole = hn::Xor(hn::Xor(near[0], near[1]), near[2]);
        // The corners in the middles of cells need a hash of their own.
        const Words middle =
            hn::Xor(hn::Xor(low[0], low[1]), hn::Xor(low[2], hn::Set(WordTag(), 0x5bd1e995U)));
        const Words hashes[4] = {
            whole,
            hn::Xor(whole, pick(xLeast, yLeast, nearToFar)),
            middle,
            hn::Xor(middle, pick(xMost, yMost, toNeighbour))};
        const Floats displacements[4][3] = {
            {outer[0], outer[1], outer[2]},
            {hn::IfThenElse(xLeast, beyond[0], outer[0]),
             hn::IfThenElse(yLeast, beyond[1], outer[1]),
             hn::IfThenElse(zLeast, beyond[2], outer[2])},
            {x.centred, y.centred, z.centred},
            {hn::IfThenElse(xMost, past[0], x.centred),
             hn::IfThenElse(yMost, past[1], y.centred),
             hn::IfThenElse(zMost, past[2], z.centred)}};

        NoiseSample sample{};
        sample.value = zero;
        if constexpr (kWithSlope)
            sample.slope[0] = sample.slope[1] = sample.slope[2] = zero;
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const Floats* const p = displacements[corner];
            const EdgeGradient gradient(finished(hashes[corner]));
            const Kernel kernel(
                half,
                hn::Add(hn::Add(hn::Mul(p[0], p[0]), hn::Mul(p[1], p[1])), hn::Mul(p[2], p[2])));
            const Floats dot = gradient.dot(p[0], p[1], p[2]);
            sample.value = hn::Add(sample.value, hn::Mul(kernel.power4, dot));
            if constexpr (kWithSlope) {
                const Floats along = hn::Mul(kernel.slope(), dot);
                for (std::size_t i = 0; i < 3; ++i)
                    sample.slope[i] = hn::Add(sample.slope[i], hn::Mul(along, p[i]));
                gradient.addTo(sample.slope, kernel.power4);
            }
        }
        const Floats scale = constant(kSpaceScale);
        sample.value = hn::Mul(sample.value, scale);
        if constexpr (kWithSlope)
            for (Floats& slope : sample.slope)
                slope = hn::Mul(slope, scale);
        return sample;
    }

    /// The triangular lattice, in coordinates along two of its edges, 60 degrees apart and of
    /// length 1. The height of a triangle, sqrt(3) / 2, is the radius.
    template <bool kWithSlope>
    static HWY_INLINE NoiseSample at(const Cell& u, const Cell& v, std::uint32_t seed)
    {
        const Floats half = constant(0.5F);
        const Floats height = constant(0.866025404F);
        const Floats uLow = hn::Add(u.centred, half);
        const Floats uHigh = hn::Sub(u.centred, half);
        const Floats vLow = hn::Add(v.centred, half);
        const Floats vHigh = hn::Sub(v.centred, half);
        const Words hu = hashedX(u.index, seed);
        const Words hv = hashedY(v.index, seed);
        const Words huNext = next(hu, kPrimeX);
        const Words hvNext = next(hv, kPrimeY);
        // The cell is two triangles; which one, decides on the third corner.
        const auto upper = hn::Gt(hn::Add(u.centred, v.centred), hn::Zero(FloatTag()));
        const auto words = hn::RebindMask(WordTag(), upper);
        const Words hashes[3] = {
            hn::Xor(huNext, hv),
            hn::Xor(hu, hvNext),
            hn::IfThenElse(words, hn::Xor(huNext, hvNext), hn::Xor(hu, hv))};
        const Floats du[3] = {uHigh, uLow, hn::IfThenElse(upper, uHigh, uLow)};
        const Floats dv[3] = {vLow, vHigh, hn::IfThenElse(upper, vHigh, vLow)};

        const Floats scale = constant(kPlaneScale);
        Floats value = hn::Zero(FloatTag());
        Floats slopeX = value;
        Floats slopeY = value;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Floats x = hn::Add(du[corner], hn::Mul(dv[corner], half));
            const Floats y = hn::Mul(dv[corner], height);
            const TurnGradient gradient(finished(hashes[corner]));
            const Kernel kernel(constant(0.75F), hn::Add(hn::Mul(x, x), hn::Mul(y, y)));
            const Floats dot = gradient.dot(x, y);
            value = hn::Add(value, hn::Mul(kernel.power4, dot));
            if constexpr (kWithSlope) {
                const Floats along = hn::Mul(kernel.slope(), dot);
                slopeX =
                    hn::Add(slopeX, hn::Add(hn::Mul(along, x), hn::Mul(kernel.power4, gradient.x)));
                slopeY =
                    hn::Add(slopeY, hn::Add(hn::Mul(along, y), hn::Mul(kernel.power4, gradient.y)));
            }
        }
        NoiseSample sample{};
        sample.value = hn::Mul(value, scale);
        if constexpr (kWithSlope) {
            sample.slope[0] = hn::Mul(slopeX, scale);
            sample.slope[1] =
                hn::Mul(hn::Add(hn::Mul(slopeX, half), hn::Mul(slopeY, height)), scale);
            sample.slope[2] = hn::Zero(FloatTag());
        }
        return sample;
    }
};

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

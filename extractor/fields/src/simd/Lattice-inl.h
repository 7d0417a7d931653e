// The lattice that all noise stands on: cells, hashes of corners, and how to pass from one corner
// to the next. See Numbers-inl.h for the numbers.

#if defined(ISOFRONT_FIELDS_LATTICE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_LATTICE_INL_H
#undef ISOFRONT_FIELDS_LATTICE_INL_H
#else
#define ISOFRONT_FIELDS_LATTICE_INL_H
#endif

#include "isofront/fields/Noise.h"
#include "simd/Numbers-inl.h"

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// Where a lattice coordinate lies: the low 32 bits of its cell, and the place in it, counted from
/// the cell's middle, in [-1/2, 1/2].
struct Cell {
    Words index;
    Floats centred;
};

/// @param t  the lattice coordinate less one half: its nearest whole number is the cell
///
/// Exact while the magnitude is below 2^51; beyond, the same on every machine.
HWY_INLINE Cell cellOf(const DoublePair& t)
{
    const DoubleTag d;
    // Adding 1.5 * 2^52 rounds to a whole number and leaves it, in two's complement, in the low
    // bits.
    const Doubles magic = hn::Set(d, 6755399441055744.0);
    const Doubles moved0 = hn::Add(t.first, magic);
    const Doubles moved1 = hn::Add(t.second, magic);
#if HWY_TARGET == HWY_SCALAR
    const auto bits = hn::BitCast(hn::RebindToUnsigned<DoubleTag>(), moved0);
    const Words index = hn::Set(WordTag(), static_cast<std::uint32_t>(hn::GetLane(bits)));
#else
    const hn::Repartition<std::uint32_t, DoubleTag> words;
    const Words index =
        hn::ConcatEven(words, hn::BitCast(words, moved1), hn::BitCast(words, moved0));
#endif
    const Doubles whole0 = hn::Sub(moved0, magic);
    const Doubles whole1 = hn::Sub(moved1, magic);
    return {index, narrowed({hn::Sub(t.first, whole0), hn::Sub(t.second, whole1)})};
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

// ---- Hashing ------------------------------------------------------------------------------------
//
// A corner (i, j, k) hashes to ((i P + s) ^ (j Q + t) ^ (k R + u)) M modulo 2^32, with odd primes
// P, Q, R and M. The exclusive or is what makes it no linear function of the corner; the upper bits
// depend on all bits of the corner, the lower ones on few. The seeds s, t, u move the lattice along
// each axis: octaves are far places of one pattern that repeats after 2^32 cells.

inline constexpr std::uint32_t kPrimeX = 0x9e3779b1U;
inline constexpr std::uint32_t kPrimeY = 0x85ebca77U;
inline constexpr std::uint32_t kPrimeZ = 0xc2b2ae3dU;
inline constexpr std::uint32_t kFinalPrime = 0x27d4eb2dU;

// The same seed must move each axis elsewhere.
inline constexpr std::uint32_t kSeedY = 0x68e31da5U;
inline constexpr std::uint32_t kSeedZ = 0xb5297a4dU;

/// One axis's share in the hash of a corner. Adding the prime goes on to the next cell.
HWY_INLINE Words hashedAxis(Words index, std::uint32_t prime, std::uint32_t seed)
{
    const WordTag w;
    return hn::Add(hn::Mul(index, hn::Set(w, prime)), hn::Set(w, seed));
}

HWY_INLINE Words hashedX(Words index, std::uint32_t seed)
{
    return hashedAxis(index, kPrimeX, seed);
}
HWY_INLINE Words hashedY(Words index, std::uint32_t seed)
{
    return hashedAxis(index, kPrimeY, seed * kSeedY);
}
HWY_INLINE Words hashedZ(Words index, std::uint32_t seed)
{
    return hashedAxis(index, kPrimeZ, seed * kSeedZ);
}

HWY_INLINE Words next(Words hashed, std::uint32_t prime)
{
    return hn::Add(hashed, hn::Set(WordTag(), prime));
}
HWY_INLINE Words previous(Words hashed, std::uint32_t prime)
{
    return hn::Sub(hashed, hn::Set(WordTag(), prime));
}

/// The hash of a corner from the exclusive or of its axes' shares.
HWY_INLINE Words finished(Words axes)
{
    return hn::Mul(axes, hn::Set(WordTag(), kFinalPrime));
}

/// Lets all bits of a finished hash depend on the upper ones.
HWY_INLINE Words spread(Words hash)
{
    return hn::Xor(hash, hn::ShiftRight<15>(hash));
}

// ---- Interpolation ------------------------------------------------------------------------------

/// The value with its sign flipped where the word's top bit is set.
HWY_INLINE Floats signedBy(Floats value, Words word)
{
    const Words top = hn::Set(WordTag(), 0x80000000U);
#if HWY_TARGET <= HWY_AVX3
    // value ^ (word & top) as one instruction, which the compiler doesn't find.
    const auto bits = hn::BitCast(WordTag(), value);
    const Words flipped{_mm512_ternarylogic_epi32(bits.raw, word.raw, top.raw, 0x78)};
    return hn::BitCast(FloatTag(), flipped);
#else
    return hn::Xor(value, hn::BitCast(FloatTag(), hn::And(word, top)));
#endif
}

HWY_INLINE Floats lerp(Floats a, Floats b, Floats t)
{
    return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

/// 6 t^5 - 15 t^4 + 10 t^3 at t = u + 1/2: from powers of t it would lose four bits near 1.
HWY_INLINE Floats fade(Floats u)
{
    const Floats v = hn::Mul(u, u);
    const Floats inner = hn::Mul(v, hn::Sub(hn::Mul(v, constant(6.0F)), constant(5.0F)));
    return hn::Add(hn::Mul(u, hn::Add(inner, constant(1.875F))), constant(0.5F));
}

/// 30 t^2 (t - 1)^2 at t = u + 1/2
HWY_INLINE Floats fadeSlope(Floats u)
{
    const Floats product = hn::Sub(hn::Mul(u, u), constant(0.25F));
    return hn::Mul(constant(30.0F), hn::Mul(product, product));
}

/// Value and, where asked for, gradient in lattice coordinates.
struct NoiseSample {
    Floats value;
    Floats slope[3];
};

/// A kind of noise: `at<kWithSlope>(x, y, z, seed)` in space, `at<kWithSlope>(x, y, seed)` in the
/// plane, as a NoiseSample; the slope is left out without `kWithSlope`.
template <NoiseKind kKind>
struct Noise;

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

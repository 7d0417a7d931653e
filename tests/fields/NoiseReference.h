#pragma once

#include "Octaves.h"

#include <isofront/fields/Noise.h>

#include <array>
#include <cmath>
#include <cstdint>

namespace isofront::fields::test {

// Noise written once more, slowly: over the type of the arithmetic, and looking at every corner or
// feature point in reach instead of the few that matter.

/// The hash of a lattice corner.
inline std::uint32_t cornerHash(const std::array<std::int64_t, 3>& corner, std::uint32_t seed)
{
    const auto axis = [&](std::size_t i, std::uint32_t prime, std::uint32_t seedFactor) {
        return static_cast<std::uint32_t>(corner[i]) * prime + seed * seedFactor;
    };
    const std::uint32_t axes = axis(0, 0x9e3779b1U, 1U) ^ axis(1, 0x85ebca77U, 0x68e31da5U) ^
                               axis(2, 0xc2b2ae3dU, 0xb5297a4dU);
    return axes * 0x27d4eb2dU;
}

/// Corners of the plane's lattice, and the middles of cells, hash a little differently.
inline std::uint32_t planeHash(std::int64_t i, std::int64_t j, std::uint32_t seed)
{
    return ((static_cast<std::uint32_t>(i) * 0x9e3779b1U + seed) ^
            (static_cast<std::uint32_t>(j) * 0x85ebca77U + seed * 0x68e31da5U)) *
           0x27d4eb2dU;
}
inline std::uint32_t middleHash(const std::array<std::int64_t, 3>& cell, std::uint32_t seed)
{
    // Undoing the last factor: it is odd, and this is its inverse modulo 2^32.
    constexpr std::uint32_t kInverse = 0xfb699ca5U;
    static_assert(kInverse * 0x27d4eb2dU == 1U);
    return ((cornerHash(cell, seed) * kInverse) ^ 0x5bd1e995U) * 0x27d4eb2dU;
}

/// The gradient of a corner in space, times a displacement.
template <typename T>
T edgeDot(std::uint32_t hash, const std::array<T, 3>& d)
{
    // Thirds of the signed numbers pick the pair of axes.
    const auto number = static_cast<std::int32_t>(hash << 2U);
    const std::size_t u = number < 715827882 ? 0 : 1;
    const std::size_t v = number < -715827883 ? 1 : 2;
    return ((hash >> 31U) != 0 ? -d[u] : d[u]) + (((hash >> 30U) & 1U) != 0 ? -d[v] : d[v]);
}

/// The same in the plane.
template <typename T>
T turnDot(std::uint32_t hash, T x, T y)
{
    const bool steep = ((hash >> 29U) & 1U) != 0;
    const T cosine = T(0.923879533F);
    const T sine = T(0.382683432F);
    const T gx = steep ? sine : cosine;
    const T gy = steep ? cosine : sine;
    return ((hash >> 31U) != 0 ? -gx : gx) * x + (((hash >> 30U) & 1U) != 0 ? -gy : gy) * y;
}

template <typename T>
T quintic(T t)
{
    return t * t * t * (t * (t * T(6) - T(15)) + T(10));
}

/// How far the feature point of a cell lies from the cell's middle along one axis.
template <typename T>
T jitter(std::uint32_t hash, unsigned shift)
{
    const std::uint32_t mixed = hash ^ (hash >> 15U);
    return T(static_cast<std::int32_t>(mixed << shift)) * T(0.375) / T(2147483648.0);
}

template <typename T>
T cellularOf(NoiseKind kind, T first, T second, T cellularMean, T borderMean)
{
    const T cap = T(1.125);
    first = std::min(std::sqrt(first), cap);
    second = std::min(std::sqrt(second), cap);
    return kind == NoiseKind::cellular ? first - cellularMean : second - first - borderMean;
}

/// One octave in space at lattice coordinates `cell + at`, `at` within [0, 1).
template <typename T>
T spaceReference(
    NoiseKind kind,
    const std::array<std::int64_t, 3>& cell,
    const std::array<T, 3>& at,
    std::uint32_t seed)
{
    T sum = 0;
    T first = 100;
    T second = 100;
    for (std::int64_t i = -2; i <= 2; ++i) {
        for (std::int64_t j = -2; j <= 2; ++j) {
            for (std::int64_t k = -2; k <= 2; ++k) {
                const std::array<std::int64_t, 3> corner{cell[0] + i, cell[1] + j, cell[2] + k};
                const std::array<T, 3> d{at[0] - T(i), at[1] - T(j), at[2] - T(k)};
                const std::uint32_t hash = cornerHash(corner, seed);
                T tent = 1;
                for (const T& c : d)
                    tent *= std::abs(c) < 1 ? quintic(T(1) - std::abs(c)) : T(0);
                const auto round = [](const std::array<T, 3>& v, std::uint32_t h) {
                    const T rest = T(0.5) - v[0] * v[0] - v[1] * v[1] - v[2] * v[2];
                    return rest > 0 ? T(76.88075F) * rest * rest * rest * rest * edgeDot<T>(h, v)
                                    : T(0);
                };
                const T half(0.5);
                switch (kind) {
                case NoiseKind::value:
                    sum += tent * T(static_cast<std::int32_t>(hash)) / T(2147483648.0);
                    break;
                case NoiseKind::gradient:
                    sum += tent * edgeDot<T>(hash, d);
                    break;
                case NoiseKind::simplex:
                    sum += round(d, hash) +
                           round({d[0] - half, d[1] - half, d[2] - half}, middleHash(corner, seed));
                    break;
                case NoiseKind::cellular:
                case NoiseKind::border: {
                    const T x = d[0] - half - jitter<T>(hash, 0);
                    const T y = d[1] - half - jitter<T>(hash, 11);
                    const T z = d[2] - half - jitter<T>(hash, 22);
                    const T square = x * x + y * y + z * z;
                    second = std::min(second, std::max(first, square));
                    first = std::min(first, square);
                    break;
                }
                }
            }
        }
    }
    if (kind == NoiseKind::cellular || kind == NoiseKind::border)
        return cellularOf<T>(kind, first, second, kCellularMeanSpace, kBorderMeanSpace);
    return sum;
}

/// One octave in the plane at lattice coordinates `cell + at`, `at` within [0, 1).
template <typename T>
T planeReference(
    NoiseKind kind,
    const std::array<std::int64_t, 2>& cell,
    const std::array<T, 2>& at,
    std::uint32_t seed)
{
    T sum = 0;
    T first = 100;
    T second = 100;
    for (std::int64_t i = -2; i <= 2; ++i) {
        for (std::int64_t j = -2; j <= 2; ++j) {
            const std::uint32_t hash = planeHash(cell[0] + i, cell[1] + j, seed);
            const T dx = at[0] - T(i);
            const T dy = at[1] - T(j);
            const T tent = std::abs(dx) < 1 && std::abs(dy) < 1
                               ? quintic(T(1) - std::abs(dx)) * quintic(T(1) - std::abs(dy))
                               : T(0);
            switch (kind) {
            case NoiseKind::value:
                sum += tent * T(static_cast<std::int32_t>(hash)) / T(2147483648.0);
                break;
            case NoiseKind::gradient:
                sum += tent * turnDot<T>(hash, dx, dy);
                break;
            case NoiseKind::simplex: {
                const T x = dx + dy / T(2);
                const T y = dy * T(0.866025404F);
                const T rest = T(0.75) - x * x - y * y;
                if (rest > 0)
                    sum += T(11.66F) * rest * rest * rest * rest * turnDot<T>(hash, x, y);
                break;
            }
            case NoiseKind::cellular:
            case NoiseKind::border: {
                const T x = dx - T(0.5) - jitter<T>(hash, 0);
                const T y = dy - T(0.5) - jitter<T>(hash, 16);
                const T square = x * x + y * y;
                second = std::min(second, std::max(first, square));
                first = std::min(first, square);
                break;
            }
            }
        }
    }
    if (kind == NoiseKind::cellular || kind == NoiseKind::border)
        return cellularOf<T>(kind, first, second, kCellularMeanPlane, kBorderMeanPlane);
    return sum;
}

} // namespace isofront::fields::test

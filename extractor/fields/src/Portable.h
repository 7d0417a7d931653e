#pragma once

#include <isofront/core/Box.h>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace isofront::fields {

// Functions that give the same bits on every machine, which the C library's don't promise.

/// sin(2 pi turns), to 1e-12. Turns beyond 2^51 have no fraction left.
inline double sineOfTurns(double turns)
{
    // Adding and taking away 1.5 * 2^52 rounds to the nearest whole number.
    constexpr double kMagic = 6755399441055744.0;
    constexpr double kTwoPi = 6.283185307179586;
    const double fraction = turns - ((turns + kMagic) - kMagic);
    const double mirrored = (fraction < 0 ? -0.5 : 0.5) - fraction;
    const double x = kTwoPi * (std::abs(fraction) > 0.25 ? mirrored : fraction);
    const double s = x * x;
    double series = 1.0 / 355687428096000.0;
    series = series * s - 1.0 / 1307674368000.0;
    series = series * s + 1.0 / 6227020800.0;
    series = series * s - 1.0 / 39916800.0;
    series = series * s + 1.0 / 362880.0;
    series = series * s - 1.0 / 5040.0;
    series = series * s + 1.0 / 120.0;
    series = series * s - 1.0 / 6.0;
    return x + x * s * series;
}

inline double cosineOfTurns(double turns)
{
    return sineOfTurns(turns + 0.25);
}

/// The natural logarithm of a normal number above zero, to 1e-14 of 1 or of itself.
inline double logarithm(double value)
{
    constexpr std::uint64_t kMantissa = (std::uint64_t{1} << 52U) - 1;
    const auto bits = std::bit_cast<std::uint64_t>(value);
    auto exponent = static_cast<std::int64_t>(bits >> 52U) - 1023;
    double mantissa = std::bit_cast<double>((bits & kMantissa) | (std::uint64_t{1023} << 52U));
    if (mantissa > 1.4142135623730951) {
        mantissa *= 0.5;
        ++exponent;
    }
    const double s = (mantissa - 1) / (mantissa + 1);
    const double q = s * s;
    double series = 1.0 / 17;
    for (int odd = 15; odd >= 3; odd -= 2)
        series = series * q + 1.0 / odd;
    return static_cast<double>(exponent) * 0.6931471805599453 + 2 * (s + s * q * series);
}

/// Widens an interval of exact values to what rounding can make of them: to float at the end, and
/// in double on the way, from coordinates of the given magnitude.
inline core::Interval rounded(double low, double high, double magnitude)
{
    const double ulp = double(std::numeric_limits<float>::epsilon());
    const double tiny = 1e-14 * magnitude + double(std::numeric_limits<float>::min());
    return {low - ulp * std::abs(low) - tiny, high + ulp * std::abs(high) + tiny};
}

inline double magnitudeOf(const core::Box& box)
{
    const glm::dvec3 far = glm::max(glm::abs(box.low), glm::abs(box.high));
    return std::max({far.x, far.y, far.z});
}

} // namespace isofront::fields

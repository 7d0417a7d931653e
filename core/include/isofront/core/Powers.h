#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace isofront::core {

// Powers for what decides where a surface is sampled, and how finely: the same bits on every
// machine. Those of a mathematical library may differ in the last bit from one to the next.

namespace detail {

/// base[i] is 2^(i / size), rounded to the nearest double.
template <std::size_t kSize>
double powerOfTwo(int numerator, const std::array<double, kSize>& base)
{
    const int size = static_cast<int>(kSize);
    const int rest = (numerator % size + size) % size;
    return std::ldexp(base[static_cast<std::size_t>(rest)], (numerator - rest) / size);
}

} // namespace detail

/// 2^(thirds / 3), within half a unit of the last place where it is no subnormal number.
inline double twoToThirds(int thirds)
{
    constexpr std::array kBase{1.0, 1.2599210498948731648, 1.5874010519681994748};
    return detail::powerOfTwo(thirds, kBase);
}

/// 2^(eighths / 8), as exactly.
inline double twoToEighths(int eighths)
{
    constexpr std::array kBase{
        1.0,
        1.0905077326652576592,
        1.1892071150027210667,
        1.2968395546510096659,
        1.4142135623730950488,
        1.5422108254079408236,
        1.6817928305074290861,
        1.8340080864093424635};
    return detail::powerOfTwo(eighths, kBase);
}

/// base^exponent by repeated multiplication, in the order of the exponent's bits.
inline double wholePower(double base, unsigned exponent)
{
    double power = 1;
    for (double square = base; exponent != 0; exponent /= 2, square *= square)
        if (exponent % 2 != 0)
            power *= square;
    return power;
}

/// The cube root of a number above zero, to a few units of the last place.
inline double cubeRoot(double value)
{
    int exponent = 0;
    const double mantissa = std::frexp(value, &exponent); // in [1/2, 1)
    const int rest = (exponent % 3 + 3) % 3;
    const double scaled = std::ldexp(mantissa, rest); // in [1/2, 4)
    double root = 1;
    // Newton's steps double the digits; six are enough from there, and a seventh changes nothing.
    for (int step = 0; step < 7; ++step)
        root = (2 * root + scaled / (root * root)) / 3;
    return std::ldexp(root, (exponent - rest) / 3);
}

} // namespace isofront::core

#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace isofront::voxels {

/// The linear value of an 8-bit sRGB one.
inline float linear(std::uint32_t code)
{
    const double c = code / 255.0;
    return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

/// That of all of them.
inline std::array<float, 256> linearOfCodes()
{
    std::array<float, 256> values{};
    for (std::uint32_t code = 0; code < 256; ++code)
        values[code] = linear(code);
    return values;
}

} // namespace isofront::voxels

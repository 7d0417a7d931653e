#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::extractor {

/// What no unit vector is stored as: two numbers of -32768.
inline constexpr std::uint32_t kNoNormalCode = 0x80008000U;

/// Unit vectors against gradients, as they are stored: `octahedral(outward(gradient))` of many
/// vertices at once, bit for bit, with the best instruction set that the machine has.
///
/// @param gradients  by axis, `count` each, which may be anything
/// @param codes      receive the two numbers of each, the first in the lower half; kNoNormalCode
///                   where the gradient vanishes or isn't finite
void encodeNormals(
    const std::array<const double*, 3>& gradients, std::size_t count, std::uint32_t* codes);

} // namespace isofront::extractor

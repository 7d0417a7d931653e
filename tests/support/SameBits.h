#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::tests {

/// How many of the numbers differ in a bit, so that 0 and -0 do, and a NaN and itself don't; one if
/// there are more of one than of the other.
inline std::size_t differingBits(const std::vector<float>& a, const std::vector<float>& b)
{
    std::size_t count = a.size() == b.size() ? 0U : 1U;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        count += std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i]) ? 1U : 0U;
    return count;
}

} // namespace isofront::tests

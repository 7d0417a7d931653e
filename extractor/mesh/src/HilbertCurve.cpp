#include "HilbertCurve.h"

#include <utility>

namespace isofront::extractor {

std::array<std::uint32_t, 3> hilbertCell(std::uint32_t step, unsigned order)
{
    std::array<std::uint32_t, 3> x{};
    if (order == 0)
        return x;
    // bit 3 k + 2 - i of the step is bit k of coordinate i of the transposed index
    for (unsigned k = 0; k < order; ++k)
        for (unsigned i = 0; i < 3; ++i)
            x[i] |= (step >> (3 * k + 2 - i) & 1U) << k;

    // Gray decode
    const std::uint32_t carried = x[2] >> 1U;
    x[2] ^= x[1];
    x[1] ^= x[0];
    x[0] ^= carried;
    // undo the excess work of the recursive construction
    for (std::uint32_t q = 2; q != 1U << order; q <<= 1U) {
        const std::uint32_t below = q - 1;
        for (unsigned i = 3; i-- > 0;) {
            if ((x[i] & q) != 0) {
                x[0] ^= below;
            } else {
                const std::uint32_t exchanged = (x[0] ^ x[i]) & below;
                x[0] ^= exchanged;
                x[i] ^= exchanged;
            }
        }
    }
    return x;
}

} // namespace isofront::extractor

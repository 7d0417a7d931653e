#pragma once

#include <array>
#include <cstdint>

namespace isofront::extractor {

/// The cell that a Hilbert curve through a cube of (2^order)^3 cells visits at a step. It starts at
/// the low corner, and consecutive cells share a face.
///
/// Source: J. Skilling, "Programming the Hilbert curve" (2004), from transposed index to axes.
std::array<std::uint32_t, 3> hilbertCell(std::uint32_t step, unsigned order);

} // namespace isofront::extractor

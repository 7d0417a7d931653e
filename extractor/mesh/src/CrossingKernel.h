#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::extractor {

/// Lattice edges that the surface cuts, as structure of arrays, so that many crossings are computed
/// at once. What lies beyond the edges in use may be anything.
struct CrossingBlock {
    static constexpr std::size_t kSize = 64;

    struct End {
        /// Weights of the sample point, by the corners of the cell.
        alignas(64) std::array<std::array<std::uint32_t, 4>, kSize> weights{};
        alignas(64) std::array<float, kSize> value{}; ///< of the field
    };
    End inside;
    End outside;
    /// Units of the grid that a vertex is snapped to, in a sample unit.
    alignas(64) std::array<double, kSize> unitsPerSample{};

    alignas(64) std::array<double, kSize> t{}; ///< found by `placeShares`: see there
    /// Found by `placeCrossings`: whole numbers of the units above, by axis.
    std::array<std::array<double, kSize>, 3> position{};
};

/// Where the values cross the isovalue on the way from the inside end to the outside end, as a
/// share of it, kept away from both ends by `clampedCrossing`. With the best instruction set that
/// the machine has; the same bits with each.
///
/// An outside end at or above the isovalue is one where the data ends: there the share is the
/// greatest.
void placeShares(CrossingBlock& block, std::size_t count, double isovalue);

/// Where the crossings are, from their shares.
/// @param corners  of the cell, by corner and axis [lattice units]
void placeCrossings(
    CrossingBlock& block, std::size_t count, const std::array<std::array<double, 3>, 4>& corners);

} // namespace isofront::extractor

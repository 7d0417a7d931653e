#pragma once

#include <array>
#include <cstddef>

namespace isofront::extractor {

/// Where the sample points of a cell go: columns as long as the weights.
struct PointTargets {
    std::array<double*, 3> sampleUnits; ///< exact integers
    std::array<double*, 3> field;
};

/// Places points by their weights of four corners, with the best instruction set that the machine
/// has: exact sums, and one product and one sum in field space, so the same bits on each of them.
///
/// @param weights  by corner, of each point
/// @param corners  by corner and axis [lattice units]
/// @param origin   of the domain [field]
/// @param unit     a sample unit [field]
void placePoints(
    const std::array<const double*, 4>& weights,
    const std::array<std::array<double, 3>, 4>& corners,
    const std::array<double, 3>& origin,
    double unit,
    std::size_t count,
    const PointTargets& targets);

} // namespace isofront::extractor

#pragma once

#include <array>
#include <cstddef>

namespace isofront::extractor {

/// Places points by their weights of four corners, with the best instruction set that the machine
/// has: exact sums, and one product and one sum in field space, so the same bits on each of them.
///
/// @param weights  by corner, of each point
/// @param corners  by corner and axis [lattice units]
/// @param origin   of the domain [field]
/// @param unit     a sample unit [field]
/// @param targets  receive the points, by axis [field]
void placePoints(
    const std::array<const double*, 4>& weights,
    const std::array<std::array<double, 3>, 4>& corners,
    const std::array<double, 3>& origin,
    double unit,
    std::size_t count,
    const std::array<double*, 3>& targets);

} // namespace isofront::extractor

#pragma once

#include "HeightRange.h"

#include <glm/vec2.hpp>

#include <array>
#include <cstddef>
#include <span>

namespace isofront::elevation {

/// Points that are sampled together.
inline constexpr std::size_t kBlock = 64;

using BlockOfDoubles = std::array<double, kBlock>;

/// Points of a block. Entries from `size` on are read, but mean nothing.
struct HeightPoints {
    std::size_t size = 0; ///< at most kBlock
    BlockOfDoubles x, y;  ///< [m]; any numbers
    BlockOfDoubles radius;
};

/// Heights, and how they change. Entries from the block's size on mean nothing.
struct HeightSlopes {
    BlockOfDoubles height; ///< [m]
    BlockOfDoubles alongX; ///< [m / m]; only where they were asked for
    BlockOfDoubles alongY;
};

/// A pyramid as the kernel sees it.
struct HeightLevels {
    std::span<const PaddedGrid* const> grids; ///< finest first, at least one
    glm::dvec2 origin{0.0};                   ///< of the posts of the finest [m]
    glm::dvec2 postsPerMetre{1.0};
    glm::dvec2 lastPost{1.0};  ///< points are clamped to the posts; NaN to the first
    double cyclesPerMetre = 1; ///< f_0
};

/// exp(-x^2) for x >= 0, the same bits everywhere: 1 below 1/64, 0 from 3 on and for NaN, never
/// increasing; within 3e-4 of the exponential.
double filterWeight(double x);

/// The sum of levels that ElevationField is. Runs on the best instruction set of the machine, with
/// the same bits on all of them, wherever a point stands in its block.
void sumLevels(
    const HeightLevels& levels, const HeightPoints& points, bool hasSlopes, HeightSlopes& out);

} // namespace isofront::elevation

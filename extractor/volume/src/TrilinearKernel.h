#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::volume::detail {

/// Points that are sampled together.
inline constexpr std::size_t kBlock = 64;

template <typename Value>
using BlockOf = std::array<Value, kBlock>;

/// How coordinates along one axis of a volume fall into the cells between the nodes of a grid.
struct AxisCells {
    double limit = 0;     ///< coordinates are clamped to [0, limit]; NaN becomes 0
    double scale = 1;     ///< cells for a unit of the coordinates
    int lastCell = 0;     ///< takes what lies beyond it
    double lastRatio = 1; ///< length of other cells by that of the last
};

/// Where points lie along one axis.
struct CellPlaces {
    BlockOf<std::int32_t> cell;
    BlockOf<double> t; ///< within the cell, 0 at its low and 1 at its high node
};

/// Values at the corners of the points' cells, by 4 z + 2 y + x.
using CellCorners = std::array<BlockOf<double>, 8>;

// Each runs on the best instruction set of the machine, with the same bits on all of them. Entries
// beyond `count` are read, whatever they are, and what comes of them means nothing.

void placeInCells(
    const AxisCells& axis, const BlockOf<double>& coordinates, std::size_t count, CellPlaces& out);

/// Interpolates along x, then y, then z, in an order of operations that is part of the contract of
/// samples: `a + t * (b - a)` each.
/// @param guarded  a node of weight zero has no influence even if it isn't finite
void interpolateCells(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool guarded,
    BlockOf<double>& out);

} // namespace isofront::volume::detail

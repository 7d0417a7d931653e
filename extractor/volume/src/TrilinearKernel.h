#pragma once

#include <glm/ext/vector_int3_sized.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace isofront::volume::detail {

/// Points that are sampled together.
inline constexpr std::size_t kBlock = 64;

template <typename Value>
using BlockOf = std::array<Value, kBlock>;

/// How the nodes of a grid are kept: as numbers, or as codes, which stand for `low + step * code`.
/// Codes of 12 bits lie two in three bytes, with an even number of them from row to row and a byte
/// more after the last.
enum class NodeType {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    float32,
    float64,
    codes12,
    codes16
};

/// That of numbers.
template <typename T>
constexpr NodeType nodeTypeOf()
{
    if constexpr (std::is_same_v<T, std::int8_t>)
        return NodeType::int8;
    else if constexpr (std::is_same_v<T, std::uint8_t>)
        return NodeType::uint8;
    else if constexpr (std::is_same_v<T, std::int16_t>)
        return NodeType::int16;
    else if constexpr (std::is_same_v<T, std::uint16_t>)
        return NodeType::uint16;
    else if constexpr (std::is_same_v<T, std::int32_t>)
        return NodeType::int32;
    else if constexpr (std::is_same_v<T, std::uint32_t>)
        return NodeType::uint32;
    else if constexpr (std::is_same_v<T, float>)
        return NodeType::float32;
    else
        return NodeType::float64;
}

/// How coordinates along one axis of a volume fall into the cells between the nodes of a grid.
struct AxisCells {
    double limit = 0;     ///< coordinates are clamped to [0, limit]; NaN becomes 0
    double scale = 1;     ///< cells for a unit of the coordinates
    int lastCell = 0;     ///< takes what lies beyond it; may be that of the last node alone
    double lastRatio = 1; ///< length of other cells by that of the last
};

/// A grid of nodes, which someone else owns, between which to interpolate.
struct NodeGrid {
    const void* nodes = nullptr; ///< x fastest, then y
    NodeType type = NodeType::float32;
    glm::ivec3 size{1};     ///< nodes along each axis, at least 1
    std::int64_t row = 1;   ///< nodes from a row to the next
    std::int64_t slice = 1; ///< nodes from a slice to the next
    std::array<AxisCells, 3> axes;
    double low = 0; ///< of codes
    double step = 1;

    /// From the first to the last, and one.
    [[nodiscard]] std::int64_t count() const
    {
        return (size.z - 1) * slice + (size.y - 1) * row + size.x;
    }
};

/// Points of a block. Entries from `size` on may be anything, and are read.
struct Block {
    std::size_t size = 0; ///< at most kBlock
    std::array<BlockOf<double>, 3> coordinate;
    BlockOf<double> step; ///< to the places around a point
};

/// The places about a point at which a grid may be sampled: the point itself, then a step above and
/// a step below it along x, y and z.
inline constexpr std::size_t kProbes = 7;

/// Which of them are wanted.
struct Probes {
    bool centre = true;
    bool around = false;
};

/// Values at a block's points, for each probe. Entries from the block's size on mean nothing.
using Probed = std::array<BlockOf<double>, kProbes>;

// All interpolate along x, then y, then z, in an order of operations that is part of the contract
// of samples: `a + t * (b - a)` each. A floating-point node of weight zero has no influence even if
// it isn't finite. They run on the best instruction set of the machine, with the same bits on all
// of them.

/// Where points lie along one axis of an unbounded lattice of nodes.
struct CellPlaces {
    BlockOf<std::int32_t> cell;
    BlockOf<double> t; ///< within the cell, from 0 to below 1
};

/// Places coordinates that are clamped to [low, high], NaN to `low`, and then multiplied by
/// `scale`. Entries of `out` from `count` on mean nothing.
void placeInCells(
    const BlockOf<double>& coordinates,
    std::size_t count,
    double low,
    double high,
    double scale,
    CellPlaces& out);

/// Nodes at the corners of cells, by 4 z + 2 y + x.
using CellCorners = std::array<BlockOf<double>, 8>;

/// Interpolates between nodes that have been looked up elsewhere.
/// @param isGuarded  they are floating-point
void interpolateCells(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool isGuarded,
    BlockOf<double>& out);

/// Samples a grid of numbers, in double.
void probe(const NodeGrid& grid, const Block& points, const Probes& probes, Probed& values);

/// Samples a grid and adds to each value as much of it as a weight says; where that is zero, the
/// value stays as it is. Codes are interpolated in float, numbers in double; sums are in double.
/// @param weights  one for each point, >= 0
void addProbed(
    const NodeGrid& grid,
    const Block& points,
    const Probes& probes,
    const BlockOf<double>& weights,
    Probed& values);

} // namespace isofront::volume::detail

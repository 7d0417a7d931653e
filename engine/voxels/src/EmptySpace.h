#pragma once

#include "WeightedVoxel.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::voxels {

/// A label of a connected part of empty space within a chunk; kFull for a voxel.
using EmptyLabel = std::uint32_t;
inline constexpr EmptyLabel kFull = 0xffffffffU;

/// The parts of a chunk's empty space: which cubes without a voxel are connected across faces.
///
/// Kept as runs along x, so that the work is that of rows and voxels, not of all 16 million cubes.
/// Labels count from 0 in the order in which parts are met along x, then y, then z.
class EmptySpace {
public:
    /// @param voxels  of one chunk, in their order (Voxel::order); a mark in `kept` says which
    /// stand
    EmptySpace();
    void build(std::span<const WeightedVoxel> voxels);

    /// How many parts there are.
    [[nodiscard]] std::uint32_t parts() const { return _parts; }
    /// The label of a cube in the chunk.
    [[nodiscard]] EmptyLabel at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;

    /// A border layer of a chunk, as runs of equal labels along its rows, row by row.
    struct LayerRun {
        std::uint32_t length;
        EmptyLabel label;
    };
    /// @param face  which; rows run along the lower of its two axes
    [[nodiscard]] std::vector<LayerRun> layer(Face face) const;

private:
    struct Run {
        std::uint16_t begin = 0;
        std::uint16_t end = 0; ///< not one of it
        EmptyLabel label = 0;
    };
    [[nodiscard]] std::span<const Run> row(std::uint32_t y, std::uint32_t z) const
    {
        const std::size_t index = y + std::size_t{kChunkEdge} * z;
        return {_runs.data() + _rowBegin[index], _runs.data() + _rowBegin[index + 1]};
    }
    EmptyLabel root(EmptyLabel label);
    void connect(std::size_t rowA, std::size_t rowB);

    std::vector<std::uint32_t> _rowBegin;
    std::vector<Run> _runs;
    std::vector<EmptyLabel> _parent; ///< by run, while connecting
    std::uint32_t _parts = 0;
};

} // namespace isofront::voxels

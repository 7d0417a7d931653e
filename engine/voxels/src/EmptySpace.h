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
/// Kept as runs along x, so that the work is that of rows and voxels, not of all 16 million cubes;
/// rows side by side along y without a voxel share one run.
/// Labels count from 0 in the order in which parts are met along x, then y, then z.
class EmptySpace {
public:
    EmptySpace();
    /// @param voxels  of one chunk, in their order (Voxel::order)
    void build(std::span<const WeightedVoxel> voxels);

    /// How many parts there are.
    [[nodiscard]] std::uint32_t parts() const { return _parts; }
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

public:
    /// Tells the labels of a row's cubes one after the other.
    class RowCursor {
    public:
        RowCursor() = default;
        explicit RowCursor(std::span<const Run> runs)
            : _run(runs.data()), _end(runs.data() + runs.size())
        {
        }
        /// @param x  never less than before
        [[nodiscard]] EmptyLabel at(std::uint32_t x)
        {
            while (_run != _end && _run->end <= x)
                ++_run;
            return _run != _end && _run->begin <= x ? _run->label : kFull;
        }

    private:
        const Run* _run = nullptr;
        const Run* _end = nullptr;
    };
    /// Of a row in the chunk.
    [[nodiscard]] RowCursor along(std::uint32_t y, std::uint32_t z) const
    {
        return RowCursor(row(y, z));
    }

private:
    [[nodiscard]] std::span<const Run> row(std::uint32_t y, std::uint32_t z) const
    {
        const std::size_t index = y + std::size_t{kChunkEdge} * z;
        return {_runs.data() + _rows[index].begin, _runs.data() + _rows[index].end};
    }
    /// Whether a row has no voxel.
    [[nodiscard]] bool isWhole(std::size_t row) const
    {
        if (_rows[row].end != _rows[row].begin + 1)
            return false;
        const Run& run = _runs[_rows[row].begin];
        return run.begin == 0 && run.end == kChunkEdge;
    }
    [[nodiscard]] bool areShared(std::size_t rowA, std::size_t rowB) const
    {
        return _rows[rowA].begin == _rows[rowB].begin && _rows[rowA].end == _rows[rowB].end &&
               _rows[rowA].begin != _rows[rowA].end;
    }
    EmptyLabel root(EmptyLabel label);
    void connect(std::size_t rowA, std::size_t rowB);

    /// A row's runs.
    struct Row {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
    };
    std::vector<Row> _rows;
    std::vector<Run> _runs;
    std::vector<EmptyLabel> _parent; ///< by run, while connecting
    std::uint32_t _parts = 0;
};

} // namespace isofront::voxels

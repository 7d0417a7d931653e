#pragma once

#include "WeightedVoxel.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// The voxels of one chunk while surface is added: found by their place in constant time, in
/// memory for the blocks of 4^3 that have any. What is taken out makes room for what comes, so that
/// who adds and takes from low z to high ones needs memory for some layers only: little enough for
/// the processor's caches.
class VoxelGrid {
public:
    /// Layers of voxels that are taken at once: those of a layer of blocks.
    static constexpr std::uint32_t kLayers = 4;
    static constexpr std::uint32_t kTakes = kChunkEdge / kLayers;

    /// Begins another chunk; empty before.
    /// @param coloured  whether voxels are to have colours
    void begin(bool coloured) { _coloured = coloured; }

    /// Which voxel is at a place in the chunk; new ones are without weights.
    [[gnu::always_inline]] inline std::uint32_t
    at(std::uint32_t x, std::uint32_t y, std::uint32_t z)
    {
        std::uint32_t& layer = _layers[z / kEdge];
        if (layer == kNone)
            layer = addLayer();
        const std::uint32_t name = x / kEdge | (y / kEdge) << kBits;
        std::uint32_t& block = _tables[layer].blockOf[name];
        if (block == kNone)
            block = addBlock(_tables[layer], name);
        const std::uint32_t inside = x % kEdge | (y % kEdge) << 2U | (z % kEdge) << 4U;
        _held[block] |= std::uint64_t{1} << inside;
        return block * kInBlock + inside;
    }
    [[nodiscard]] WeightedSurface& surface(std::uint32_t which)
    {
        return _surfaces[which / kInBlock][which % kInBlock];
    }
    /// Of coloured ones.
    [[nodiscard]] WeightedColour& colour(std::uint32_t which)
    {
        return _colours[which / kInBlock][which % kInBlock];
    }
    void mark(std::uint32_t which)
    {
        _marked[which / kInBlock] |= std::uint64_t{1} << which % kInBlock;
    }

    /// Calls `body(which, place, isMarked)` for each voxel of some layers, or each that is marked,
    /// along x, then y, then z; and takes them out.
    /// @param layers  from kLayers times this on, below kTakes; all are taken in the end
    /// @return how many there were
    template <typename Body>
    std::size_t take(std::uint32_t layers, bool markedOnly, const Body& body)
    {
        std::uint32_t& layer = _layers[layers];
        if (layer == kNone)
            return 0;
        Table& table = _tables[layer];
        std::size_t count = 0;
        std::array<std::size_t, kRow + 1> begin{};
        _taken.clear();
        for (std::uint32_t row = 0; row < kRow; ++row) {
            begin[row] = _taken.size();
            for (std::uint64_t bits = table.rows[row]; bits != 0; bits &= bits - 1) {
                const auto x = static_cast<std::uint32_t>(std::countr_zero(bits));
                const std::uint32_t block = table.blockOf[x | row << kBits];
                const std::uint64_t marked = _marked[block];
                const std::uint64_t held = _held[block];
                _taken.push_back({markedOnly ? marked : held, marked, block * kInBlock, x * kEdge});
                count += static_cast<std::size_t>(std::popcount(held));
                table.blockOf[x | row << kBits] = kNone;
            }
            table.rows[row] = 0;
        }
        begin[kRow] = _taken.size();
        for (std::uint32_t z = layers * kEdge; z < (layers + 1) * kEdge; ++z)
            for (std::uint32_t row = 0; row < kRow; ++row)
                for (std::uint32_t y = row * kEdge; y < (row + 1) * kEdge; ++y)
                    for (std::size_t i = begin[row]; i < begin[row + 1]; ++i) {
                        Taken& block = _taken[i];
                        for (std::uint64_t bits = block.bits & kRowBits; bits != 0;
                             bits &= bits - 1) {
                            const auto x = static_cast<std::uint32_t>(std::countr_zero(bits));
                            body(
                                block.which + x,
                                packPlace(block.x + x, y, z, 0),
                                (block.marked >> x & 1U) != 0);
                        }
                        block.bits >>= kEdge;
                        block.marked >>= kEdge;
                        block.which += kEdge;
                    }
        for (const Taken& block : _taken)
            _freeBlocks.push_back(block.which / kInBlock - 1); // all its rows were passed
        _freeTables.push_back(layer);
        layer = kNone;
        return count;
    }

private:
    static constexpr std::uint32_t kEdge = kLayers; ///< of a block [voxels]
    static constexpr std::uint32_t kInBlock = kEdge * kEdge * kEdge;
    static constexpr std::uint64_t kRowBits = (1U << kEdge) - 1;
    static constexpr std::uint32_t kBits = 6;          ///< of a block's place along an axis
    static constexpr std::uint32_t kRow = 1U << kBits; ///< blocks, as many as a word has bits
    static constexpr std::uint32_t kNone = 0xffffffffU;
    static_assert(kEdge * kRow == kChunkEdge);

    /// The blocks of a layer.
    struct Table {
        Table() { blockOf.fill(kNone); }
        std::array<std::uint32_t, kRow * kRow> blockOf; ///< x lowest
        std::array<std::uint64_t, kRow> rows{};         ///< which there are
    };
    /// A block while its voxels are taken, row by row.
    struct Taken {
        std::uint64_t bits = 0;   ///< of its voxels that count; those of the next row first
        std::uint64_t marked = 0; ///< the same
        std::uint32_t which = 0;  ///< first voxel of the next row
        std::uint32_t x = 0;      ///< of its voxels
    };

    // rare, and kept out of the way of what isn't
    [[gnu::noinline]] std::uint32_t addLayer()
    {
        if (_freeTables.empty()) {
            _freeTables.push_back(static_cast<std::uint32_t>(_tables.size()));
            _tables.emplace_back();
        }
        const std::uint32_t layer = _freeTables.back();
        _freeTables.pop_back();
        return layer;
    }
    [[gnu::noinline]] std::uint32_t addBlock(Table& table, std::uint32_t name)
    {
        if (_freeBlocks.empty()) {
            _freeBlocks.push_back(static_cast<std::uint32_t>(_held.size()));
            _held.emplace_back();
            _marked.emplace_back();
            _surfaces.emplace_back();
        }
        const std::uint32_t block = _freeBlocks.back();
        _freeBlocks.pop_back();
        table.rows[name >> kBits] |= std::uint64_t{1} << (name & (kRow - 1));
        _held[block] = 0;
        _marked[block] = 0;
        _surfaces[block].fill({});
        if (_coloured) {
            _colours.resize(_held.size());
            _colours[block].fill({});
        }
        return block;
    }
    static constexpr std::array<std::uint32_t, kRow> noLayers()
    {
        std::array<std::uint32_t, kRow> layers{};
        layers.fill(kNone);
        return layers;
    }

    std::array<std::uint32_t, kRow> _layers = noLayers();
    std::vector<Table> _tables;
    std::vector<std::uint32_t> _freeTables;
    // of each block
    std::vector<std::uint64_t> _held;   ///< which voxels there are, x lowest
    std::vector<std::uint64_t> _marked; ///< which of them are marked
    std::vector<std::array<WeightedSurface, kInBlock>> _surfaces;
    std::vector<std::array<WeightedColour, kInBlock>> _colours; ///< where they are coloured
    std::vector<std::uint32_t> _freeBlocks;
    std::vector<Taken> _taken;
    bool _coloured = false;
};

} // namespace isofront::voxels

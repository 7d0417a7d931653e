#pragma once

#include "WeightedVoxel.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// The voxels of one chunk while triangles are added: found by their place in constant time, in
/// memory for those that there are.
class VoxelGrid {
public:
    VoxelGrid() : _blockOf(kBlocks, kNone) {}

    /// Which voxel is at a place in the chunk; new ones are without weights.
    std::uint32_t at(std::uint32_t x, std::uint32_t y, std::uint32_t z)
    {
        const std::uint32_t name = nameOf(x, y, z);
        std::uint32_t& block = _blockOf[name];
        if (block == kNone) {
            block = static_cast<std::uint32_t>(_blocks.size());
            _blocks.emplace_back();
            _named.push_back(name);
        }
        const std::uint32_t inside = x % kEdge | (y % kEdge) << 3U | (z % kEdge) << 6U;
        std::uint32_t& index = _blocks[block].index[inside];
        if (index == 0) {
            _voxels.push_back({packPlace(x, y, z, 0), {}, 0});
            if (_coloured)
                _colours.emplace_back();
            index = static_cast<std::uint32_t>(_voxels.size());
            _blocks[block].held[z % kEdge] |= rowBit(x, y);
        }
        return index - 1;
    }
    [[nodiscard]] WeightedVoxel& voxel(std::uint32_t which) { return _voxels[which]; }
    /// Of coloured ones.
    [[nodiscard]] WeightedColour& colour(std::uint32_t which) { return _colours[which]; }
    /// Marks a voxel that there is.
    void mark(std::uint32_t x, std::uint32_t y, std::uint32_t z)
    {
        _blocks[_blockOf[nameOf(x, y, z)]].marked[z % kEdge] |= rowBit(x, y);
    }

    [[nodiscard]] std::size_t size() const { return _voxels.size(); }

    /// Calls `body(which)` for each voxel, or each that is marked, along x, then y, then z.
    template <typename Body>
    void forEachInOrder(bool markedOnly, const Body& body) const
    {
        constexpr std::uint32_t kRow = 1U << kBits; // blocks
        std::vector<const Block*> blocks;           // of a layer, row by row
        std::array<std::size_t, kRow + 1> begin{};
        for (std::uint32_t layer = 0; layer < kRow; ++layer) {
            blocks.clear();
            for (std::uint32_t row = 0; row < kRow; ++row) {
                begin[row] = blocks.size();
                const std::uint32_t name = row << kBits | layer << 2 * kBits;
                for (std::uint32_t x = 0; x < kRow; ++x)
                    if (_blockOf[name + x] != kNone)
                        blocks.push_back(&_blocks[_blockOf[name + x]]);
            }
            begin[kRow] = blocks.size();
            for (std::uint32_t z = 0; z < kEdge; ++z)
                for (std::uint32_t row = 0; row < kRow; ++row)
                    for (std::uint32_t y = 0; y < kEdge; ++y)
                        for (std::size_t i = begin[row]; i < begin[row + 1]; ++i) {
                            const Block& block = *blocks[i];
                            std::uint64_t bits =
                                (markedOnly ? block.marked : block.held)[z] >> y * kEdge & 0xffU;
                            for (; bits != 0; bits &= bits - 1) {
                                const auto x = static_cast<std::uint32_t>(std::countr_zero(bits));
                                body(block.index[x | y << 3U | z << 6U] - 1);
                            }
                        }
        }
    }

    /// @param coloured  whether voxels are to have colours
    void clear(bool coloured)
    {
        _coloured = coloured;
        _colours.clear();
        for (const std::uint32_t name : _named)
            _blockOf[name] = kNone;
        _named.clear();
        _blocks.clear();
        _voxels.clear();
    }

private:
    static constexpr std::uint32_t kEdge = 8; ///< of a block [voxels]
    static constexpr std::uint32_t kBits = 5; ///< of a block's place along an axis
    static constexpr std::size_t kBlocks = 1U << 3 * kBits;
    static constexpr std::uint32_t kNone = 0xffffffffU;
    static_assert(kEdge << kBits == kChunkEdge);

    struct Block {
        /// Of a voxel, plus one; 0: none.
        std::array<std::uint32_t, std::size_t{kEdge} * kEdge * kEdge> index{};
        std::array<std::uint64_t, kEdge> held{};   ///< which voxels there are, by layer
        std::array<std::uint64_t, kEdge> marked{}; ///< which of them are marked
    };
    static std::uint32_t nameOf(std::uint32_t x, std::uint32_t y, std::uint32_t z)
    {
        return x / kEdge | (y / kEdge) << kBits | (z / kEdge) << 2 * kBits;
    }
    static std::uint64_t rowBit(std::uint32_t x, std::uint32_t y)
    {
        return std::uint64_t{1} << (x % kEdge | (y % kEdge) << 3U);
    }
    std::vector<std::uint32_t> _blockOf;
    std::vector<std::uint32_t> _named;
    std::vector<Block> _blocks;
    std::vector<WeightedVoxel> _voxels;
    std::vector<WeightedColour> _colours;
    bool _coloured = false;
};

} // namespace isofront::voxels

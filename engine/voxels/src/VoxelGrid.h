#pragma once

#include "WeightedVoxel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::voxels {

/// The voxels of one chunk while triangles are added: found by their place in constant time, in
/// memory for those that there are.
class VoxelGrid {
public:
    VoxelGrid() : _blockOf(kBlocks, kNone) {}

    /// The voxel at a place in the chunk, new ones without weights. Valid until the next call.
    WeightedVoxel& at(std::uint32_t x, std::uint32_t y, std::uint32_t z)
    {
        const std::uint32_t name = x / kEdge | (y / kEdge) << kBits | (z / kEdge) << 2 * kBits;
        std::uint32_t& block = _blockOf[name];
        if (block == kNone) {
            block = static_cast<std::uint32_t>(_blocks.size());
            _blocks.emplace_back();
            _named.push_back(name);
        }
        const std::uint32_t inside = x % kEdge | (y % kEdge) << 3U | (z % kEdge) << 6U;
        std::uint32_t& index = _blocks[block].index[inside];
        if (index == 0) {
            _voxels.push_back({packPlace(x, y, z, 0), {}, 0, {}});
            index = static_cast<std::uint32_t>(_voxels.size());
        }
        return _voxels[index - 1];
    }

    /// In the order in which they came.
    [[nodiscard]] std::span<const WeightedVoxel> voxels() const { return _voxels; }

    void clear()
    {
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
        std::array<std::uint32_t, std::size_t{kEdge} * kEdge * kEdge>
            index{}; ///< plus one; 0: none
    };
    std::vector<std::uint32_t> _blockOf;
    std::vector<std::uint32_t> _named;
    std::vector<Block> _blocks;
    std::vector<WeightedVoxel> _voxels;
};

} // namespace isofront::voxels

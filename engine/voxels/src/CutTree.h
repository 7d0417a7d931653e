#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/VoxelRay.h>

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// Finds which chunk of a cut stands for a place: an octree with the chunks as leaves.
///
/// Thread: any number may read.
class CutTree {
public:
    /// @return `usage` if two chunks overlap, or one lies outside the model
    static core::Result<CutTree> create(const ChunkCut& cut, std::uint32_t levels);

    static constexpr std::uint32_t kNone = 0xffffffffU;
    struct Found {
        std::uint32_t chunk; ///< its index in the cut; kNone where there is none
        int bits;            ///< of the edge of the chunk, or of the empty cube [cells of level 0]
    };
    /// @param cell  of level 0, within the model
    [[nodiscard]] Found at(const std::array<std::int32_t, 3>& cell) const
    {
        std::uint32_t node = 0;
        for (int bits = _bits;; --bits) {
            const Node& here = _nodes[node];
            if (here.chunk != kNone)
                return {here.chunk, bits};
            const int next = bits - 1;
            const auto bit = [&](std::size_t axis) {
                return static_cast<std::uint32_t>(cell[axis]) >> next & 1U;
            };
            node = here.child[bit(0) | bit(1) << 1U | bit(2) << 2U];
            if (node == 0)
                return {kNone, next};
        }
    }

private:
    struct Node {
        std::array<std::uint32_t, 8> child{}; ///< 0: none
        std::uint32_t chunk = kNone;
    };
    explicit CutTree(int bits) : _nodes(1), _bits(bits) {}

    std::vector<Node> _nodes;
    int _bits; ///< of the edge of the root [cells of level 0]
};

} // namespace isofront::voxels

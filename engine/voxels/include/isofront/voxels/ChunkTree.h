#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkDirectory.h>
#include <isofront/voxels/Voxelization.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::voxels {

/// A chunk's place in its ChunkTree; parents have smaller ones than their children.
using ChunkIndex = std::uint32_t;
inline constexpr ChunkIndex kNoChunk = 0xffffffff;

/// All chunks of a model as an octree, without their voxels: what is there, where, how much.
///
/// Immutable. Thread: any number at once.
class ChunkTree {
public:
    struct Node {
        ChunkEntry entry;
        /// Contains the voxels of the chunk and of all below it [world].
        core::Box box;
        ChunkIndex parent = kNoChunk;
        /// In the order of ChunkKey::child; kNoChunk where there is nothing.
        std::array<ChunkIndex, 8> children{
            kNoChunk, kNoChunk, kNoChunk, kNoChunk, kNoChunk, kNoChunk, kNoChunk, kNoChunk};
        bool isLeaf = true;
    };

    /// Of a store's directory, in any order. `badData`, with the chunk's name, for one that lies
    /// outside the lattice, comes twice, or has no parent, and for a lattice that has no such
    /// levels. An empty directory makes an empty tree.
    static core::Result<ChunkTree>
    create(const VoxelLattice& lattice, std::span<const ChunkEntry> directory);

    [[nodiscard]] const VoxelLattice& lattice() const { return _lattice; }
    /// How many chunks. The first is the root, which holds the whole model at its coarsest.
    [[nodiscard]] std::size_t size() const { return _nodes.size(); }
    [[nodiscard]] const Node& operator[](ChunkIndex index) const { return _nodes[index]; }
    /// kNoChunk if there is none of that name. Cost: logarithmic.
    [[nodiscard]] ChunkIndex find(const ChunkKey& key) const;
    /// Of a chunk's voxels, whether it is in the tree or not [world].
    [[nodiscard]] core::Box boxOf(const ChunkEntry& entry) const;
    /// The edge of a voxel of a level [world].
    [[nodiscard]] double voxelEdge(std::uint32_t level) const;

private:
    VoxelLattice _lattice;
    std::vector<Node> _nodes; ///< coarsest level first, then by z, y and x
};

} // namespace isofront::voxels

#include "isofront/voxels/ChunkTree.h"

#include "ChunkCodec.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace isofront::voxels {

namespace {

/// Orders keys by level, coarsest first, then by z, y and x.
bool comesFirst(const ChunkKey& a, const ChunkKey& b)
{
    return std::tie(b.level, a.z, a.y, a.x) < std::tie(a.level, b.z, b.y, b.x);
}

} // namespace

core::Result<ChunkTree>
ChunkTree::create(const VoxelLattice& lattice, std::span<const ChunkEntry> directory)
{
    const auto fail = [](const ChunkKey& key, const char* why) -> core::Result<ChunkTree> {
        return core::failure(
            core::ErrorCode::badData, nameOf(key) + ' ' + why + "; voxelise the model again");
    };
    constexpr std::uint32_t kMostLevels = 9;
    constexpr std::uint32_t kMostVoxels = kChunkEdge * kChunkEdge * kChunkEdge;
    if (lattice.levels < 1 || lattice.levels > kMostLevels || !(lattice.edge > 0) ||
        !std::isfinite(lattice.edge + lattice.origin.x + lattice.origin.y + lattice.origin.z))
        return core::failure(
            core::ErrorCode::badData, "the model's lattice makes no sense; voxelise it again");
    ChunkTree tree;
    tree._lattice = lattice;
    tree._nodes.reserve(directory.size());
    for (const ChunkEntry& entry : directory) {
        const ChunkKey& key = entry.key;
        if (key.level >= lattice.levels ||
            std::max({key.x, key.y, key.z}) >> (lattice.levels - 1 - key.level) != 0)
            return fail(key, "lies outside the model");
        if (entry.voxels == 0 || entry.voxels > kMostVoxels)
            return fail(key, "has a number of voxels that makes no sense");
        if (entry.parents > entry.voxels || entry.parents < (entry.voxels + 7) / 8)
            return fail(key, "has a number of parents that makes no sense");
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (entry.low[axis] > entry.high[axis])
                return fail(key, "has no extent");
        Node node;
        node.entry = entry;
        node.box = tree.boxOf(entry);
        tree._nodes.push_back(node);
    }
    std::ranges::sort(tree._nodes, [](const Node& a, const Node& b) {
        return comesFirst(a.entry.key, b.entry.key);
    });
    for (std::size_t i = 0; i < tree._nodes.size(); ++i) {
        Node& node = tree._nodes[i];
        const ChunkKey& key = node.entry.key;
        if (i > 0 && tree._nodes[i - 1].entry.key == key)
            return fail(key, "comes twice");
        if (key.level + 1 == lattice.levels)
            continue;
        node.parent = tree.find(key.parent());
        if (node.parent == kNoChunk)
            return fail(key, "has no parent");
        Node& parent = tree._nodes[node.parent];
        parent.children[(key.x & 1U) | (key.y & 1U) << 1U | (key.z & 1U) << 2U] =
            static_cast<ChunkIndex>(i);
        parent.isLeaf = false;
    }
    // a parent contains its children; hold on to it even if the directory says otherwise
    for (std::size_t i = tree._nodes.size(); i-- > 1;) {
        const Node& node = tree._nodes[i];
        core::Box& around = tree._nodes[node.parent].box;
        around.include(node.box.low);
        around.include(node.box.high);
    }
    return tree;
}

core::Box ChunkTree::boxOf(const ChunkEntry& entry) const
{
    const std::array<std::uint32_t, 3> place{entry.key.x, entry.key.y, entry.key.z};
    const double edge = voxelEdge(entry.key.level);
    core::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = static_cast<double>(place[axis]) * kChunkEdge;
        box.low[axis] = _lattice.origin[axis] + edge * (first + entry.low[axis]);
        box.high[axis] = _lattice.origin[axis] + edge * (first + entry.high[axis] + 1);
    }
    return box;
}

ChunkIndex ChunkTree::find(const ChunkKey& key) const
{
    const auto found = std::ranges::lower_bound(
        _nodes, key, comesFirst, [](const Node& node) { return node.entry.key; });
    return found == _nodes.end() || found->entry.key != key
               ? kNoChunk
               : static_cast<ChunkIndex>(found - _nodes.begin());
}

double ChunkTree::voxelEdge(std::uint32_t level) const
{
    return std::ldexp(_lattice.edge, static_cast<int>(level));
}

} // namespace isofront::voxels

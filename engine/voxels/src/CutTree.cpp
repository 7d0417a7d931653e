#include "CutTree.h"

#include "ChunkCodec.h"

#include <algorithm>

namespace isofront::voxels {

core::Result<CutTree> CutTree::create(const ChunkCut& cut, std::uint32_t levels)
{
    constexpr int kChunkBits = 8;
    static_assert(kChunkEdge == 1U << kChunkBits);
    CutTree tree(kChunkBits - 1 + static_cast<int>(levels));
    const auto overlap = [](const ChunkKey& key) {
        return core::failure(
            core::ErrorCode::usage,
            nameOf(key) + " overlaps with another chunk of the cut: name each place once");
    };
    for (std::size_t i = 0; i < cut.size(); ++i) {
        const ChunkKey& key = cut[i];
        const std::uint32_t depth = levels - 1 - key.level; // below the root
        if (key.level >= levels || std::max({key.x, key.y, key.z}) >> depth != 0)
            return core::failure(
                core::ErrorCode::usage,
                nameOf(key) + " lies outside the model, which has " + std::to_string(levels) +
                    " levels");
        std::uint32_t node = 0;
        for (std::uint32_t level = depth; level-- > 0;) {
            if (tree._nodes[node].chunk != kNone)
                return overlap(key);
            const std::uint32_t which =
                (key.x >> level & 1U) | (key.y >> level & 1U) << 1U | (key.z >> level & 1U) << 2U;
            std::uint32_t next = tree._nodes[node].child[which];
            if (next == 0) {
                next = static_cast<std::uint32_t>(tree._nodes.size());
                tree._nodes[node].child[which] = next;
                tree._nodes.emplace_back();
            }
            node = next;
        }
        Node& leaf = tree._nodes[node];
        if (leaf.chunk != kNone || std::ranges::any_of(leaf.child, [](auto c) { return c != 0; }))
            return overlap(key);
        leaf.chunk = static_cast<std::uint32_t>(i);
    }
    return tree;
}

} // namespace isofront::voxels

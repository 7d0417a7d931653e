#include "ShadowCasters.h"

namespace isofront::voxels {

void castersInto(
    const ChunkTree& tree,
    const std::function<bool(ChunkIndex)>& isThere,
    const ChunkView& sun,
    double texel,
    std::vector<ChunkDraw>& casters)
{
    if (tree.size() == 0 || !isThere(0))
        return;
    std::vector<ChunkIndex> open{0};
    while (!open.empty()) {
        const ChunkIndex index = open.back();
        open.pop_back();
        const ChunkTree::Node& node = tree[index];
        if (!sun.mayShow(node.box))
            continue;
        unsigned own = 0xff;
        if (!node.isLeaf && tree.voxelEdge(node.entry.key.level) > texel) {
            own = 0;
            for (unsigned i = 0; i < node.children.size(); ++i) {
                if (node.children[i] == kNoChunk)
                    continue;
                if (isThere(node.children[i]))
                    open.push_back(node.children[i]);
                else
                    own |= 1U << i;
            }
        }
        if (own == 0)
            continue;
        ChunkDraw draw;
        draw.key = node.entry.key;
        draw.index = index;
        draw.voxels = node.entry.voxels;
        draw.octants = static_cast<std::uint8_t>(own);
        casters.push_back(draw);
    }
}

} // namespace isofront::voxels

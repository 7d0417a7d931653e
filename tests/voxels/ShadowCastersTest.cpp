#include "ShadowCasters.h"

#include "support/Random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace isofront::voxels {
namespace {

/// A tree of five levels with holes.
ChunkTree anyTree(std::mt19937_64& random)
{
    const VoxelLattice lattice{.edge = 0.5, .resolution = 4096, .levels = 5};
    std::set<ChunkKey> keys;
    for (int i = 0; i < 60; ++i) {
        const auto part = [&] { return static_cast<std::uint32_t>(tests::below(random, 16)); };
        ChunkKey key{0, part(), part(), part()};
        for (; key.level < lattice.levels; key = key.parent())
            keys.insert(key);
    }
    std::vector<ChunkEntry> directory;
    for (const ChunkKey& key : keys) {
        ChunkEntry entry;
        entry.key = key;
        entry.voxels = 1;
        entry.parents = 1;
        entry.low = {0, 0, 0};
        entry.high = {255, 255, 255};
        directory.push_back(entry);
    }
    return *ChunkTree::create(lattice, directory);
}

TEST(ShadowCasters, coverEveryPlaceOnceAndNoFinerThanATexel)
{
    auto random = tests::random(77);
    for (int trial = 0; trial < 30; ++trial) {
        const ChunkTree tree = anyTree(random);
        std::vector<bool> there(tree.size());
        for (ChunkIndex i = 0; i < tree.size(); ++i)
            there[i] = tree[i].parent == kNoChunk ||
                       (there[tree[i].parent] && tests::below(random, 4) > 0);
        const double texel = std::ldexp(0.7, static_cast<int>(tests::below(random, 6)) - 1);
        ChunkView sun;
        const bool everywhere = trial % 2 == 0;
        if (!everywhere)
            sun.planes[0] = {{1, 0.3, -0.2}, -500};
        std::vector<ChunkDraw> casters;
        castersInto(
            tree, [&](ChunkIndex i) { return there[i]; }, sun, texel, casters);
        ASSERT_FALSE(everywhere && casters.empty());
        std::vector<std::uint8_t> octants(tree.size());
        for (const ChunkDraw& draw : casters) {
            ASSERT_TRUE(there[draw.index]);
            ASSERT_EQ(draw.key, tree[draw.index].entry.key);
            ASSERT_EQ(octants[draw.index], 0) << "twice";
            octants[draw.index] = draw.octants;
            const ChunkIndex parent = tree[draw.index].parent;
            ASSERT_TRUE(parent == kNoChunk || tree.voxelEdge(tree[parent].entry.key.level) > texel)
                << "too fine";
        }
        for (ChunkIndex leaf = 0; leaf < tree.size(); ++leaf) {
            if (!tree[leaf].isLeaf)
                continue;
            int times = octants[leaf] == 0xff ? 1 : 0;
            ASSERT_TRUE(octants[leaf] == 0 || octants[leaf] == 0xff);
            for (ChunkIndex child = leaf; tree[child].parent != kNoChunk;
                 child = tree[child].parent) {
                const ChunkIndex parent = tree[child].parent;
                for (unsigned i = 0; i < 8; ++i)
                    if (tree[parent].children[i] == child)
                        times += octants[parent] >> i & 1;
            }
            EXPECT_LE(times, 1) << trial << " " << leaf;
            EXPECT_TRUE(times == 1 || !sun.mayShow(tree[leaf].box)) << trial << " " << leaf;
        }
    }
}

} // namespace
} // namespace isofront::voxels

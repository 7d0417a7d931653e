#include "suites/InstancedStore.h"

#include "suites/Models.h"

#include <isofront/voxels/ChunkDirectory.h>
#include <isofront/voxels/ChunkTree.h>

#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace isofront::bench {
namespace {

using voxels::Chunk;
using voxels::ChunkKey;

Context quietContext()
{
    Context context;
    context.jobs = core::makeJobs(core::JobsBackend::inlined);
    context.say = [](const std::string&) {};
    return context;
}

std::shared_ptr<const voxels::ChunkStore> block(std::uint32_t resolution)
{
    auto store = inMemory(quietContext(), "block", city(3, 0.4), resolution);
    EXPECT_TRUE(store) << store.error().message;
    return *store;
}

TEST(InstancedStore, isAModelOfWhichEachPlaceHoldsTheSame)
{
    const auto one = block(512);
    const auto made = InstancedStore::create(one, 2);
    ASSERT_TRUE(made) << made.error().message;
    const InstancedStore& many = **made;
    EXPECT_EQ(many.model().lattice.resolution, 2048U);
    EXPECT_EQ(many.model().lattice.levels, voxels::levelsFor(2048));
    EXPECT_EQ(many.model().lattice.edge, one->model().lattice.edge);

    const auto directory = many.directory();
    ASSERT_TRUE(directory);
    const auto tree = voxels::ChunkTree::create(many.model().lattice, *directory);
    ASSERT_TRUE(tree) << tree.error().message;
    EXPECT_EQ(tree->size(), many.keys().size());
    std::uint64_t all = 0;
    std::uint64_t finest = 0;
    for (const voxels::ChunkEntry& entry : *directory) {
        const auto chunk = many.get(entry.key);
        ASSERT_TRUE(chunk && *chunk);
        EXPECT_EQ((*chunk)->key, entry.key);
        EXPECT_EQ(voxels::entryOf(**chunk), entry);
        all += entry.voxels;
        finest += entry.key.level == 0 ? entry.voxels : 0;
        if (entry.key.level > 1)
            continue;
        const std::uint32_t own = 2U >> entry.key.level; // chunks along a block
        auto there = one->get({entry.key.level, entry.key.x % own, entry.key.y % own, entry.key.z});
        ASSERT_TRUE(there && *there);
        (*there)->key = entry.key;
        EXPECT_EQ(**chunk, **there);
    }
    EXPECT_EQ(all, many.model().allVoxels);
    EXPECT_EQ(finest, many.model().voxels);
    EXPECT_EQ(finest, 16 * one->model().voxels);

    const auto outside = many.get({0, 8, 0, 0});
    ASSERT_TRUE(outside);
    EXPECT_FALSE(*outside);
}

TEST(InstancedStore, hasCoarserLevelsThatContainTheFinerOnesAndNothingElse)
{
    const auto made = InstancedStore::create(block(256), 3);
    ASSERT_TRUE(made);
    const InstancedStore& many = **made;
    for (std::uint32_t level = 1; level < many.model().lattice.levels; ++level) {
        const Chunk parent = **many.get({level, 0, 0, 0});
        std::set<std::uint32_t> expected;
        for (std::uint32_t which = 0; which < 8; ++which) {
            const auto child = many.get(parent.key.child(which));
            ASSERT_TRUE(child);
            if (!*child)
                continue;
            for (const voxels::Voxel& voxel : (*child)->voxels)
                expected.insert(voxels::packPlace(
                    voxel.x() / 2 + 128 * (which & 1U),
                    voxel.y() / 2 + 128 * (which >> 1U & 1U),
                    voxel.z() / 2 + 128 * (which >> 2U),
                    0));
        }
        ASSERT_EQ(parent.voxels.size(), expected.size()) << "level " << level;
        auto next = expected.begin();
        for (const voxels::Voxel& voxel : parent.voxels) {
            EXPECT_EQ(voxel.order(), *next++);
            EXPECT_NE(voxel.faces(), 0);
        }
    }
}

TEST(InstancedStore, refusesModelsThatDoNotFillTheirChunks)
{
    const auto made = InstancedStore::create(block(200), 1);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, core::ErrorCode::badData);
}

} // namespace
} // namespace isofront::bench

#include "ChunkFlight.h"
#include "StandIn.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace isofront::voxels {
namespace {

std::set<ChunkKey> someOf(std::mt19937_64& random, const std::vector<ChunkKey>& keys, int count)
{
    std::set<ChunkKey> some;
    for (int i = 0; i < count; ++i)
        some.insert(keys[tests::below(random, keys.size())]);
    some.erase({3, 0, 0, 0});
    return some;
}

TEST(DamagedChunks, areReplacedByWhatTheirParentsHaveThere)
{
    auto random = tests::random(18);
    const auto whole = shared(tests::city(4, 4, false));
    const std::vector<ChunkKey> keys = whole->keys();
    std::size_t shown = 0;
    for (const StreamingPolicy policy : {StreamingPolicy::closed, StreamingPolicy::partial}) {
        for (int trial = 0; trial < tests::trials(6); ++trial) {
            const std::set<ChunkKey> damaged = someOf(random, keys, 6);
            StreamingSettings settings = settingsFor(0.02);
            settings.policy = policy;
            Flight sound(whole, settings);
            Flight flight(std::make_shared<DamagedStore>(whole, damaged), settings);
            flight.feedback = sound.feedback = Feedback::none;
            const ChunkTree& tree = flight.streamer->tree();
            std::set<ChunkKey> named;
            bool hasBegun = false;
            for (int i = 0; i < 6; ++i) {
                const BlockCamera camera = anyCamera(random, 128);
                for (int j = 0; j < 60; ++j) {
                    const ChunkFrame& frame = flight.step(camera);
                    hasBegun |= !frame.draws.empty();
                    if (hasBegun && policy == StreamingPolicy::closed)
                        expectClosed(frame, tree, camera.view());
                    EXPECT_LE(frame.residentBytes, settings.cacheBytes);
                    for (const core::Error& error : frame.damaged)
                        EXPECT_TRUE(named.insert(keyIn(error)).second) << "each is named once";
                    for (const ChunkDraw& draw : frame.draws)
                        EXPECT_FALSE(damaged.contains(draw.key));
                }
                // in the end all is as it would be, but for those that are damaged themselves
                flight.settle(camera);
                sound.settle(camera);
                const ChunkFrame& frame = flight.step(camera);
                expectClosed(frame, tree, camera.view());
                std::map<ChunkIndex, ChunkDraw> drawn;
                for (const ChunkDraw& draw : frame.draws)
                    drawn[draw.index] = draw;
                for (const ChunkDraw& draw : sound.step(camera).draws) {
                    ASSERT_TRUE(drawn.contains(draw.index));
                    const ChunkDraw& own = drawn[draw.index];
                    ChunkKey key = draw.key;
                    while (damaged.contains(key))
                        key = key.parent();
                    EXPECT_EQ(own.key, key);
                    EXPECT_EQ(own.standIn != nullptr, key != draw.key);
                    EXPECT_DOUBLE_EQ(
                        own.voxelPixels,
                        tree.voxelEdge(key.level) * camera.view().pixelsPerUnit / own.distance);
                    if (own.standIn == nullptr)
                        continue;
                    ++shown;
                    EXPECT_EQ(own.voxels, own.standIn->voxels);
                    EXPECT_TRUE(named.contains(draw.key));
                }
                // a stand-in that sticks out may be in view where the chunk isn't
                for (const auto& [index, draw] : drawn) {
                    EXPECT_TRUE(draw.standIn != nullptr || camera.view().mayShow(tree[index].box));
                }
            }
            for (const ChunkKey& key : named)
                EXPECT_TRUE(damaged.contains(key));
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(shown, 20U);
    }
}

TEST(DamagedChunks, hideNothingThatCanBeSeen)
{
    auto random = tests::random(19);
    const auto whole = shared(tests::city(4, 4, true));
    const std::vector<ChunkKey> keys = whole->keys();
    std::uint64_t hidden = 0;
    for (int trial = 0; trial < tests::trials(6); ++trial) {
        const auto store =
            std::make_shared<DamagedStore>(whole, someOf(random, keys, 1 + trial * 6));
        StreamingSettings settings = settingsFor(0.04);
        Flight flight(store, settings);
        settings.occlusion = false;
        Flight truth(store, settings);
        for (int i = 0; i < 2; ++i) {
            const BlockCamera camera = anyCamera(random, 128);
            flight.latency = 1 + tests::below(random, 3);
            flight.settle(camera);
            truth.settle(camera);
            EXPECT_EQ(flight.depth, truth.depth);
            EXPECT_EQ(flight.chunk, truth.chunk);
            hidden += flight.step(camera).draws.size() < truth.step(camera).draws.size() ? 1U : 0U;
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(hidden, 0U);
    }
}

TEST(DamagedChunks, areTriedAgainWhenTheyAreNeededAgain)
{
    const auto whole = shared(tests::city(4, 4, false));
    const ChunkKey bad{1, 2, 1, 0};
    const auto store = std::make_shared<DamagedStore>(whole, std::set<ChunkKey>{bad});
    Flight flight(store, settingsFor(0.15, 120'000));
    flight.feedback = Feedback::none;
    const ChunkIndex index = flight.streamer->tree().find(bad);
    BlockCamera camera;
    camera.eye = {48, 48, 60};
    camera.forward = {0.01, 0.02, -1};
    const auto drawn = [&] {
        flight.settle(camera);
        const std::vector<ChunkDraw>& draws = flight.step(camera).draws;
        const auto found = std::ranges::find(draws, index, &ChunkDraw::index);
        return found == draws.end() ? std::optional<ChunkKey>() : found->key;
    };
    EXPECT_EQ(drawn(), bad.parent());
    store->repair();
    EXPECT_EQ(drawn(), bad.parent()) << "as long as it stays";
    auto random = tests::random(34);
    bool isGone = false;
    for (int i = 0; i < 2000 && !isGone; ++i)
        isGone = std::ranges::count(flight.step(anyCamera(random, 128)).evictions, index) > 0;
    ASSERT_TRUE(isGone);
    EXPECT_EQ(drawn(), bad);
}

TEST(DamagedChunks, showsWhatItCanOfAModelWithoutARoot)
{
    const auto whole = shared(tests::city(3, 2, false));
    BlockCamera camera;
    camera.eye = {32, -30, 30};
    camera.forward = {0, 1, -0.3};
    Flight flight(
        std::make_shared<DamagedStore>(
            whole, std::set<ChunkKey>{{2, 0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0, 0}}),
        settingsFor(0.02));
    flight.feedback = Feedback::none;
    const std::vector<ChunkKey> keys = whole->keys();
    std::size_t found = 0;
    for (int i = 0; i < 100; ++i)
        found += flight.step(camera).damaged.size();
    EXPECT_EQ(found, 3U);
    const ChunkFrame& frame = flight.step(camera);
    EXPECT_TRUE(frame.isComplete);
    const ChunkTree& tree = flight.streamer->tree();
    std::vector<int> drawn(tree.size(), 0);
    for (const ChunkDraw& draw : frame.draws)
        ++drawn[draw.index];
    for (ChunkIndex i = 0; i < tree.size(); ++i) {
        if (!tree[i].isLeaf || !camera.view().mayShow(tree[i].box))
            continue;
        int covers = 0;
        for (ChunkIndex at = i; at != kNoChunk; at = tree[at].parent)
            covers += drawn[at];
        EXPECT_EQ(covers, tree[i].entry.key == (ChunkKey{0, 0, 0, 0}) ? 0 : 1);
    }
}

TEST(DamagedChunks, standInsTileTheChunkAbove)
{
    // the stand-ins of all eight children have all voxels of a chunk once, with its colours, and
    // no neighbour can be looked into
    auto random = tests::random(33);
    Chunk above;
    above.key = {4, 3, 5, 6};
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> places;
    for (int i = 0; i < 5000; ++i) {
        const auto any = [&] {
            const std::uint32_t edge = tests::below(random, 4) == 0 ? 127 : 0;
            return edge +
                   static_cast<std::uint32_t>(tests::below(random, edge > 0 ? 2 : kChunkEdge));
        };
        places.insert({any(), any(), any()});
    }
    for (const auto& [z, y, x] : places) {
        above.voxels.push_back(
            {packPlace(x, y, z, static_cast<std::uint8_t>(tests::below(random, 64))),
             static_cast<std::uint32_t>(above.voxels.size())});
        above.colours.push_back(static_cast<std::uint32_t>(7 * above.voxels.size()));
    }
    for (const std::uint32_t down : {1U, 2U}) {
        std::size_t found = 0;
        const std::uint32_t edge = kChunkEdge >> down;
        const std::uint32_t parts = 1U << down;
        for (std::uint32_t part = 0; part < parts * parts * parts; ++part) {
            const std::array<std::uint32_t, 3> at{
                part % parts, part / parts % parts, part / parts / parts};
            const ChunkKey key{
                4 - down,
                above.key.x * parts + at[0],
                above.key.y * parts + at[1],
                above.key.z * parts + at[2]};
            const Chunk chunk = standInFor(key, above);
            EXPECT_EQ(chunk.key, above.key);
            found += chunk.voxels.size();
            for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
                const Voxel& voxel = chunk.voxels[i];
                EXPECT_TRUE(i == 0 || chunk.voxels[i - 1].order() < voxel.order());
                ASSERT_LT(voxel.normal, above.voxels.size());
                const Voxel& source = above.voxels[voxel.normal];
                EXPECT_EQ(voxel.order(), source.order());
                EXPECT_EQ(chunk.colours[i], above.colours[voxel.normal]);
                const std::array<std::uint32_t, 3> place{voxel.x(), voxel.y(), voxel.z()};
                for (std::size_t face = 0; face < kFaces; ++face) {
                    const std::size_t axis = face / 2;
                    const std::uint32_t local = place[axis] - at[axis] * edge;
                    const std::uint8_t bit = faceBit(static_cast<Face>(face));
                    EXPECT_LT(local, edge);
                    const bool isCap = local == (face % 2 == 0 ? 0 : edge - 1);
                    EXPECT_EQ((voxel.faces() & bit) != 0, isCap || (source.faces() & bit) != 0);
                }
            }
        }
        EXPECT_EQ(found, above.voxels.size());
    }
}

} // namespace
} // namespace isofront::voxels

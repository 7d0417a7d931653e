#include "BlockScene.h"
#include "SimulatedDevice.h"
#include "support/Random.h"

#include <isofront/voxels/ChunkStreamer.h>

#include <gtest/gtest.h>

#include <functional>
#include <set>

namespace isofront::voxels {
namespace {

using tests::BlockCamera;
using tests::BlockPicture;

/// A store that can't read some of its chunks.
class DamagedStore : public ChunkStore {
public:
    DamagedStore(std::shared_ptr<const ChunkStore> store, std::set<ChunkKey> damaged)
        : _store(std::move(store)), _damaged(std::move(damaged))
    {
    }
    std::optional<core::Error> put(Chunk) override { return std::nullopt; }
    std::optional<core::Error> finish(const StoredModel&) override { return std::nullopt; }
    [[nodiscard]] const StoredModel& model() const override { return _store->model(); }
    [[nodiscard]] std::vector<ChunkKey> keys() const override { return _store->keys(); }
    [[nodiscard]] core::Result<std::vector<ChunkEntry>> directory() const override
    {
        return _store->directory();
    }
    [[nodiscard]] core::Result<std::optional<Chunk>> get(const ChunkKey& key) const override
    {
        if (_damaged.contains(key))
            return core::failure(core::ErrorCode::badData, "damaged");
        return _store->get(key);
    }

private:
    std::shared_ptr<const ChunkStore> _store;
    std::set<ChunkKey> _damaged;
};

/// What is known of visibility after a frame.
enum class Feedback { none, exact, random };

/// Flies through a scene with a simulated device that is some frames behind.
class Flight {
public:
    Flight(
        std::shared_ptr<const ChunkStore> chunks,
        const StreamingSettings& settings,
        core::JobsBackend backend = core::JobsBackend::inlined)
        : store(std::move(chunks)), device(store, settings.cacheBytes)
    {
        auto made = ChunkStreamer::create(store, settings, core::makeJobs(backend, 2));
        if (!made) {
            ADD_FAILURE() << made.error().message;
            return;
        }
        streamer = std::move(*made);
    }

    const ChunkFrame& step(const BlockCamera& camera)
    {
        ++frame;
        std::vector<Visibility> seen;
        for (const auto& [number, visible] : _visible)
            if (number + latency <= frame)
                seen.push_back({number, visible});
        const std::uint64_t completed = frame > latency ? frame - latency : 0;
        device.complete(completed, *streamer);
        const ChunkFrame& work = streamer->update(camera.view(), frame, completed, seen);
        std::erase_if(_visible, [&](const auto& v) { return v.first + latency <= frame; });
        device.submit(frame, work, *streamer);
        if (feedback == Feedback::none)
            return work;
        std::vector<std::uint32_t> visible;
        if (feedback == Feedback::random) {
            for (std::size_t i = 0; i < work.draws.size(); ++i)
                visible.push_back(tests::below(random, 3) == 0 ? 1 : 0);
        } else {
            BlockPicture picture(streamer->tree(), *store, camera);
            for (const ChunkDraw& draw : work.draws)
                visible.push_back(picture.draw(draw.index, draw.occlusionOnly) ? 1 : 0);
        }
        if (tests::below(random, 8) != 0 || !losesFeedback)
            _visible.emplace_back(frame, std::move(visible));
        return work;
    }

    /// Until everything is there and the draws stay the same for some frames.
    /// @return how many frames it took
    int settle(const BlockCamera& camera, int most = 2000)
    {
        int same = 0;
        std::vector<ChunkDraw> before;
        for (int i = 1; i <= most; ++i) {
            const ChunkFrame& work = step(camera);
            same = work.isComplete && isSame(before, work.draws) ? same + 1 : 0;
            before = work.draws;
            if (same == 12)
                return i - same;
            if (!work.isComplete)
                streamer->waitForChunks();
        }
        ADD_FAILURE() << "didn't settle";
        return most;
    }

    static bool isSame(const std::vector<ChunkDraw>& a, const std::vector<ChunkDraw>& b)
    {
        return std::ranges::equal(a, b, [](const ChunkDraw& p, const ChunkDraw& q) {
            return p.index == q.index && p.occlusionOnly == q.occlusionOnly &&
                   p.offset == q.offset && p.weight == q.weight;
        });
    }

    std::shared_ptr<const ChunkStore> store;
    std::unique_ptr<ChunkStreamer> streamer;
    tests::SimulatedDevice device;
    std::uint64_t frame = 0;
    std::uint64_t latency = 2;
    Feedback feedback = Feedback::exact;
    bool losesFeedback = false;
    std::mt19937_64 random = tests::random(1);

private:
    std::vector<std::pair<std::uint64_t, std::vector<std::uint32_t>>> _visible;
};

std::shared_ptr<const ChunkStore> shared(const tests::BlockScene& scene)
{
    return scene.store();
}

StreamingSettings settingsFor(double voxelPixels, std::uint64_t cacheBytes = 1U << 22U)
{
    StreamingSettings settings;
    settings.voxelPixels = voxelPixels;
    settings.sourcePixels = 10 * voxelPixels;
    settings.cacheBytes = cacheBytes;
    settings.uploadBytes = 20'000;
    settings.moveBytes = 40'000;
    settings.hostBytes = 100'000;
    return settings;
}

/// A camera that looks at a scene of `size` blocks along an edge, from somewhere.
BlockCamera anyCamera(std::mt19937_64& random, double size)
{
    BlockCamera camera;
    camera.eye = {
        tests::uniform(random, -0.5, 1.5) * size,
        tests::uniform(random, -0.5, 1.5) * size,
        tests::uniform(random, 0.01, 0.7) * size};
    const glm::dvec3 target = size * glm::dvec3(
                                         tests::uniform(random, 0.2, 0.8),
                                         tests::uniform(random, 0.2, 0.8),
                                         tests::uniform(random, 0.0, 0.3));
    camera.forward = target - camera.eye;
    return camera;
}

/// Each leaf in view is drawn, or stood for by exactly one chunk above it.
void expectClosed(const ChunkFrame& frame, const ChunkTree& tree, const ChunkView& view)
{
    std::vector<int> drawn(tree.size(), 0);
    for (const ChunkDraw& draw : frame.draws)
        ++drawn[draw.index];
    for (ChunkIndex i = 0; i < tree.size(); ++i) {
        if (!tree[i].isLeaf || !view.mayShow(tree[i].box))
            continue;
        int covers = 0;
        for (ChunkIndex at = i; at != kNoChunk; at = tree[at].parent)
            covers += drawn[at];
        ASSERT_EQ(covers, 1) << "leaf " << i;
    }
    for (const ChunkDraw& draw : frame.draws)
        ASSERT_TRUE(view.mayShow(tree[draw.index].box));
}

TEST(ChunkStreamer, drawsTheCoarsestChunksThatAreFineEnough)
{
    auto random = tests::random(11);
    Flight flight(shared(tests::city(4, 4, false)), settingsFor(0.5));
    flight.feedback = Feedback::none;
    const ChunkTree& tree = flight.streamer->tree();
    std::set<std::uint32_t> levels;
    for (int trial = 0; trial < tests::trials(20); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        const ChunkView view = camera.view();
        flight.settle(camera);
        const ChunkFrame& frame = flight.step(camera);
        EXPECT_TRUE(frame.isComplete);
        EXPECT_EQ(frame.coarsening, 1);
        EXPECT_EQ(frame.missing, 0U);
        expectClosed(frame, tree, view);
        double before = 0;
        for (const ChunkDraw& draw : frame.draws) {
            const ChunkTree::Node& node = tree[draw.index];
            levels.insert(draw.key.level);
            EXPECT_EQ(draw.key, node.entry.key);
            EXPECT_GE(draw.distance, before) << "front to back";
            before = draw.distance;
            const auto pixels = [&](ChunkIndex index) {
                return tree.voxelEdge(tree[index].entry.key.level) * view.pixelsPerUnit /
                       view.distanceTo(tree[index].box);
            };
            EXPECT_EQ(draw.voxelPixels, pixels(draw.index));
            EXPECT_TRUE(node.isLeaf || draw.voxelPixels <= 0.5);
            EXPECT_TRUE(node.parent == kNoChunk || pixels(node.parent) > 0.5);
            EXPECT_EQ(draw.needsSource, node.isLeaf && draw.voxelPixels > 5);
            EXPECT_FALSE(draw.occlusionOnly);
        }
    }
    EXPECT_EQ(levels, (std::set<std::uint32_t>{0, 1, 2, 3}));
}

TEST(ChunkStreamer, isClosedInEveryFrame)
{
    auto random = tests::random(12);
    for (const std::uint64_t cache : {1U << 22U, 150'000U, 70'000U}) {
        Flight flight(shared(tests::city(4, 4, true)), settingsFor(0.4, cache));
        flight.feedback = Feedback::random;
        flight.losesFeedback = true;
        bool hasBegun = false;
        for (int leg = 0; leg < tests::trials(6); ++leg) {
            const BlockCamera from = anyCamera(random, 128);
            const BlockCamera to = anyCamera(random, 128);
            flight.latency = 1 + tests::below(random, 3);
            for (int i = 0; i < 40; ++i) {
                BlockCamera camera = from;
                camera.eye += (to.eye - from.eye) * (i / 40.0);
                camera.forward += (to.forward - from.forward) * (i / 40.0);
                const ChunkFrame& frame = flight.step(camera);
                hasBegun |= !frame.draws.empty();
                if (hasBegun)
                    expectClosed(frame, flight.streamer->tree(), camera.view());
                EXPECT_LE(frame.residentBytes, cache);
            }
        }
        EXPECT_TRUE(hasBegun);
    }
}

} // namespace
} // namespace isofront::voxels

#pragma once

#include "BlockScene.h"
#include "Models.h"
#include "SimulatedDevice.h"
#include "support/Random.h"

#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <sstream>
#include <string>

namespace isofront::voxels {

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
            return core::failure(
                core::ErrorCode::badData,
                std::to_string(key.level) + ' ' + std::to_string(key.x) + ' ' +
                    std::to_string(key.y) + ' ' + std::to_string(key.z));
        return _store->get(key);
    }
    /// While nothing is being read.
    void repair() { _damaged.clear(); }

private:
    std::shared_ptr<const ChunkStore> _store;
    std::set<ChunkKey> _damaged;
};

/// Of which chunk a DamagedStore's error speaks.
inline ChunkKey keyIn(const core::Error& error)
{
    std::istringstream text(error.message);
    ChunkKey key;
    text >> key.level >> key.x >> key.y >> key.z;
    return key;
}

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
        _model = std::make_unique<tests::BlockModel>(streamer->tree(), *store);
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
        const ChunkFrame& work = streamer->update(camera.view(), frame, completed, seen, turn);
        device.submit(frame, work, *streamer);
        for (const ChunkDraw& draw : work.draws)
            EXPECT_TRUE(!draw.occlusionOnly || _before.mayShow(streamer->tree()[draw.index].box))
                << "what comes into view is drawn, not tested";
        _before = camera.view();
        if (feedback == Feedback::none)
            return work;
        std::vector<std::uint32_t> visible;
        std::span<const ChunkDraw> second;
        expectHiddenBefore(work, seen);
        std::erase_if(_visible, [&](const auto& v) { return v.first + latency <= frame; });
        if (feedback == Feedback::random) {
            const auto any = [&] { return tests::below(random, 3) == 0 ? 1U : 0U; };
            for (std::size_t i = 0; i < work.draws.size(); ++i)
                visible.push_back(any());
            shown = work;
            if (hasSecondPass) {
                second = streamer->secondPass(visible);
                device.add(second);
                secondDraws += second.size();
                shown.draws.clear();
                for (std::size_t i = 0; i < work.draws.size(); ++i)
                    if (!work.draws[i].occlusionOnly || visible[i] == 0)
                        shown.draws.push_back(work.draws[i]);
                for (const ChunkDraw& draw : second) {
                    EXPECT_FALSE(draw.occlusionOnly);
                    shown.draws.push_back(draw);
                    visible.push_back(any());
                }
            }
        } else if (!hasSecondPass && camera.view() == _seenView && isSame(_seenDraws, work.draws)) {
            visible = _seen; // a picture takes a while
        } else {
            BlockPicture picture(*_model, camera);
            for (const ChunkDraw& draw : work.draws)
                visible.push_back(picture.draw(draw.index, draw.occlusionOnly) ? 1 : 0);
            if (hasSecondPass) {
                second = streamer->secondPass(visible);
                device.add(second);
                secondDraws += second.size();
                for (const ChunkDraw& draw : second) {
                    EXPECT_FALSE(draw.occlusionOnly);
                    visible.push_back(picture.draw(draw.index, false) ? 1 : 0);
                }
            }
            depth = picture.depth;
            chunk = picture.chunk;
            _seenView = camera.view();
            _seenDraws = work.draws;
            _seen = visible;
        }
        for (const ChunkDraw& draw : work.draws)
            _drawn[frame].push_back(draw.index);
        for (const ChunkDraw& draw : second)
            _drawn[frame].push_back(draw.index);
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
    ChunkFrame shown; ///< with random feedback: the frame with its second pass
    std::uint64_t frame = 0;
    std::uint64_t latency = 2;
    Feedback feedback = Feedback::exact;
    ChunkTurn turn;
    bool losesFeedback = false;
    bool hasSecondPass = false;
    std::size_t secondDraws = 0;
    std::size_t tested = 0;        ///< draws that only test
    std::vector<double> depth;     ///< of the last picture, with exact feedback
    std::vector<ChunkIndex> chunk; ///< the same
    std::mt19937_64 random = tests::random(1);

private:
    /// What is only tested from now on was hidden in the last frames that are known.
    void expectHiddenBefore(const ChunkFrame& work, const std::vector<Visibility>& seen)
    {
        for (const Visibility& known : seen) {
            std::set<ChunkIndex>& visible =
                _known.emplace_back(known.frame, std::set<ChunkIndex>()).second;
            for (std::size_t i = 0; i < known.visible.size(); ++i)
                for (ChunkIndex at = known.visible[i] == 0 ? kNoChunk : _drawn[known.frame][i];
                     at != kNoChunk;
                     at = streamer->tree()[at].parent)
                    visible.insert(at);
        }
        std::set<ChunkIndex> now;
        for (const ChunkDraw& draw : work.draws)
            if (draw.occlusionOnly)
                now.insert(draw.index);
        const std::size_t frames = streamer->settings().hiddenFrames;
        for (const ChunkIndex index : now) {
            ++tested;
            if (_tested.contains(index))
                continue;
            ASSERT_FALSE(_known.empty());
            for (const auto& [number, visible] : _known) {
                if (number + frames > _known.back().first) {
                    EXPECT_FALSE(visible.contains(index));
                }
            }
        }
        _tested = std::move(now);
    }

    std::map<std::uint64_t, std::vector<ChunkIndex>> _drawn; ///< by frame
    /// Chunks in whose place something was visible, by frame.
    std::vector<std::pair<std::uint64_t, std::set<ChunkIndex>>> _known;
    std::set<ChunkIndex> _tested; ///< in the last frame
    std::vector<std::pair<std::uint64_t, std::vector<std::uint32_t>>> _visible;
    ChunkView _before;
    std::unique_ptr<tests::BlockModel> _model;
    ChunkView _seenView; ///< of the last picture
    std::vector<ChunkDraw> _seenDraws;
    std::vector<std::uint32_t> _seen;
};

inline std::shared_ptr<const ChunkStore> shared(const tests::BlockScene& scene)
{
    return scene.store();
}

inline StreamingSettings settingsFor(double voxelPixels, std::uint64_t cacheBytes = 1U << 22U)
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
inline BlockCamera anyCamera(std::mt19937_64& random, double size)
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
inline void expectClosed(const ChunkFrame& frame, const ChunkTree& tree, const ChunkView& view)
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
        ASSERT_TRUE(draw.standIn != nullptr || view.mayShow(tree[draw.index].box));
}

} // namespace isofront::voxels

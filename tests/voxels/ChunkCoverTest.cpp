#include "ChunkFlight.h"

#include <glm/geometric.hpp>

namespace isofront::voxels {
namespace {

/// What is within so far of a place is covered.
struct Cover {
    glm::dvec3 centre{0.0};
    double radius = 0;

    [[nodiscard]] bool holds(const core::Box& box) const
    {
        const glm::dvec3 furthest =
            glm::max(glm::abs(box.low - centre), glm::abs(box.high - centre));
        return glm::length(furthest) < radius;
    }
    [[nodiscard]] ChunkTurn turn() const
    {
        ChunkTurn turn;
        turn.isCovered = [*this](const ChunkTree::Node& node) { return holds(node.box); };
        turn.isUnneeded = [inner = Cover{centre, 0.8 * radius}](const ChunkTree::Node& node) {
            return inner.holds(node.box);
        };
        return turn;
    }
};

TEST(ChunkCover, drawsAllButWhatIsCoveredAndLoadsNothingDeepInside)
{
    auto random = tests::random(81);
    std::size_t covered = 0;
    std::size_t missing = 0;
    std::size_t unneeded = 0;
    for (const std::uint64_t cache : {1U << 22U, 150'000U}) {
        Flight flight(shared(tests::city(4, 4, true)), settingsFor(0.04, cache));
        const ChunkTree& tree = flight.streamer->tree();
        flight.feedback = Feedback::random;
        bool hasBegun = false;
        for (int leg = 0; leg < tests::trials(6); ++leg) {
            BlockCamera camera = anyCamera(random, 128);
            const glm::dvec3 step = anyCamera(random, 4).forward;
            for (int i = 0; i < 40; ++i) {
                camera.eye += step;
                const Cover cover{camera.eye, tests::uniform(random, 10, 80)};
                flight.turn = cover.turn();
                const ChunkFrame& frame = flight.step(camera);
                for (const ChunkUpload& upload : frame.uploads)
                    EXPECT_FALSE(
                        Cover({camera.eye, 0.8 * cover.radius}).holds(tree[upload.index].box));
                for (ChunkIndex chunk = 0; chunk < tree.size(); ++chunk)
                    unneeded += flight.turn.isUnneeded(tree[chunk]) ? 1U : 0U;
                ChunkFrame all;
                for (const ChunkDraw& draw : frame.draws) {
                    EXPECT_TRUE(draw.occlusionOnly || !cover.holds(tree[draw.index].box));
                    all.draws.push_back(draw);
                }
                hasBegun |= !frame.draws.empty() || !frame.covered.empty();
                for (const CoveredChunk& chunk : frame.covered) {
                    EXPECT_TRUE(cover.holds(tree[chunk.index].box));
                    EXPECT_GE(chunk.level, tree[chunk.index].entry.key.level);
                    ++covered;
                    missing += chunk.level > tree[chunk.index].entry.key.level ? 1U : 0U;
                    all.draws.emplace_back().index = chunk.index;
                }
                if (hasBegun)
                    expectClosed(all, tree, camera.view());
            }
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(covered, 100U);
        EXPECT_GT(missing, 10U);
        EXPECT_GT(unneeded, 1000U);
    }
}

TEST(ChunkCover, letsNoOneWaitForWhatIsCovered)
{
    // With the finest detail wanted everywhere, a chunk's children would only be drawn together.
    StreamingSettings settings = settingsFor(1e-6);
    settings.occlusion = false;
    const auto store = shared(tests::city(4, 4, false));
    BlockCamera camera;
    camera.eye = {64, -60, 40};
    camera.forward = glm::dvec3(64, 64, 0) - camera.eye;
    Flight without(store, settings);
    without.feedback = Feedback::none;
    without.settle(camera);
    const auto leaves = without.step(camera).draws;

    Flight flight(store, settings);
    flight.feedback = Feedback::none;
    const Cover cover{{10, 10, 0}, 70};
    flight.turn = cover.turn();
    flight.settle(camera);
    const ChunkFrame& frame = flight.step(camera);
    std::set<ChunkIndex> expected;
    std::set<ChunkIndex> drawn;
    for (const ChunkDraw& draw : leaves)
        if (!cover.holds(flight.streamer->tree()[draw.index].box))
            expected.insert(draw.index);
    for (const ChunkDraw& draw : frame.draws)
        drawn.insert(draw.index);
    EXPECT_EQ(drawn, expected);
    EXPECT_LT(expected.size(), leaves.size());
    EXPECT_TRUE(std::ranges::any_of(frame.covered, [&](const CoveredChunk& chunk) {
        return chunk.level > flight.streamer->tree()[chunk.index].entry.key.level;
    })) << "some were never loaded";

    // and all of it comes when the cover goes
    flight.turn = {};
    flight.settle(camera);
    const auto after = flight.step(camera).draws;
    EXPECT_EQ(after.size(), leaves.size());
}

TEST(ChunkCover, neverTakesWhatIsCoveredForHidden)
{
    const auto store = shared(tests::city(4, 4, true));
    Flight flight(store, settingsFor(0.04));
    BlockCamera camera;
    camera.eye = {64, -60, 40};
    camera.forward = glm::dvec3(64, 64, 0) - camera.eye;
    const Cover cover{{64, 64, 0}, 1000};
    flight.turn = cover.turn();
    flight.turn.isUnneeded = {};
    for (int i = 0; i < 300; ++i) {
        const ChunkFrame& frame = flight.step(camera);
        EXPECT_TRUE(frame.draws.empty());
    }
    // all that a view needs is there
    EXPECT_EQ(flight.step(camera).missing, 0U);
    EXPECT_GT(flight.step(camera).covered.size(), 10U);
    flight.turn = {};
    const std::size_t atOnce = flight.step(camera).draws.size();
    EXPECT_GT(atOnce, 10U);
}

} // namespace
} // namespace isofront::voxels

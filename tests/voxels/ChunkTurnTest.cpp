#include "ChunkFlight.h"

namespace isofront::voxels {
namespace {

/// Makes turns for a flight: so many frames each.
class Turns {
public:
    explicit Turns(int length) : _length(length) {}

    ChunkTurn next()
    {
        const int at = _frame++ % _length;
        return {.begins = at == 0, .weight = static_cast<float>(at) / static_cast<float>(_length)};
    }

private:
    int _length;
    int _frame = 0;
};

/// What a frame's draws show in one of its pictures.
std::set<ChunkIndex> pictureOf(const ChunkFrame& frame, bool isPresent)
{
    std::set<ChunkIndex> chunks;
    for (const ChunkDraw& draw : frame.draws) {
        if (isPresent ? draw.inPresent : draw.inFormer)
            chunks.insert(draw.index);
    }
    return chunks;
}

/// Each of the two pictures for itself; and no chunk is drawn twice, or for none of them.
void expectBothClosed(const ChunkFrame& frame, const ChunkTree& tree, const ChunkView& view)
{
    std::size_t fading = 0;
    std::set<ChunkIndex> all;
    for (const ChunkDraw& draw : frame.draws) {
        EXPECT_TRUE(all.insert(draw.index).second);
        EXPECT_TRUE(draw.inFormer || draw.inPresent);
        fading += draw.inFormer != draw.inPresent ? 1U : 0U;
    }
    EXPECT_EQ(fading, frame.fading);
    for (const bool isPresent : {false, true}) {
        ChunkFrame picture;
        for (const ChunkDraw& draw : frame.draws) {
            if (isPresent ? draw.inPresent : draw.inFormer)
                picture.draws.push_back(draw);
        }
        expectClosed(picture, tree, view);
    }
}

BlockCamera between(const BlockCamera& from, const BlockCamera& to, double share)
{
    BlockCamera camera = from;
    camera.eye += (to.eye - from.eye) * share;
    camera.forward += (to.forward - from.forward) * share;
    return camera;
}

TEST(ChunkTurn, closesBothPicturesInEveryFrame)
{
    auto random = tests::random(71);
    std::size_t fading = 0;
    for (const std::uint64_t cache : {1U << 22U, 150'000U, 70'000U}) {
        Flight flight(shared(tests::city(4, 4, true)), settingsFor(0.04, cache));
        flight.feedback = Feedback::random;
        flight.hasSecondPass = cache != 150'000;
        flight.losesFeedback = true;
        Turns turns(5);
        bool hasBegun = false;
        for (int leg = 0; leg < tests::trials(6); ++leg) {
            const BlockCamera from = anyCamera(random, 128);
            const BlockCamera to = anyCamera(random, 128);
            flight.latency = 1 + tests::below(random, 3);
            for (int i = 0; i < 40; ++i) {
                const BlockCamera camera = between(from, to, i / 40.0);
                flight.turn = turns.next();
                const ChunkFrame& frame = flight.step(camera);
                hasBegun |= !frame.draws.empty();
                if (hasBegun) {
                    expectBothClosed(frame, flight.streamer->tree(), camera.view());
                    expectBothClosed(flight.shown, flight.streamer->tree(), camera.view());
                }
                EXPECT_LE(frame.residentBytes, cache);
                fading += frame.fading;
            }
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(fading, 0U);
    }
}

TEST(ChunkTurn, changesNothingUntilTheNextBegins)
{
    auto random = tests::random(72);
    const auto store = shared(tests::city(4, 4, false));
    StreamingSettings settings = settingsFor(0.04);
    settings.occlusion = false;
    std::size_t changes = 0;
    for (int trial = 0; trial < tests::trials(6); ++trial) {
        Flight flight(store, settings);
        flight.feedback = Feedback::none;
        Turns turns(7);
        // The chunks come bit by bit, so that there is something to wait for.
        const BlockCamera camera = anyCamera(random, 128);
        std::set<ChunkIndex> former;
        std::set<ChunkIndex> present;
        for (int i = 0; i < 80; ++i) {
            flight.turn = turns.next();
            const bool hadNone = present.empty();
            const ChunkFrame& frame = flight.step(camera);
            if (hadNone) {
                present = pictureOf(frame, true);
                former = present;
            } else if (flight.turn.begins) {
                former = std::exchange(present, pictureOf(frame, true));
                changes += former != present ? 1U : 0U;
            }
            EXPECT_EQ(pictureOf(frame, false), former) << i;
            EXPECT_EQ(pictureOf(frame, true), present) << i;
        }
        const ChunkFrame& last = flight.step(camera);
        EXPECT_TRUE(last.isComplete);
        EXPECT_EQ(last.fading, 0U);
        Flight direct(store, settings);
        direct.feedback = Feedback::none;
        direct.settle(camera);
        EXPECT_EQ(present, pictureOf(direct.step(camera), true));
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(changes, 10U);
    }
}

TEST(ChunkTurn, keepsItsPicturesWhileTheViewMovesAsFarAsTheyAreInView)
{
    const auto store = shared(tests::city(4, 4, false));
    StreamingSettings settings = settingsFor(0.04);
    settings.occlusion = false;
    settings.uploadBytes = 1U << 24U;
    settings.hostBytes = 1U << 24U;
    Flight flight(store, settings);
    flight.feedback = Feedback::none;
    // All stays in view: then nothing is decided within a transition.
    BlockCamera from;
    from.eye = {64, -90, 60};
    from.forward = {0, 1, -0.4};
    BlockCamera to = from;
    to.eye.y -= 200;
    flight.settle(from);
    Turns turns(8);
    std::set<ChunkIndex> former;
    std::set<ChunkIndex> present;
    std::size_t fading = 0;
    for (int i = 0; i < 96; ++i) {
        const BlockCamera camera = between(from, to, i / 96.0);
        flight.turn = turns.next();
        const ChunkFrame& frame = flight.step(camera);
        if (flight.turn.begins && i > 0) {
            EXPECT_EQ(pictureOf(frame, false), present) << "what was present is the former";
        }
        if (!flight.turn.begins) {
            EXPECT_EQ(pictureOf(frame, false), former);
            EXPECT_EQ(pictureOf(frame, true), present);
        }
        former = pictureOf(frame, false);
        present = pictureOf(frame, true);
        fading += frame.fading;
    }
    EXPECT_GT(fading, 0U);
}

TEST(ChunkTurn, showsTheSameAsWithoutTransitionsWhereEachFrameIsOne)
{
    auto random = tests::random(74);
    const auto store = shared(tests::city(4, 4, true));
    Flight with(store, settingsFor(0.04, 150'000));
    Flight without(store, settingsFor(0.04, 150'000));
    for (int leg = 0; leg < tests::trials(4); ++leg) {
        const BlockCamera from = anyCamera(random, 128);
        const BlockCamera to = anyCamera(random, 128);
        for (int i = 0; i < 20; ++i) {
            const BlockCamera camera = between(from, to, i / 20.0);
            with.turn = {.begins = true, .weight = 1};
            const ChunkFrame& a = with.step(camera);
            const ChunkFrame& b = without.step(camera);
            EXPECT_TRUE(Flight::isSame(a.draws, b.draws));
            EXPECT_EQ(a.fading, 0U);
            EXPECT_EQ(a.isComplete, b.isComplete);
        }
    }
}

TEST(ChunkTurn, hidesNothingThatCanBeSeenOnceItHasEnded)
{
    auto random = tests::random(75);
    const auto store = shared(tests::city(4, 4, true));
    StreamingSettings all = settingsFor(0.04);
    Flight flight(store, all);
    all.occlusion = false;
    Flight truth(store, all);
    Turns turns(4);
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        for (int i = 0; i < 60; ++i) {
            flight.turn = turns.next();
            if (!flight.step(camera).isComplete)
                flight.streamer->waitForChunks();
        }
        flight.turn = {};
        flight.settle(camera);
        truth.settle(camera);
        EXPECT_EQ(flight.depth, truth.depth);
        EXPECT_EQ(flight.chunk, truth.chunk);
    }
}

} // namespace
} // namespace isofront::voxels

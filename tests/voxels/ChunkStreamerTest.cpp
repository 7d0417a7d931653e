#include "ChunkFlight.h"

namespace isofront::voxels {
namespace {

TEST(ChunkStreamer, drawsTheCoarsestChunksThatAreFineEnough)
{
    auto random = tests::random(11);
    const auto store = shared(tests::city(4, 4, false));
    std::set<std::uint32_t> levels;
    for (int trial = 0; trial < tests::trials(20); ++trial) {
        const double most = trial % 2 == 0 ? 0.05 : 0.4;
        Flight flight(store, settingsFor(most));
        flight.feedback = Feedback::none;
        const ChunkTree& tree = flight.streamer->tree();
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
            EXPECT_TRUE(node.isLeaf || draw.voxelPixels <= most);
            EXPECT_TRUE(node.parent == kNoChunk || pixels(node.parent) > most);
            EXPECT_EQ(draw.needsSource, node.isLeaf && draw.voxelPixels > 10 * most);
            EXPECT_FALSE(draw.occlusionOnly);
        }
    }
    EXPECT_EQ(levels, (std::set<std::uint32_t>{0, 1, 2, 3}));
}

TEST(ChunkStreamer, isClosedInEveryFrame)
{
    auto random = tests::random(12);
    for (const std::uint64_t cache : {1U << 22U, 150'000U, 70'000U}) {
        Flight flight(shared(tests::city(4, 4, true)), settingsFor(0.04, cache));
        flight.feedback = Feedback::random;
        flight.hasSecondPass = cache != 150'000;
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
                if (hasBegun) {
                    expectClosed(frame, flight.streamer->tree(), camera.view());
                    expectClosed(flight.shown, flight.streamer->tree(), camera.view());
                }
                EXPECT_LE(frame.residentBytes, cache);
            }
        }
        EXPECT_TRUE(hasBegun);
        if (tests::areAllTrialsMade()) {
            EXPECT_GT(flight.tested, 0U);
            EXPECT_EQ(flight.secondDraws > 0, flight.hasSecondPass);
        }
    }
}

/// How much the draws of a frame cost.
std::uint64_t voxelsOf(const ChunkFrame& frame)
{
    std::uint64_t voxels = 0;
    for (const ChunkDraw& draw : frame.draws)
        voxels += draw.voxels;
    return voxels;
}

TEST(ChunkStreamer, hidesNothingThatCanBeSeen)
{
    auto random = tests::random(13);
    const auto store = shared(tests::city(4, 4, true));
    Flight flight(store, settingsFor(0.04));
    StreamingSettings all = settingsFor(0.04);
    all.occlusion = false;
    Flight truth(store, all);
    std::uint64_t hidden = 0;
    for (int trial = 0; trial < tests::trials(12); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        flight.latency = 1 + tests::below(random, 3);
        flight.settle(camera);
        truth.settle(camera);
        EXPECT_EQ(flight.depth, truth.depth);
        EXPECT_EQ(flight.chunk, truth.chunk);
        hidden += flight.step(camera).draws.size() < truth.step(camera).draws.size() ? 1U : 0U;
    }
    EXPECT_GT(hidden, 0U);
}

TEST(ChunkStreamer, drawsLittleOfACityBehindAWall)
{
    const auto store = shared(tests::city(5, 6, true));
    StreamingSettings settings = settingsFor(0.005);
    BlockCamera camera;
    camera.eye = {128, -12, 20};
    camera.fieldOfView = 1.2;
    Flight flight(store, settings);
    flight.settle(camera);
    const std::uint64_t culled = voxelsOf(flight.step(camera));
    settings.occlusion = false;
    Flight truth(store, settings);
    truth.settle(camera);
    const std::uint64_t all = voxelsOf(truth.step(camera));
    EXPECT_LT(10 * culled, all) << culled << " of " << all;
    EXPECT_EQ(flight.depth, truth.depth);
}

TEST(ChunkStreamer, comesToRestWithinAFewFrames)
{
    auto random = tests::random(14);
    const std::uint32_t levels = 4;
    StreamingSettings settings = settingsFor(0.04);
    settings.uploadBytes = 1U << 24U;
    settings.hostBytes = 1U << 24U;
    settings.hiddenFrames = 1;
    Flight flight(shared(tests::city(levels, 4, true)), settings);
    flight.latency = 1;
    for (int trial = 0; trial < tests::trials(20); ++trial) {
        // Two frames until everything is there. Then closing climbs a level a frame. A chunk that
        // turns out to be too large to stay closed costs a few frames more, once a level.
        EXPECT_LE(flight.settle(anyCamera(random, 128)), static_cast<int>(2 + 3 * levels));
    }
}

TEST(ChunkStreamer, showsAllInEveryFrameWithASecondPass)
{
    auto random = tests::random(15);
    const auto store = shared(tests::city(4, 4, true));
    StreamingSettings settings = settingsFor(1e-3);
    settings.uploadBytes = 1U << 24U;
    settings.hostBytes = 1U << 24U;
    Flight flight(store, settings);
    flight.hasSecondPass = true;
    flight.latency = 1;
    settings.occlusion = false;
    Flight truth(store, settings);
    // from above everything is seen, and loaded
    BlockCamera above;
    above.eye = {64, 64, 400};
    above.forward = {0.001, 0.002, -1};
    above.fieldOfView = 1.4;
    flight.feedback = Feedback::none;
    flight.settle(above);
    flight.feedback = Feedback::exact;
    std::uint64_t tested = 0;
    for (int leg = 0; leg < tests::trials(3); ++leg) {
        const BlockCamera from = anyCamera(random, 128);
        const BlockCamera to = anyCamera(random, 128);
        for (int i = 0; i < 20; ++i) {
            BlockCamera camera = from;
            camera.eye += (to.eye - from.eye) * (i / 20.0);
            camera.forward += (to.forward - from.forward) * (i / 20.0);
            const ChunkFrame& frame = flight.step(camera);
            tested += frame.draws.size() - frame.opaque;
            truth.step(camera);
            truth.step(camera);
            truth.step(camera);
            ASSERT_EQ(flight.depth, truth.depth);
            ASSERT_EQ(flight.chunk, truth.chunk);
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(tested, 0U);
        EXPECT_GT(flight.secondDraws, 0U);
    }
}

TEST(ChunkStreamer, restsEvenIfTheCacheIsTooSmall)
{
    auto random = tests::random(16);
    const auto store = shared(tests::city(4, 4, false));
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        Flight whole(store, settingsFor(0.02));
        whole.feedback = Feedback::none;
        whole.settle(camera);
        const ChunkFrame& all = whole.step(camera);
        const double needed = static_cast<double>(all.wantedBytes);
        EXPECT_EQ(all.coarsening, 1);
        double before = 1e9;
        for (const double share : {0.1, 0.3, 0.6, 0.95, 1.1}) {
            StreamingSettings settings =
                settingsFor(0.02, static_cast<std::uint64_t>(share * needed));
            // the largest chunk may take a good part of it
            settings.cacheBytes += 2 * 16'384;
            Flight flight(store, settings);
            flight.feedback = trial % 2 == 0 ? Feedback::none : Feedback::exact;
            for (int i = 0; i < 30; ++i)
                flight.step(anyCamera(random, 128));
            flight.settle(camera);
            const std::uint64_t uploaded = flight.device.uploaded;
            const std::uint64_t moved = flight.device.moved;
            for (int i = 0; i < 50; ++i) {
                const ChunkFrame& frame = flight.step(camera);
                expectClosed(frame, flight.streamer->tree(), camera.view());
                EXPECT_TRUE(frame.evictions.empty());
                EXPECT_LE(frame.residentBytes, settings.cacheBytes);
                if (i == 0 && trial % 2 == 0) {
                    EXPECT_LE(frame.coarsening, before) << "more room, more detail";
                    before = frame.coarsening;
                    EXPECT_EQ(frame.coarsening == 1, share > 1) << share;
                }
            }
            EXPECT_EQ(flight.device.uploaded, uploaded);
            EXPECT_EQ(flight.device.moved, moved);
        }
    }
}

TEST(ChunkStreamer, movesChunksTogetherOnTheWay)
{
    auto random = tests::random(17);
    StreamingSettings settings = settingsFor(0.03, 90'000);
    settings.uploadBytes = 50'000;
    Flight flight(shared(tests::city(4, 4, true)), settings);
    flight.feedback = Feedback::random;
    std::size_t evictions = 0;
    for (int i = 0; i < tests::trials(400); ++i) {
        BlockCamera camera = anyCamera(random, 128);
        flight.latency = 1 + static_cast<std::uint64_t>(i) % 6;
        for (int j = 0; j < 4; ++j)
            evictions += flight.step(camera).evictions.size();
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(evictions, 50U);
        EXPECT_GT(flight.device.moved, 5U);
    }
}

TEST(ChunkStreamer, showsTheSameWhateverTheJobs)
{
    auto random = tests::random(19);
    const auto store = shared(tests::city(4, 4, true));
    Flight inlined(store, settingsFor(0.03, 300'000));
    Flight threaded(store, settingsFor(0.03, 300'000), core::JobsBackend::threads);
    for (Flight* flight : {&inlined, &threaded})
        flight->feedback = Feedback::none;
    for (int trial = 0; trial < tests::trials(6); ++trial) {
        const BlockCamera passing = anyCamera(random, 128);
        const BlockCamera camera = anyCamera(random, 128);
        for (Flight* flight : {&inlined, &threaded}) {
            for (int i = 0; i < 5; ++i)
                flight->step(passing);
            flight->settle(camera, 100'000);
        }
        const ChunkFrame& a = inlined.step(camera);
        const ChunkFrame& b = threaded.step(camera);
        EXPECT_TRUE(
            std::ranges::equal(a.draws, b.draws, [](const ChunkDraw& p, const ChunkDraw& q) {
                return p.index == q.index && p.weight == q.weight;
            }));
    }
}

TEST(ChunkStreamer, endsWhileChunksAreBeingLoaded)
{
    const auto store = shared(tests::city(4, 4, true));
    for (int trial = 0; trial < tests::trials(50); ++trial) {
        Flight flight(store, settingsFor(0.01), core::JobsBackend::threads);
        flight.feedback = Feedback::none;
        BlockCamera camera;
        camera.eye = {64, -60, 50};
        for (int i = 0; i < trial % 5; ++i)
            flight.step(camera);
    }
}

TEST(ChunkStreamer, mayShowPartsInsteadOfParents)
{
    auto random = tests::random(20);
    const auto store = shared(tests::city(4, 4, false));
    StreamingSettings settings = settingsFor(0.03);
    Flight closed(store, settings);
    settings.policy = StreamingPolicy::partial;
    settings.uploadBytes = 4000;
    Flight partial(store, settings);
    bool hadHoles = false;
    for (Flight* flight : {&closed, &partial})
        flight->feedback = Feedback::none;
    const ChunkTree& tree = partial.streamer->tree();
    for (int trial = 0; trial < tests::trials(5); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        for (int i = 0; i < 100; ++i) {
            const ChunkFrame& frame = partial.step(camera);
            std::vector<int> drawn(tree.size(), 0);
            for (const ChunkDraw& draw : frame.draws)
                ++drawn[draw.index];
            for (ChunkIndex leaf = 0; leaf < tree.size(); ++leaf) {
                if (!tree[leaf].isLeaf || !camera.view().mayShow(tree[leaf].box))
                    continue;
                int covers = 0;
                for (ChunkIndex at = leaf; at != kNoChunk; at = tree[at].parent)
                    covers += drawn[at];
                ASSERT_LE(covers, 1);
                ASSERT_TRUE(covers == 1 || frame.missing > 0);
                hadHoles |= covers == 0 && !frame.draws.empty();
            }
        }
        partial.settle(camera);
        closed.settle(camera);
        EXPECT_TRUE(std::ranges::equal(
            partial.step(camera).draws,
            closed.step(camera).draws,
            [](const ChunkDraw& p, const ChunkDraw& q) { return p.index == q.index; }));
    }
    EXPECT_TRUE(hadHoles);
}

TEST(ChunkStreamer, changesWeightsWithoutAJump)
{
    Flight flight(shared(tests::city(4, 4, false)), settingsFor(0.03));
    flight.feedback = Feedback::none;
    std::map<ChunkIndex, float> before;
    int replaced = 0;
    constexpr int kSteps = 1500;
    for (int i = 0; i < kSteps; ++i) {
        BlockCamera camera;
        const double t = static_cast<double>(i) / kSteps;
        camera.eye = {64 + 3 * t, -200 + 230 * t, 60 - 20 * t};
        camera.forward = {0, 1, -0.1};
        camera.fieldOfView = 1.5;
        if (i == 0)
            flight.settle(camera);
        else
            for (int j = 0; j < 3; ++j)
                flight.step(camera);
        const ChunkFrame& frame = flight.step(camera);
        std::map<ChunkIndex, float> now;
        for (const ChunkDraw& draw : frame.draws)
            now[draw.index] = draw.weight;
        const ChunkTree& tree = flight.streamer->tree();
        if (i > 0)
            for (const auto& [index, weight] : now) {
                const ChunkIndex parent = tree[index].parent;
                if (before.contains(index)) {
                    EXPECT_NEAR(weight, before[index], 0.1);
                } else if (parent != kNoChunk && before.contains(parent)) {
                    ++replaced;
                    EXPECT_LT(weight, 0.1) << "children begin as their parent looks";
                    EXPECT_GT(before[parent], 0.9);
                }
            }
        before = std::move(now);
    }
    EXPECT_GT(replaced, 20);
}

/// Pebbles in a space of 128 along an edge, at four levels of detail.
std::shared_ptr<const ChunkStore> pebbles()
{
    auto random = tests::random(21);
    TriangleModel model;
    for (int i = 0; i < 24; ++i) {
        const glm::dvec3 centre(
            tests::uniform(random, 0, 128),
            tests::uniform(random, 0, 128),
            tests::uniform(random, 0, 128));
        const TriangleModel one = tests::hillySphere(6, 1.5, 0.4, centre);
        const auto first = static_cast<std::uint32_t>(model.positions.size());
        model.positions.insert(model.positions.end(), one.positions.begin(), one.positions.end());
        for (const auto& triangle : one.triangles)
            model.triangles.push_back(
                {first + triangle[0], first + triangle[1], first + triangle[2]});
    }
    auto store = memoryStore();
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    const auto report = voxelize(model, {.resolution = 2000}, *store, *jobs);
    EXPECT_TRUE(report) << report.error().message;
    EXPECT_FALSE(store->finish({.name = "pebbles", .lattice = report->lattice}));
    return store;
}

TEST(ChunkStreamer, keepsWhatFadingChunksRead)
{
    const auto store = pebbles();
    auto random = tests::random(22);
    StreamingSettings settings = settingsFor(0.02, 2U << 20U);
    settings.continuous = true;
    settings.uploadBytes = 200'000;
    settings.moveBytes = 400'000;
    settings.hostBytes = 1'000'000;
    std::uint64_t evictions = 0;
    for (const Feedback feedback : {Feedback::none, Feedback::random}) {
        Flight flight(store, settings);
        flight.feedback = feedback;
        flight.hasSecondPass = true;
        const ChunkTree& tree = flight.streamer->tree();
        bool hasBegun = false;
        for (int leg = 0; leg < tests::trials(8); ++leg) {
            const BlockCamera from = anyCamera(random, 128);
            const BlockCamera to = anyCamera(random, 128);
            flight.latency = 1 + tests::below(random, 3);
            for (int i = 0; i < 30; ++i) {
                BlockCamera camera = from;
                camera.eye += (to.eye - from.eye) * (i / 30.0);
                camera.forward += (to.forward - from.forward) * (i / 30.0);
                const ChunkFrame& frame = flight.step(camera);
                evictions += frame.evictions.size();
                hasBegun |= !frame.draws.empty();
                if (hasBegun)
                    expectClosed(frame, tree, camera.view());
                EXPECT_LE(frame.residentBytes, settings.cacheBytes);
                for (const ChunkDraw& draw : frame.draws)
                    EXPECT_EQ(
                        draw.fades, draw.weight < 1 && !draw.occlusionOnly && draw.index != 0);
            }
        }
        if (tests::areAllTrialsMade()) {
            EXPECT_GT(flight.device.faded, 1000U);
            EXPECT_GT(flight.device.moved, 0U);
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(evictions, 50U);
    }
}

TEST(ChunkStreamer, choosesTheSameWhetherChunksFade)
{
    const auto store = pebbles();
    auto random = tests::random(23);
    StreamingSettings settings = settingsFor(0.03, 64U << 20U);
    settings.uploadBytes = settings.hostBytes = 64U << 20U;
    Flight hard(store, settings);
    settings.continuous = true;
    Flight soft(store, settings);
    hard.feedback = soft.feedback = Feedback::none;
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        hard.settle(camera);
        soft.settle(camera);
        const ChunkFrame& a = hard.step(camera);
        const ChunkFrame& b = soft.step(camera);
        EXPECT_TRUE(
            std::ranges::equal(a.draws, b.draws, [](const ChunkDraw& p, const ChunkDraw& q) {
                return p.index == q.index && p.weight == q.weight && !p.fades;
            }));
        EXPECT_LT(a.wantedBytes, b.wantedBytes) << "transitions are counted";
    }
    EXPECT_EQ(hard.device.faded, 0U);
    EXPECT_GT(soft.device.faded, 0U);
}

TEST(ChunkStreamer, fadesNothingFromParentsThatAreNotThere)
{
    auto random = tests::random(24);
    StreamingSettings settings = settingsFor(0.03, 64U << 20U);
    settings.continuous = true;
    settings.uploadBytes = settings.hostBytes = 64U << 20U;
    const auto whole = pebbles();
    // a store without its coarsest chunk, and one whose parents don't contain their children
    const ChunkKey root{whole->model().lattice.levels - 1, 0, 0, 0};
    Flight rootless(std::make_shared<DamagedStore>(whole, std::set<ChunkKey>{root}), settings);
    Flight odd(shared(tests::city(4, 4, false)), settings);
    rootless.feedback = odd.feedback = Feedback::none;
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        const BlockCamera camera = anyCamera(random, 128);
        odd.settle(camera);
        EXPECT_FALSE(odd.step(camera).draws.empty());
        for (int i = 0; i < 20; ++i)
            for (const ChunkDraw& draw : rootless.step(camera).draws)
                EXPECT_TRUE(!draw.fades || draw.key.level + 1 < root.level);
    }
    EXPECT_EQ(odd.device.faded, 0U);
    EXPECT_GT(rootless.device.faded, 0U);
}

TEST(ChunkStreamer, refusesWhatMakesNoSense)
{
    const auto store = shared(tests::city(3, 2, false));
    const auto codeOf = [&](const StreamingSettings& settings) {
        const auto made =
            ChunkStreamer::create(store, settings, core::makeJobs(core::JobsBackend::inlined));
        return made ? 0 : static_cast<int>(made.error().code);
    };
    StreamingSettings settings = settingsFor(1);
    EXPECT_EQ(codeOf(settings), 0);
    settings.cacheBytes = 1000;
    EXPECT_EQ(codeOf(settings), static_cast<int>(core::ErrorCode::resourceLimit));
    for (const double pixels : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        settings = settingsFor(1);
        settings.voxelPixels = pixels;
        EXPECT_EQ(codeOf(settings), static_cast<int>(core::ErrorCode::usage));
    }
    settings = settingsFor(1);
    settings.uploadBytes = 255;
    EXPECT_EQ(codeOf(settings), static_cast<int>(core::ErrorCode::usage));
}

TEST(ChunkStreamer, keepsItsViewIfTheNextIsNone)
{
    Flight flight(shared(tests::city(3, 2, false)), settingsFor(0.03));
    flight.feedback = Feedback::none;
    BlockCamera camera;
    camera.eye = {32, -60, 30};
    flight.settle(camera);
    const std::vector<ChunkDraw> before = flight.step(camera).draws;
    camera.eye.x = std::numeric_limits<double>::quiet_NaN();
    const ChunkFrame& refused = flight.step(camera);
    EXPECT_TRUE(refused.isRefused);
    EXPECT_TRUE(Flight::isSame(before, refused.draws));
    camera.eye.x = 1e300; // far beyond everything
    EXPECT_FALSE(flight.step(camera).isRefused);
}

TEST(ChunkStreamer, showsNothingOfAnEmptyModel)
{
    auto store = memoryStore();
    StoredModel model;
    model.lattice.resolution = 1;
    ASSERT_FALSE(store->finish(model));
    Flight flight(std::move(store), settingsFor(1));
    const ChunkFrame& frame = flight.step({});
    EXPECT_TRUE(frame.draws.empty());
    EXPECT_TRUE(frame.isComplete);
}

TEST(ChunkStreamer, givesCapsToWhatItUploads)
{
    const ChunkForm form = standardForm();
    Chunk chunk;
    chunk.voxels = {
        {packPlace(0, 3, 255, 0), 7},
        {packPlace(5, 6, 255, kAllFaces), 8},
    };
    for (const bool isColoured : {false, true}) {
        if (isColoured)
            chunk.colours = {0xff112233, 0xff445566};
        const ChunkEntry entry = entryOf(chunk);
        std::vector<std::byte> bytes(form.bytes(entry));
        ASSERT_EQ(bytes.size(), isColoured ? 24U : 16U);
        form.pack(chunk, bytes);
        std::vector<std::uint32_t> words(bytes.size() / 4);
        std::memcpy(words.data(), bytes.data(), bytes.size());
        EXPECT_EQ(words[0], packPlace(0, 3, 255, 0b100001));
        EXPECT_EQ(words[1], 7U);
        EXPECT_EQ(words[2], packPlace(5, 6, 255, kAllFaces));
        EXPECT_EQ(words[3], 8U);
        if (isColoured) {
            EXPECT_EQ(words[4], 0xff112233);
            EXPECT_EQ(words[5], 0xff445566);
        }
    }
}

} // namespace
} // namespace isofront::voxels

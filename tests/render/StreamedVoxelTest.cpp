#include "render/support/VoxelFixture.h"

#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/LevelTransition.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace isofront::test {
namespace {

using voxels::ChunkDraw;
using voxels::ChunkFrame;
using voxels::ChunkStreamer;

const hierarchy::Domain kDomain{.origin = glm::dvec3(-2.0), .edge = 4.0};
const render::Scene kScene{.look = render::Look::studio, .antialias = false};

/// A model, a streamer of its chunks and a renderer that does what the streamer says.
class StreamedVoxels : public VoxelFixture {
protected:
    static render::RendererOptions options()
    {
        render::RendererOptions options = VoxelFixture::options();
        options.voxelPoolBytes = 24U << 20U;
        return options;
    }

    void open(
        std::shared_ptr<const voxels::ChunkStore> chunks, const voxels::StreamingSettings& settings)
    {
        shown = renderer(kDomain, options());
        store = std::move(chunks);
        lattice = store->model().lattice;
        number = 0;
        auto created =
            ChunkStreamer::create(store, settings, core::makeJobs(core::JobsBackend::inlined));
        ASSERT_TRUE(created) << created.error().message;
        streamer = std::move(*created);
    }

    /// Updates and draws the next frame. Returns what was to be drawn.
    std::vector<ChunkDraw> next(const hierarchy::View& view, VoxelWay way = VoxelWay::automatic)
    {
        const auto sights = shown->takeSights();
        const auto completed = shown->completedFrame();
        EXPECT_TRUE(sights && completed);
        std::vector<voxels::Visibility> seen;
        for (const render::FrameSight& sight : *sights)
            seen.push_back({.frame = sight.frame, .visible = sight.visible});
        ++number;
        const ChunkFrame& frame = streamer->update(
            voxels::perspectiveView(
                view.eye,
                view.forward,
                view.up,
                view.verticalFieldOfView,
                view.width,
                view.height,
                shown->defaultNearPlane()),
            number,
            *completed,
            seen);
        complete = frame.isComplete;
        const auto applied = shown->apply(frame);
        EXPECT_TRUE(applied) << applied.error().message;
        EXPECT_EQ(*applied, frame.uploadBytes);
        moved += frame.moves.size();
        evicted += frame.evictions.size();
        drawPlaced(view, frame.draws, way);
        return frame.draws;
    }
    void drawPlaced(const hierarchy::View& view, std::span<const ChunkDraw> draws, VoxelWay way)
    {
        const auto drawn = shown->draw(
            view,
            kScene,
            {.lattice = lattice,
             .placed = draws,
             .tree = &streamer->tree(),
             .frame = number,
             .way = way});
        ASSERT_TRUE(drawn) << drawn.error().message;
    }
    /// Draws frames until all is there and known, and the same ones follow each other.
    std::vector<ChunkDraw> settle(const hierarchy::View& view)
    {
        std::vector<ChunkDraw> draws;
        int same = 0;
        for (int i = 0; i < 200 && same < 8; ++i) {
            const std::vector<ChunkDraw> now = next(view);
            EXPECT_TRUE(shown->finish());
            const bool equal =
                complete && std::equal(
                                now.begin(),
                                now.end(),
                                draws.begin(),
                                draws.end(),
                                [](const ChunkDraw& a, const ChunkDraw& b) {
                                    return a.key == b.key && a.occlusionOnly == b.occlusionOnly;
                                });
            same = equal ? same + 1 : 0;
            draws = now;
        }
        EXPECT_EQ(same, 8) << "the frames never became steady";
        return draws;
    }

    /// The picture of these chunks, brought to another renderer without a streamer.
    VoxelShot plain(
        const hierarchy::View& view,
        std::span<const ChunkDraw> draws,
        VoxelWay way = VoxelWay::automatic)
    {
        const auto other = renderer(kDomain, options());
        std::map<voxels::ChunkKey, Chunk> known;
        const auto chunkOf = [&](const voxels::ChunkKey& key) -> const Chunk& {
            return known.try_emplace(key, **store->get(key)).first->second;
        };
        std::vector<render::VoxelTransition> transitions;
        std::vector<VoxelDraw> list;
        for (const ChunkDraw& draw : draws) {
            list.push_back({draw.key, draw.occlusionOnly, draw.fades ? draw.weight : 1.0F});
            const Chunk& chunk = chunkOf(draw.key);
            if (draw.fades)
                transitions.push_back(
                    {draw.key, *voxels::transitionNodes(chunk, chunkOf(draw.key.parent()))});
        }
        std::vector<Chunk> chunks;
        for (const auto& [key, chunk] : known)
            chunks.push_back(chunk);
        add(*other, chunks);
        const auto added = other->addTransitions(transitions);
        EXPECT_TRUE(added) << added.error().message;
        return shootVoxels(*other, view, {.lattice = lattice, .draws = list, .way = way}, kScene);
    }

    voxels::VoxelLattice lattice;
    std::shared_ptr<const voxels::ChunkStore> store;
    std::unique_ptr<ChunkStreamer> streamer;
    std::unique_ptr<render::Renderer> shown;
    std::uint64_t number = 0;
    bool complete = false;
    std::size_t moved = 0;
    std::size_t evicted = 0;
};

/// A wall with boxes behind it, and one box beside it.
std::shared_ptr<const voxels::ChunkStore> wallAndBoxes(bool coloured = false)
{
    voxels::TriangleModel model;
    const auto addBox = [&](const glm::dvec3& low, const glm::dvec3& high) {
        const auto first = static_cast<std::uint32_t>(model.positions.size());
        for (unsigned i = 0; i < 8; ++i)
            model.positions.push_back(
                {(i & 1U) != 0 ? high.x : low.x,
                 (i & 2U) != 0 ? high.y : low.y,
                 (i & 4U) != 0 ? high.z : low.z});
        constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
            {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
        for (const auto& side : kSides) {
            model.triangles.push_back({first + side[0], first + side[1], first + side[2]});
            model.triangles.push_back({first + side[0], first + side[2], first + side[3]});
        }
    };
    addBox({-0.17, 0.1, -0.17}, {0.17, 0.12, 0.17});
    for (const double x : {-0.25, -0.1, 0.1, 0.25})
        for (const double z : {-0.2, 0.15})
            addBox({x - 0.02, 0.9, z - 0.02}, {x + 0.02, 1.1, z + 0.02});
    addBox({0.85, 0.9, 0.0}, {0.9, 0.95, 0.05});
    for (std::size_t i = 0; coloured && i < model.positions.size(); ++i)
        model.colours.push_back(0xff4080ffU - 0x1fU * static_cast<std::uint32_t>(i % 8));
    return stored(model, 1024);
}

TEST_F(StreamedVoxels, areDrawnWhereTheStreamerHasPlacedThem)
{
    // A cache that is too small for the model, and little to upload at a time.
    ASSERT_NO_FATAL_FAILURE(open(
        wallAndBoxes(),
        {.voxelPixels = 0.1,
         .occlusion = false,
         .cacheBytes = 2200U << 10U,
         .uploadBytes = 256U << 10U}));
    for (int i = 0; i < 40; ++i) {
        const double angle = 0.3 * i;
        const glm::dvec3 eye(0.1, 0.5, 0.05);
        const glm::dvec3 ahead(std::cos(angle), std::sin(angle), 0.1);
        const hierarchy::View view = lookingAt(eye, eye + ahead, 64, 48);
        const std::vector<ChunkDraw> draws = next(view);
        if (i % 10 != 9)
            continue; // frames in flight
        const auto depth = shown->readDepth();
        const auto image = shown->readImage();
        ASSERT_TRUE(depth && image);
        const VoxelShot expected = plain(view, draws);
        EXPECT_EQ(*depth, expected.depth) << "frame " << i;
        EXPECT_EQ(image->rgba, expected.image.rgba) << "frame " << i;
    }
    EXPECT_GT(evicted, 0U);
}

TEST_F(StreamedVoxels, fadeAsThoseThatWereAddedDo)
{
    for (const bool coloured : {false, true}) {
        ASSERT_NO_FATAL_FAILURE(open(
            wallAndBoxes(coloured),
            {.voxelPixels = 0.5,
             .occlusion = false,
             .continuous = true,
             .cacheBytes = (coloured ? 3600U : 3000U) << 10U,
             .uploadBytes = 1U << 20U}));
        evicted = 0;
        std::size_t faded = 0;
        for (int i = 0; i < 40; ++i) {
            const double angle = 0.3 * i;
            const glm::dvec3 eye(0.1, 0.5, 0.05);
            const glm::dvec3 ahead(std::cos(angle), std::sin(angle), 0.1);
            const hierarchy::View view = lookingAt(eye, eye + ahead, 64, 48);
            const std::vector<ChunkDraw> draws = next(view);
            if (i % 10 != 9)
                continue; // frames in flight
            faded += static_cast<std::size_t>(std::ranges::count(draws, true, &ChunkDraw::fades));
            const auto depth = shown->readDepth();
            const auto image = shown->readImage();
            ASSERT_TRUE(depth && image);
            const VoxelShot expected = plain(view, draws);
            EXPECT_EQ(*depth, expected.depth) << "frame " << i;
            EXPECT_EQ(image->rgba, expected.image.rgba) << "frame " << i;
        }
        EXPECT_GT(evicted, 0U);
        EXPECT_GT(faded, 0U);
    }
}

TEST_F(StreamedVoxels, changeLittleByLittleBetweenLevels)
{
    // A pebble over a corner where chunks meet, and a speck far away, so that there are more
    // levels.
    voxels::TriangleModel pebble = tests::hillySphere(24, 0.1, 0.018);
    const auto first = static_cast<std::uint32_t>(pebble.positions.size());
    for (const double at : {-1.0, 1.0})
        pebble.positions.push_back(glm::dvec3(at));
    pebble.triangles.push_back({first, first, first});
    pebble.triangles.push_back({first + 1, first + 1, first + 1});
    const auto model = stored(pebble, 560);
    const hierarchy::View view = lookingAt({0.24, -0.42, 0.15}, {0, 0, 0}, 80, 60);
    voxels::StreamingSettings settings{
        .voxelPixels = 0.1, .occlusion = false, .continuous = true, .cacheBytes = 24U << 20U};
    ASSERT_NO_FATAL_FAILURE(open(model, settings));
    // A bound by which all that is drawn is on its way.
    settings.voxelPixels = 0;
    for (const ChunkDraw& draw : settle(view))
        settings.voxelPixels = std::max(settings.voxelPixels, 1.05 * draw.voxelPixels);
    ASSERT_NO_FATAL_FAILURE(open(model, settings));
    std::vector<ChunkDraw> draws = settle(view);
    ASSERT_FALSE(draws.empty());
    ASSERT_TRUE(std::ranges::all_of(draws, &ChunkDraw::fades));

    std::vector<ChunkDraw> parents;
    for (ChunkDraw draw : draws) {
        draw.key = draw.key.parent();
        draw.fades = false;
        if (std::ranges::find(parents, draw.key, &ChunkDraw::key) == parents.end())
            parents.push_back(draw);
    }
    for (const VoxelWay way : kWays) {
        std::vector<std::vector<std::uint8_t>> images;
        std::vector<std::vector<float>> depths;
        const auto shoot = [&] {
            drawPlaced(view, draws, way);
            images.push_back(shown->readImage()->rgba);
            depths.push_back(*shown->readDepth());
        };
        constexpr int kSteps = 32;
        for (int step = 0; step <= kSteps; ++step) {
            for (ChunkDraw& draw : draws)
                draw.weight = static_cast<float>(step) / kSteps;
            shoot();
            if (step == kSteps / 2) {
                EXPECT_EQ(plain(view, draws, way).image.rgba, images.back());
            }
        }
        for (ChunkDraw& draw : draws)
            draw.fades = false;
        shoot(); // as if it had switched at once
        for (ChunkDraw& draw : draws)
            draw.fades = true;
        EXPECT_EQ(images[kSteps], images[kSteps + 1]);
        EXPECT_EQ(depths[kSteps], depths[kSteps + 1]);
        const auto differs = [](float a, float b) {
            return std::abs(a - b) > 1e-4F * std::max(a, b);
        };
        const std::vector<float> coarse = plain(view, parents, way).depth;
        std::size_t odd = 0;
        for (std::size_t i = 0; i < coarse.size(); ++i)
            odd += differs(coarse[i], depths[0][i]) ? 1U : 0U;
        // the same cubes in eight parts: rounding at edges
        EXPECT_LT(odd, coarse.size() / 200);

        const auto difference = [&](std::size_t a, std::size_t b) {
            double sum = 0;
            for (std::size_t i = 0; i < images[a].size(); ++i)
                sum += std::abs(images[a][i] - images[b][i]);
            return sum;
        };
        const double whole = difference(0, kSteps);
        double most = 0;
        std::size_t nearer = 0;
        for (std::size_t step = 0; step < kSteps; ++step) {
            most = std::max(most, difference(step, step + 1));
            // what is finer lies within what is coarser: nothing opens but at the outline
            for (std::size_t i = 0; i < coarse.size(); ++i)
                nearer += depths[step + 1][i] > depths[step][i] &&
                                  differs(depths[step + 1][i], depths[step][i])
                              ? 1U
                              : 0U;
        }
        EXPECT_GT(whole, 0);
        EXPECT_LT(most, whole / 8);
        EXPECT_LT(nearer, coarse.size() / 200);
        RecordProperty("largest_step", std::to_string(most / whole));
    }
}

TEST_F(StreamedVoxels, hideNothingThatCanBeSeenAndDrawNothingHidden)
{
    const auto scene = wallAndBoxes();
    const hierarchy::View view = lookingAt({0, -0.2, 0}, {0, 1, 0}, 128, 96);
    const auto hiddenDrawn = [&](std::span<const ChunkDraw> draws) {
        return std::count_if(draws.begin(), draws.end(), [&](const ChunkDraw& draw) {
            const core::Box& box = streamer->tree()[draw.index].box;
            return box.low.y > 0.6 && box.high.x < 0.5 && !draw.occlusionOnly;
        });
    };
    constexpr double kAllDetail = 0.1;
    ASSERT_NO_FATAL_FAILURE(
        open(scene, {.voxelPixels = kAllDetail, .occlusion = true, .cacheBytes = 8U << 20U}));
    const std::vector<ChunkDraw> culled = settle(view);
    const std::vector<float> depth = *shown->readDepth();
    EXPECT_EQ(hiddenDrawn(culled), 0);
    ASSERT_NO_FATAL_FAILURE(
        open(scene, {.voxelPixels = kAllDetail, .occlusion = false, .cacheBytes = 8U << 20U}));
    const std::vector<ChunkDraw> all = settle(view);
    EXPECT_GT(hiddenDrawn(all), 0);
    EXPECT_EQ(depth, *shown->readDepth());

    // After a jump to the side the picture is right at once with a second pass.
    const hierarchy::View beside = lookingAt({-0.5, -0.2, 0}, {0.2, 1, 0}, 128, 96);
    ASSERT_NO_FATAL_FAILURE(
        open(scene, {.voxelPixels = kAllDetail, .occlusion = true, .cacheBytes = 8U << 20U}));
    settle(beside); // loads
    settle(view);   // hides
    std::vector<ChunkDraw> draws = next(beside);
    ASSERT_TRUE(complete);
    ASSERT_TRUE(shown->finish());
    const std::vector<float> early = *shown->readDepth();
    const auto sights = shown->takeSights();
    ASSERT_TRUE(sights);
    ASSERT_EQ(sights->back().frame, number);
    ASSERT_EQ(sights->back().visible.size(), draws.size());
    const auto more = streamer->secondPass(sights->back().visible);
    draws.insert(draws.end(), more.begin(), more.end());
    drawPlaced(beside, draws, VoxelWay::automatic);
    const std::vector<float> exact = *shown->readDepth();
    settle(beside);
    EXPECT_EQ(exact, *shown->readDepth());
    EXPECT_NE(early, exact) << "the first pass alone would have been enough";
}

TEST_F(StreamedVoxels, takeOverThePoolFromAddedChunksAndGiveItBack)
{
    ASSERT_NO_FATAL_FAILURE(
        open(stored(tests::hillySphere(8, 1.0, 0.2), 100), {.cacheBytes = 1U << 20U}));
    const hierarchy::View view = lookingAt({3, 3, 3}, {0, 0, 0});
    const Chunk chunk = **store->get(streamer->tree()[0].entry.key);
    const std::array<VoxelDraw, 1> list{{{.key = chunk.key}}};
    const render::VoxelScene alone{.lattice = lattice, .draws = list};
    // A frame that reads an added chunk is under way when the first streamed one is copied.
    ASSERT_TRUE(shown->addChunks({&chunk, 1}));
    ASSERT_TRUE(shown->draw(view, kScene, alone));
    shown->removeChunks({&chunk.key, 1});
    const std::vector<ChunkDraw> draws = settle(view);
    EXPECT_EQ(*shown->readDepth(), plain(view, draws).depth);

    const auto mixed = shown->addChunks({&chunk, 1});
    ASSERT_FALSE(mixed);
    EXPECT_EQ(mixed.error().code, core::ErrorCode::usage);
    next(view); // and is under way
    ASSERT_TRUE(shown->clearChunks());
    ASSERT_TRUE(shown->addChunks({&chunk, 1}));
    const auto other = renderer(kDomain, options());
    add(*other, {&chunk, 1});
    EXPECT_EQ(
        shootVoxels(*shown, view, alone, kScene).depth,
        shootVoxels(*other, view, alone, kScene).depth);
}

TEST_F(StreamedVoxels, refuseWhatDoesNotFit)
{
    ASSERT_NO_FATAL_FAILURE(
        open(stored(tests::hillySphere(8, 1.0, 0.2), 100), {.cacheBytes = 1U << 20U}));
    const auto bytes = shown->chunkCacheBytes();
    ASSERT_TRUE(bytes);
    EXPECT_EQ(*bytes, options().voxelPoolBytes);
    const std::vector<std::byte> some(16);
    ChunkFrame frame;
    frame.uploads.push_back({.index = 0, .offset = *bytes - 8, .data = some, .isLast = true});
    const auto outside = shown->apply(frame);
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().code, core::ErrorCode::usage);
    const hierarchy::View view = lookingAt({3, 3, 3}, {0, 0, 0});
    ChunkDraw draw;
    draw.key = streamer->tree()[0].entry.key;
    draw.voxels = streamer->tree()[0].entry.voxels;
    draw.offset = *bytes - 16;
    for (const voxels::ChunkTree* tree : {&streamer->tree(), decltype(&streamer->tree()){}}) {
        const auto drawn =
            shown->draw(view, kScene, {.lattice = lattice, .placed = {&draw, 1}, .tree = tree});
        ASSERT_FALSE(drawn);
        EXPECT_EQ(drawn.error().code, core::ErrorCode::usage);
    }
    // A streamer's places and the renderer's own would overlap.
    const Chunk chunk = **store->get(draw.key);
    ASSERT_TRUE(shown->addChunks({&chunk, 1}));
    frame.uploads.clear();
    EXPECT_FALSE(shown->apply(frame));
}

} // namespace
} // namespace isofront::test

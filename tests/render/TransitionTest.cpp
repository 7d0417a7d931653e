#include "shared/transition.h"

#include "render/support/VoxelFixture.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <random>

namespace isofront::test {
namespace {

constexpr double kEdge = 1000.0;
const std::array kWeights{0.0F, 1.0F / 128, 0.2F, 0.5F, 0.77F, 1.0F};

hierarchy::View fromOutside()
{
    return lookingAt({-300, -500, 900}, {500, 500, 450});
}

/// Nothing that a pixel shows depends on another one.
render::Scene pixelwise(float weight)
{
    return {.look = render::Look::studio, .transition = weight, .antialias = false};
}

bool showsPresent(const hierarchy::View& view, std::size_t pixel, float weight)
{
    const auto x = static_cast<std::uint32_t>(pixel % static_cast<std::size_t>(view.width));
    const auto y = static_cast<std::uint32_t>(pixel / static_cast<std::size_t>(view.width));
    return shared::ditherThreshold(x, y) < weight;
}

std::uint32_t colourOf(const core::Image& image, std::size_t pixel)
{
    std::uint32_t colour = 0;
    std::memcpy(&colour, image.rgba.data() + 4 * pixel, sizeof colour);
    return colour;
}

surface::Delta replacing(
    const std::vector<surface::ShownCell>& before,
    const std::vector<surface::ShownCell>& after,
    std::uint64_t version)
{
    surface::Delta delta = showing(after, version);
    for (const surface::ShownCell& cell : before)
        delta.removed.push_back(cell.id);
    return delta;
}

class Transitions : public VoxelFixture {
protected:
    hierarchy::Domain domain{.edge = kEdge};

    Shot alone(const std::vector<surface::ShownCell>& cells, const render::Scene& scene)
    {
        const auto shown = renderer(domain);
        show(*shown, showing(cells));
        return shoot(*shown, fromOutside(), scene);
    }
    /// Each pixel of the mixed picture is that of one of the others, as the pattern says.
    static void expectMixed(
        const Shot& mixed,
        const Shot& former,
        const Shot& present,
        float weight,
        const hierarchy::View& view = fromOutside())
    {
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < mixed.depth.size(); ++i) {
            const Shot& expected = showsPresent(view, i, weight) ? present : former;
            wrong += mixed.depth[i] != expected.depth[i] ||
                             colourOf(mixed.image, i) != colourOf(expected.image, i)
                         ? 1U
                         : 0U;
        }
        EXPECT_EQ(wrong, 0U) << "weight " << weight;
    }
};

TEST_F(Transitions, showAtEachPixelTheFormerOrThePresentMeshAsIfAlone)
{
    const auto fine = cut(sphere(glm::dvec3(0.5), 0.3, 32), 4, 1);
    const auto coarse = cut(sphere({0.52, 0.47, 0.5}, 0.31, 9), 3, 2, 1);
    const auto stays = cut(sphere({0.2, 0.3, 0.6}, 0.12, 12), 2, 3, 2);
    const auto shown = renderer(domain);
    shown->holdChanges(true);
    show(*shown, showing(fine, 1));
    show(*shown, showing(stays, 2));
    EXPECT_EQ(shoot(*shown, fromOutside(), pixelwise(1)).stats.cellsDrawn, 0U) << "all waits";
    shown->beginTransition();
    show(*shown, replacing(fine, coarse, 3));
    shown->beginTransition();

    std::vector<surface::ShownCell> first = fine;
    first.insert(first.end(), stays.begin(), stays.end());
    std::vector<surface::ShownCell> second = coarse;
    second.insert(second.end(), stays.begin(), stays.end());
    const Shot former = alone(first, pixelwise(1));
    const Shot present = alone(second, pixelwise(1));
    for (const float weight : kWeights) {
        const Shot mixed = shoot(*shown, fromOutside(), pixelwise(weight));
        expectMixed(mixed, former, present, weight);
        const bool isPure = weight <= 0 || weight >= 1;
        EXPECT_EQ(mixed.stats.cellsFading == 0, isPure);
        EXPECT_EQ(
            mixed.stats.cellsDrawn + mixed.stats.cellsCulled,
            stays.size() + (weight < 1 ? fine.size() : 0) + (weight > 0 ? coarse.size() : 0));
    }
    // What was asked for anew waits, whatever the weight; what isn't a weight shows all.
    show(*shown, replacing(coarse, fine, 4));
    for (const float weight : {1.0F, 7.0F, std::numeric_limits<float>::quiet_NaN()})
        expectMixed(shoot(*shown, fromOutside(), pixelwise(weight)), former, present, 1);
    expectMixed(shoot(*shown, fromOutside(), pixelwise(-3)), former, present, 0);
    shown->beginTransition();
    expectMixed(shoot(*shown, fromOutside(), pixelwise(0.3F)), present, former, 0.3F);
    shown->holdChanges(false);
    expectMixed(shoot(*shown, fromOutside(), pixelwise(0.3F)), former, former, 0.3F);
}

TEST_F(Transitions, changeNothingWhereBothMeshesAreTheSame)
{
    const GridMesh mesh = sphere(glm::dvec3(0.5), 0.3, 32);
    const auto before = cut(mesh, 5, 1);
    const auto shown = renderer(domain);
    shown->holdChanges(true);
    show(*shown, showing(before));
    shown->beginTransition();
    shown->beginTransition();
    // All of it: shadows, haze, softened edges.
    const auto sceneAt = [](float weight) { return render::Scene{.transition = weight}; };
    const Shot first = shoot(*shown, fromOutside(), sceneAt(0.4F));
    show(*shown, replacing(before, cut(mesh, 4, 2, 1), 2));
    EXPECT_EQ(shoot(*shown, fromOutside(), sceneAt(1)), first);
    shown->beginTransition();
    for (const float weight : kWeights)
        EXPECT_EQ(shoot(*shown, fromOutside(), sceneAt(weight)), first) << weight;
}

TEST_F(Transitions, showAtEachPixelTheFormerOrThePresentShadowsAsIfAlone)
{
    // A ball above the ground that goes elsewhere. In view is the ground, and on it both shadows.
    const auto ground = cut(sheet(16, [](double, double) { return 0.25; }), 3, 1);
    const auto before = cut(sphere({0.45, 0.5, 0.4}, 0.05, 24), 2, 2, 1);
    const auto after = cut(sphere({0.52, 0.45, 0.4}, 0.04, 24), 2, 3, 1);
    const hierarchy::View view = lookingAt({400, 560, 620}, {400, 545, 250}, 96, 96);
    const auto sceneAt = [](float weight) {
        render::Scene scene{.transition = weight, .antialias = false};
        scene.sunDirection = {0.4, -0.3, 1.0};
        scene.shadowDistance = 600;
        scene.shadowInterval = 1000; // it is transitions that ask for new ones
        return scene;
    };
    render::RendererOptions options = smallOptions();
    options.shadowMapSize = 512;
    const auto picture = [&](const std::vector<surface::ShownCell>& ball,
                             const hierarchy::View& from) {
        const auto shown = renderer(domain, options);
        show(*shown, showing(ground, 1));
        show(*shown, showing(ball, 2));
        return shoot(*shown, from, sceneAt(1));
    };
    const auto shown = renderer(domain, options);
    shown->holdChanges(true);
    show(*shown, showing(ground, 1));
    show(*shown, showing(before, 2));
    shown->beginTransition();
    const Shot former = picture(before, view);
    const Shot present = picture(after, view);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < former.depth.size(); ++i)
        moved += former.depth[i] == present.depth[i] &&
                         colourOf(former.image, i) != colourOf(present.image, i)
                     ? 1U
                     : 0U;
    EXPECT_GT(moved, former.depth.size() / 40) << "shadows alone make a difference";
    EXPECT_EQ(shoot(*shown, view, sceneAt(1)), former);
    show(*shown, replacing(before, after, 3));
    shown->beginTransition();
    std::vector<bool> isDrawn;
    for (const float weight : {0.0F, 0.2F, 0.5F, 0.77F}) {
        const Shot mixed = shoot(*shown, view, sceneAt(weight));
        expectMixed(mixed, former, present, weight, view);
        isDrawn.push_back(mixed.stats.shadowTriangles > 0);
    }
    EXPECT_EQ(isDrawn, (std::vector{true, false, false, false}));

    // Both maps stay where they are while the eye flies on.
    const hierarchy::View further = lookingAt({412, 557, 615}, {410, 543, 250}, 96, 96);
    const Shot flown = shoot(*shown, further, sceneAt(0.5F));
    const std::array expected{picture(before, further), picture(after, further)};
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < flown.depth.size(); ++i) {
        const Shot& alone = expected[showsPresent(further, i, 0.5F) ? 1 : 0];
        for (std::size_t channel = 0; channel < 3; ++channel)
            wrong += std::abs(
                         int{flown.image.rgba[4 * i + channel]} -
                         int{alone.image.rgba[4 * i + channel]}) > 2
                         ? 1U
                         : 0U;
    }
    EXPECT_LE(wrong, flown.depth.size() / 500);
    EXPECT_EQ(shoot(*shown, view, sceneAt(1)), present);
}

TEST_F(Transitions, followHeldDeltasUnderRandomChange)
{
    // With a pool that is large enough, and one that has no room for what fades now and then.
    for (const std::uint64_t poolBytes : {2U << 20U, 210U << 10U}) {
        render::RendererOptions options = smallOptions();
        options.poolBytes = poolBytes;
        options.slabBytes = 8U << 10U;
        const auto shown = renderer(domain, options);
        shown->holdChanges(true);
        const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 36), 8, 5);
        const auto others = cut(sphere(glm::dvec3(0.5), 0.28, 30), 8, 6);
        // By place in the list: 1 the first sphere's cell, 2 the other's, under the same name.
        using Picture = std::map<std::size_t, int>;
        Picture wanted;
        Picture present;
        Picture former;
        const auto cellsOf = [&](const Picture& picture) {
            std::vector<surface::ShownCell> all;
            for (const auto& [place, which] : picture)
                all.emplace_back(cells[place].id, (which == 1 ? cells : others)[place].mesh());
            return all;
        };
        const std::size_t places = std::min(cells.size(), others.size());
        std::mt19937 random(47);
        std::size_t skipped = 0;
        for (std::uint64_t step = 1; step <= 40; ++step) {
            surface::Delta delta;
            delta.version = step;
            for (std::size_t place = 0; place < places; ++place) {
                if (random() % 100 < 80)
                    continue;
                if (wanted.contains(place))
                    delta.removed.push_back(cells[place].id);
                wanted.erase(place);
                const int which = static_cast<int>(random() % 3);
                if (which == 0)
                    continue;
                wanted[place] = which;
                delta.added.emplace_back(
                    cells[place].id, (which == 1 ? cells : others)[place].mesh());
            }
            const auto stats = shown->apply(delta);
            ASSERT_TRUE(stats) << stats.error().message;
            if (stats->skippedFade) {
                ++skipped;
                former = wanted;
                present = wanted;
            }
            if (random() % 3 == 0) {
                shown->beginTransition();
                former = std::exchange(present, wanted);
            }
            ASSERT_EQ(shown->cellCount(), wanted.size());
            const auto drawn = shown->draw(fromOutside(), pixelwise(0.5F));
            ASSERT_TRUE(drawn);
            EXPECT_LE(drawn->fadingBytes, drawn->poolBytesUsed);
            if (step % 10 != 0)
                continue;
            const Shot formerAlone = alone(cellsOf(former), pixelwise(1));
            const Shot presentAlone = alone(cellsOf(present), pixelwise(1));
            for (const float weight : {0.0F, 0.4F, 1.0F})
                expectMixed(
                    shoot(*shown, fromOutside(), pixelwise(weight)),
                    formerAlone,
                    presentAlone,
                    weight);
        }
        EXPECT_EQ(skipped > 0, poolBytes < 1U << 20U);
        shown->beginTransition();
        shown->beginTransition();
        const Shot last = shoot(*shown, fromOutside(), pixelwise(0.5F));
        EXPECT_EQ(last.stats.fadingBytes, 0U);
        EXPECT_EQ(last, alone(cellsOf(wanted), pixelwise(1)));
    }
}

TEST_F(Transitions, countTheMemoryOfWhatFades)
{
    const auto cells = cut(sphere(glm::dvec3(0.5), 0.3, 24), 3, 1);
    const auto others = cut(sphere(glm::dvec3(0.5), 0.2, 24), 3, 1, 1);
    const auto shown = renderer(domain);
    const auto fadingBytes = [&] { return shoot(*shown, fromOutside()).stats.fadingBytes; };
    shown->holdChanges(true);
    show(*shown, showing(cells));
    EXPECT_EQ(fadingBytes(), 0U) << "what waits is wanted";
    show(*shown, replacing(cells, others, 2));
    EXPECT_EQ(fadingBytes(), 0U) << "what never was shown is gone";
    shown->beginTransition();
    const std::uint64_t all = shoot(*shown, fromOutside()).stats.poolBytesUsed;
    show(*shown, replacing(others, {}, 3));
    EXPECT_EQ(shown->cellCount(), 0U);
    EXPECT_GT(fadingBytes(), 0U);
    EXPECT_LE(fadingBytes(), all);
    shown->beginTransition();
    EXPECT_GT(fadingBytes(), 0U) << "in the former picture";
    shown->beginTransition();
    EXPECT_EQ(fadingBytes(), 0U);
    show(*shown, showing(cells, 4));
    shown->clear();
    shown->beginTransition();
    EXPECT_EQ(shoot(*shown, fromOutside()).stats.cellsDrawn, 0U);
}

TEST_F(Transitions, showAtEachPixelTheFormerOrThePresentVoxelsAsIfAlone)
{
    const HillyModel model(260);
    const std::vector<Chunk> fine = model.cut(0);
    const std::vector<Chunk> coarse = model.cut(1);
    ASSERT_FALSE(fine.empty() || coarse.empty());
    const glm::dvec3 centre = model.lattice.origin + 0.5 * model.lattice.edge * glm::dvec3(260.0);
    hierarchy::Domain around;
    around.origin = centre - 1.5;
    around.edge = 3;
    const auto shown = renderer(around, options());
    // A mesh that goes through the voxels, and changes too.
    const auto before = cut(sphere({0.62, 0.4, 0.5}, 0.3, 24), 3, 1);
    const auto after = cut(sphere({0.61, 0.42, 0.5}, 0.3, 8), 3, 2, 1);
    add(*shown, fine);
    add(*shown, coarse);
    const hierarchy::View view = lookingAt(centre + glm::dvec3(-2, -2.5, 1.4), centre);
    const auto drawn = [&](std::uint32_t pictures, VoxelWay way, float weight) {
        std::vector<VoxelDraw> draws;
        for (const auto* level : {&fine, &coarse}) {
            VoxelDraw draw;
            draw.inFormer = level == &fine;
            draw.inPresent = level == &coarse;
            const std::uint32_t its = draw.inFormer ? shared::kInFormer : shared::kInPresent;
            for (const Chunk& chunk : *level) {
                draw.key = chunk.key;
                if ((its & pictures) != 0)
                    draws.push_back(draw);
            }
        }
        return shootVoxels(
            *shown,
            view,
            {.lattice = model.lattice, .draws = draws, .way = way},
            pixelwise(weight));
    };
    shown->holdChanges(true);
    show(*shown, showing(before));
    shown->beginTransition();
    show(*shown, replacing(before, after, 2));
    shown->beginTransition();
    for (const VoxelWay way : kWays) {
        const VoxelShot former = drawn(shared::kInFormer, way, 0);
        const VoxelShot present = drawn(shared::kInPresent, way, 1);
        EXPECT_GT(former.stats.voxels.voxels, present.stats.voxels.voxels);
        for (const float weight : {0.0F, 0.2F, 0.77F, 1.0F}) {
            const VoxelShot mixed = drawn(shared::kInBoth, way, weight);
            std::size_t wrong = 0;
            std::size_t voxels = 0;
            std::map<ChunkKey, bool> seen;
            for (std::size_t i = 0; i < mixed.depth.size(); ++i) {
                const VoxelShot& expected = showsPresent(view, i, weight) ? present : former;
                wrong += mixed.depth[i] != expected.depth[i] ||
                                 !(mixed.voxels[i] == expected.voxels[i]) ||
                                 colourOf(mixed.image, i) != colourOf(expected.image, i)
                             ? 1U
                             : 0U;
                voxels += mixed.voxels[i].isThere ? 1U : 0U;
                if (mixed.voxels[i].isThere)
                    seen[mixed.voxels[i].chunk] = true;
            }
            EXPECT_EQ(wrong, 0U) << "weight " << weight;
            EXPECT_GT(voxels, 1000U);
            for (const render::ChunkSight& sight : mixed.sight)
                EXPECT_EQ(sight.isVisible, seen.contains(sight.chunk));
            const bool isPure = weight <= 0 || weight >= 1;
            EXPECT_EQ(mixed.stats.voxels.chunksFading == 0, isPure);
        }
    }
}

TEST_F(Transitions, showStreamedChunksOfTwoLevelsAsIfAlone)
{
    constexpr int kFrames = 20;
    constexpr int kLength = 4;
    const HillyModel model(260);
    const auto streamer = *voxels::ChunkStreamer::create(
        model.store,
        {.voxelPixels = 1, .occlusion = false, .cacheBytes = 3U << 20U},
        core::makeJobs(core::JobsBackend::inlined));
    const glm::dvec3 centre = model.lattice.origin + 130.0 * glm::dvec3(model.lattice.edge);
    const auto shown = renderer({.origin = centre - 2.0, .edge = 4}, options());
    std::size_t fading = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        const double distance = 4.0 - 0.12 * frame;
        const hierarchy::View view =
            lookingAt(centre + distance * glm::dvec3(-0.6, -0.7, 0.38), centre);
        const float weight = static_cast<float>(frame % kLength) / kLength;
        const auto number = static_cast<std::uint64_t>(frame) + 1;
        const voxels::ChunkFrame& streamed = streamer->update(
            voxels::perspectiveView(
                view.eye,
                view.forward,
                view.up,
                view.verticalFieldOfView,
                view.width,
                view.height,
                shown->defaultNearPlane()),
            number,
            *shown->completedFrame(),
            {},
            {.begins = frame % kLength == 0, .weight = weight});
        ASSERT_TRUE(shown->apply(streamed));
        fading += streamed.fading;
        const auto at = [&](float w, std::uint64_t name) {
            return shootVoxels(
                *shown,
                view,
                {.lattice = model.lattice,
                 .placed = streamed.draws,
                 .tree = &streamer->tree(),
                 .frame = name},
                pixelwise(w));
        };
        const VoxelShot mixed = at(weight, number);
        if (streamed.fading == 0)
            continue;
        const VoxelShot former = at(0, 0);
        const VoxelShot present = at(1, 0);
        EXPECT_NE(former, present);
        expectMixed(mixed, former, present, weight);
    }
    EXPECT_GT(fading, 0U);
}

TEST_F(Transitions, leaveChunksOfNoPictureOut)
{
    const HillyModel model(96);
    const std::vector<Chunk> chunks = model.cut(0);
    hierarchy::Domain around{.origin = glm::dvec3(-2), .edge = 4};
    const auto shown = renderer(around, options());
    add(*shown, chunks);
    std::vector<VoxelDraw> draws = drawsOf(chunks);
    for (VoxelDraw& draw : draws) {
        draw.inFormer = false;
        draw.inPresent = false;
    }
    const VoxelShot shot = shootVoxels(
        *shown,
        lookingAt({-3, -3, 2}, {0, 0, 0}),
        {.lattice = model.lattice, .draws = draws},
        pixelwise(0.5F));
    EXPECT_EQ(shot.stats.voxels.chunksDrawn, 0U);
}

} // namespace
} // namespace isofront::test

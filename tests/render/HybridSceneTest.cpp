#include "render/support/VoxelFixture.h"
#include "shared/transition.h"
#include "support/Random.h"

#include <isofront/fields/Procedural.h>
#include <isofront/render/HybridScene.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isofront::test {
namespace {

using render::HybridFrame;
using render::HybridScene;
using render::HybridSettings;

constexpr double kPixelError = 1.0;
constexpr int kLattice = 8;

/// A torus as meshes and as voxels of the same field.
class HybridScenes : public VoxelFixture {
protected:
    static void SetUpTestSuite()
    {
        _source = *fields::makeProcedural("torus", {});
        std::unique_ptr<voxels::ChunkStore> store = voxels::memoryStore();
        const auto report = voxels::voxelizeField(
            *_source.field,
            {.isovalue = _source.isovalue,
             .box = _source.domain,
             .edge = _source.domain.size().x / kResolution},
            *store,
            *jobs());
        ASSERT_TRUE(report) << report.error().message;
        EXPECT_FALSE(store->finish({.name = "torus", .lattice = report->lattice}));
        _store = std::move(store);
    }
    static void TearDownTestSuite()
    {
        _store.reset();
        _source = {};
    }

    static constexpr double kResolution = 300;
    static std::shared_ptr<core::Jobs> jobs()
    {
        return core::makeJobs(core::JobsBackend::automatic, 2);
    }
    static hierarchy::Domain domain()
    {
        return {.origin = _source.domain.low, .edge = _source.domain.size().x};
    }
    static const std::shared_ptr<const voxels::ChunkStore>& model() { return _store; }
    static surface::Surface surfaceOf()
    {
        surface::SurfaceOptions options;
        options.extraction.isovalue = _source.isovalue;
        options.extraction.latticeSize = kLattice;
        options.pixelError = kPixelError;
        return surface::Surface(_source.field, domain(), options, jobs());
    }
    static HybridSettings settings(double pixels, double transitionSeconds = 0)
    {
        HybridSettings settings;
        settings.handOver.pixels = pixels;
        settings.streaming.voxelPixels = std::min(1.0, pixels / render::kVoxelError);
        settings.pixelError = kPixelError;
        settings.latticeSize = kLattice;
        settings.transitionSeconds = transitionSeconds;
        return settings;
    }
    static render::Scene look()
    {
        return {.look = render::Look::studio, .backdrop = glm::vec3(0.0F), .antialias = false};
    }

    struct Picture {
        std::vector<float> depth;
        std::vector<std::uint8_t> rgba;
        std::vector<render::ShownVoxel> voxels;
        HybridFrame frame;
    };
    static Picture pictureOf(render::Renderer& shown, const HybridFrame& frame)
    {
        return {*shown.readDepth(), shown.readImage()->rgba, *shown.readVoxels(), frame};
    }
    /// A complete picture of a scene made for it.
    Picture
    settled(const hierarchy::View& view, bool hasMeshes, bool hasVoxels, const HybridSettings& how)
    {
        const auto shown = renderer(domain(), options());
        surface::Surface surface = surfaceOf();
        auto scene = HybridScene::create(
            *shown, hasMeshes ? &surface : nullptr, hasVoxels ? model() : nullptr, jobs(), how);
        EXPECT_TRUE(scene) << scene.error().message;
        const auto frame = scene->settle(view, look());
        EXPECT_TRUE(frame) << frame.error().message;
        return pictureOf(*shown, *frame);
    }
    static hierarchy::View anyView(std::mt19937_64& random)
    {
        const double height = tests::uniform(random, -0.7, 0.7);
        const double angle = tests::uniform(random, 0, 2 * std::numbers::pi);
        const double away = tests::uniform(random, 1.2, 2.2);
        const glm::dvec3 eye(away * std::cos(angle), away * std::sin(angle), height);
        const auto near = [&] { return tests::uniform(random, -0.3, 0.3); };
        return lookingAt(eye, {near(), near(), near()}, 200, 150);
    }
    /// Pixels without anything where both others cover them and all around them.
    static std::size_t holes(
        const Picture& picture,
        const Picture& mesh,
        const Picture& voxels,
        const hierarchy::View& view)
    {
        const auto isCovered = [&](int x, int y) {
            const auto pixel = static_cast<std::size_t>(y * view.width + x);
            return mesh.depth[pixel] > 0 && voxels.depth[pixel] > 0;
        };
        std::size_t count = 0;
        for (int y = 1; y + 1 < view.height; ++y) {
            for (int x = 1; x + 1 < view.width; ++x) {
                if (picture.depth[static_cast<std::size_t>(y * view.width + x)] > 0)
                    continue;
                bool areAll = true;
                for (int i = -1; i <= 1; ++i)
                    for (int j = -1; j <= 1; ++j)
                        areAll = areAll && isCovered(x + j, y + i);
                count += areAll ? 1U : 0U;
            }
        }
        return count;
    }
    static std::size_t voxelPixels(const Picture& picture)
    {
        return static_cast<std::size_t>(
            std::ranges::count(picture.voxels, true, &render::ShownVoxel::isThere));
    }

    static inline fields::ProceduralSource _source;
    static inline std::shared_ptr<const voxels::ChunkStore> _store;
};

TEST_F(HybridScenes, lookLikeMeshesOrVoxelsAloneWhereOneHasAll)
{
    const hierarchy::View view = lookingAt({1.4, -1.0, 0.8}, {0, 0, 0}, 200, 150);
    const Picture meshes = settled(view, true, false, settings(1));
    const Picture onlyMeshes = settled(view, true, true, settings(1e-3));
    EXPECT_EQ(onlyMeshes.depth, meshes.depth);
    EXPECT_EQ(onlyMeshes.rgba, meshes.rgba);
    EXPECT_EQ(onlyMeshes.frame.voxelBlocks, 0U);
    EXPECT_GT(onlyMeshes.frame.meshBlocks, 0U);
    EXPECT_EQ(onlyMeshes.frame.drawn.voxels.chunksDrawn, 0U);
    EXPECT_LE(onlyMeshes.frame.residentVoxelBytes, 400'000U) << "next to nothing was loaded";

    const Picture voxels = settled(view, false, true, settings(1));
    const Picture onlyVoxels = settled(view, true, true, settings(1e4));
    EXPECT_EQ(onlyVoxels.depth, voxels.depth);
    EXPECT_EQ(onlyVoxels.rgba, voxels.rgba);
    EXPECT_EQ(onlyVoxels.frame.meshBlocks, 0U);
    EXPECT_EQ(onlyVoxels.frame.drawn.cellsDrawn, 0U);
    EXPECT_LT(onlyVoxels.frame.meshes.cellsAdded, onlyMeshes.frame.meshes.cellsAdded)
        << "nor is a mesh made that isn't shown";
    EXPECT_GT(voxelPixels(voxels), 3000U);
}

TEST_F(HybridScenes, haveNoHolesWhereMeshesAndVoxelsMeet)
{
    auto random = tests::random(31);
    std::size_t mixed = 0;
    for (int trial = 0; trial < tests::trials(5); ++trial) {
        const hierarchy::View view = anyView(random);
        // so that the bound lies somewhere in the picture
        const double middle = tests::uniform(random, 0.35, 0.7) * glm::length(view.eye);
        const double pixels =
            render::kVoxelError * domain().edge / kResolution * view.pixelsPerUnit() / middle;
        const Picture mesh = settled(view, true, false, settings(1));
        const Picture voxels = settled(view, false, true, settings(pixels));
        const Picture hybrid = settled(view, true, true, settings(pixels));
        EXPECT_EQ(holes(hybrid, mesh, voxels, view), 0U) << trial;
        const std::size_t shown = voxelPixels(hybrid);
        const auto covered = static_cast<std::size_t>(
            std::ranges::count_if(mesh.depth, [](float depth) { return depth > 0; }));
        mixed += shown > 200 && shown + 200 < covered ? 1U : 0U;
        // what is cut where the other begins doesn't fade
        EXPECT_EQ(hybrid.frame.drawn.cellsFading, 0U);
        EXPECT_EQ(hybrid.frame.drawn.voxels.chunksFading, 0U);
        // what meshes show is where it would be without voxels, but for where these come before
        std::size_t moved = 0;
        for (std::size_t i = 0; i < mesh.depth.size(); ++i)
            moved += !hybrid.voxels[i].isThere && hybrid.depth[i] > mesh.depth[i] * 1.02F ? 1U : 0U;
        EXPECT_EQ(moved, 0U);
    }
    EXPECT_TRUE(mixed > 1 || !tests::areAllTrialsMade()) << mixed;
}

TEST_F(HybridScenes, haveNoHolesInFlight)
{
    const auto shown = renderer(domain(), options());
    surface::Surface surface = surfaceOf();
    const hierarchy::View first = lookingAt({2.0, 0, 0.6}, {0, 0, 0}, 120, 90);
    const double pixels =
        render::kVoxelError * domain().edge / kResolution * first.pixelsPerUnit() / 1.9;
    auto scene = HybridScene::create(*shown, &surface, model(), jobs(), settings(pixels, 0.2));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(scene->settle(first, look()));
    std::size_t changes = 0;
    HybridFrame before;
    const int frames = tests::trials(20);
    for (int i = 0; i < frames; ++i) {
        const double angle = 0.02 * i;
        const double away = 2.0 - 0.008 * i;
        const hierarchy::View view =
            lookingAt({away * std::cos(angle), away * std::sin(angle), 0.6}, {0, 0, 0}, 120, 90);
        const auto frame = scene->frame(view, look(), i / 30.0);
        ASSERT_TRUE(frame) << frame.error().message;
        changes += i > 0 && frame->meshBlocks != before.meshBlocks ? 1U : 0U;
        before = *frame;
        if (i % 10 != 9 && i + 1 != frames)
            continue;
        const Picture picture = pictureOf(*shown, *frame);
        // the torus itself, whatever the meshes are
        const Picture mesh = settled(view, true, false, settings(1));
        const Picture voxels = settled(view, false, true, settings(pixels));
        EXPECT_EQ(holes(picture, mesh, voxels, view), 0U) << i;
    }
    EXPECT_TRUE(changes > 0 || !tests::areAllTrialsMade());
}

TEST_F(HybridScenes, leaveEverythingToMeshesUntilVoxelsAreThere)
{
    const hierarchy::View view = lookingAt({2.0, 0, 0.6}, {0, 0, 0}, 120, 90);
    const auto shown = renderer(domain(), options());
    surface::Surface surface = surfaceOf();
    auto scene = HybridScene::create(*shown, &surface, model(), jobs(), settings(1e4, 0.2));
    ASSERT_TRUE(scene) << scene.error().message;
    const auto first = scene->frame(view, look(), 0);
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(first->voxelBlocks, 0U) << "none of them can be shown";
    EXPECT_GT(first->meshBlocks, 0U);
    EXPECT_FALSE(first->isComplete);
    ASSERT_TRUE(scene->settle(view, look()));
    // nothing changes any more: complete, although the clock goes on
    bool isComplete = false;
    for (int i = 1; i <= 5000 && !isComplete; ++i) {
        const auto frame = scene->frame(view, look(), i / 30.0);
        ASSERT_TRUE(frame) << frame.error().message;
        EXPECT_EQ(frame->meshBlocks, 0U);
        isComplete = frame->isComplete && frame->transition < 1;
    }
    EXPECT_TRUE(isComplete);
}

TEST_F(HybridScenes, showInEachPixelOneOfTwoHandOvers)
{
    const hierarchy::View view = lookingAt({1.5, -1.0, 0.8}, {0, 0, 0}, 200, 150);
    const auto shown = renderer(domain(), options());
    surface::Surface surface = surfaceOf();
    const surface::Delta delta = surface.settle(view);
    show(*shown, delta);
    const auto directory = model()->directory();
    const auto tree = voxels::ChunkTree::create(model()->model().lattice, *directory);
    ASSERT_TRUE(tree);
    std::vector<Chunk> chunks;
    std::vector<VoxelDraw> draws;
    for (voxels::ChunkIndex i = 0; i < tree->size(); ++i) {
        if (!(*tree)[i].isLeaf)
            continue;
        chunks.push_back(**model()->get((*tree)[i].entry.key));
        draws.push_back({.key = chunks.back().key});
    }
    add(*shown, chunks);
    const Chunk root = **model()->get((*tree)[0].entry.key);
    const double pixels =
        render::kVoxelError * domain().edge / kResolution * view.pixelsPerUnit() / 1.9;
    auto handOver = render::HandOver::create(
        *tree, &root, domain(), kLattice, {.pixels = pixels, .meshPixels = 1e6});
    ASSERT_TRUE(handOver) << handOver.error().message;
    handOver->apply(delta);
    for (const VoxelWay way : kWays) {
        handOver->begin(lookingAt({1.0, -1.4, 0.8}, {0, 0, 0}, 200, 150), {});
        handOver->begin(view, {});
        render::VoxelScene voxels;
        voxels.lattice = tree->lattice();
        voxels.draws = draws;
        voxels.way = way;
        voxels.handOver = &*handOver;
        const auto drawn = [&](float weight) {
            render::Scene scene = look();
            scene.transition = weight;
            return shootVoxels(*shown, view, voxels, scene);
        };
        const VoxelShot former = drawn(0);
        const VoxelShot present = drawn(1);
        std::size_t different = 0;
        for (std::size_t i = 0; i < former.depth.size(); ++i)
            different += former.depth[i] != present.depth[i] ? 1U : 0U;
        EXPECT_GT(different, 20U);
        for (const float weight : {0.1F, 0.5F, 0.9F}) {
            const VoxelShot mixed = drawn(weight);
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < mixed.depth.size(); ++i) {
                const auto x = static_cast<std::uint32_t>(i % 200);
                const auto y = static_cast<std::uint32_t>(i / 200);
                const VoxelShot& expected =
                    shared::ditherThreshold(x, y) < weight ? present : former;
                const bool isSame = mixed.depth[i] == expected.depth[i] &&
                                    mixed.voxels[i] == expected.voxels[i] &&
                                    std::equal(
                                        &mixed.image.rgba[4 * i],
                                        &mixed.image.rgba[4 * i] + 4,
                                        &expected.image.rgba[4 * i]);
                wrong += isSame ? 0U : 1U;
            }
            EXPECT_EQ(wrong, 0U) << weight;
        }
        // the present one is what is left when it is over
        handOver->end();
        const VoxelShot after = drawn(0.3F);
        EXPECT_EQ(after.depth, present.depth);
        EXPECT_EQ(after.image.rgba, present.image.rgba);
    }
}

TEST_F(HybridScenes, letVoxelsCastShadowsWhereTheyAreAndInViewOrNot)
{
    render::Scene sunny;
    sunny.sunDirection = {0.6, 0.2, 0.5};
    sunny.shadowDistance = 6;
    sunny.antialias = false;
    // Voxels are large, so that their shadows show what they are of.
    std::unique_ptr<voxels::ChunkStore> store = voxels::memoryStore();
    const auto report = voxels::voxelizeField(
        *_source.field,
        {.isovalue = _source.isovalue, .box = _source.domain, .edge = _source.domain.size().x / 40},
        *store,
        *jobs());
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_FALSE(store->finish({.name = "torus", .lattice = report->lattice}));
    const std::shared_ptr<const voxels::ChunkStore> coarse = std::move(store);
    const auto pictured = [&](double pixels, const hierarchy::View& view) {
        const auto shown = renderer(domain(), options());
        surface::Surface surface = surfaceOf();
        auto scene = HybridScene::create(
            *shown, &surface, pixels > 0 ? coarse : nullptr, jobs(), settings(pixels));
        EXPECT_TRUE(scene) << scene.error().message;
        const auto frame = scene->settle(view, sunny);
        EXPECT_TRUE(frame) << frame.error().message;
        return pictureOf(*shown, *frame);
    };
    // Near meshes get the same light whether what is behind them is of voxels or not.
    const hierarchy::View across = lookingAt({0, -1.5, 0.5}, {0, 0, 0}, 200, 150);
    const Picture meshes = pictured(0, across);
    const Picture both = pictured(4, across);
    EXPECT_GT(both.frame.meshBlocks, 0U);
    EXPECT_GT(both.frame.drawn.voxels.shadowVoxels, 0U);
    std::size_t shared = 0;
    std::size_t odd = 0;
    for (std::size_t i = 0; i < meshes.depth.size(); ++i) {
        if (both.voxels[i].isThere || meshes.depth[i] == 0 || both.depth[i] != meshes.depth[i])
            continue;
        ++shared;
        odd += std::abs(int{both.rgba[4 * i]} - int{meshes.rgba[4 * i]}) > 12 ? 1U : 0U;
    }
    EXPECT_GT(shared, 1000U);
    EXPECT_LT(odd, shared / 100);
    EXPECT_GT(voxelPixels(both), 100U);

    // A part of it in view: the rest casts its shadows, too.
    hierarchy::View part = lookingAt({0, -1.5, 0.5}, {0.5, -0.5, 0}, 60, 40);
    part.verticalFieldOfView = 0.1;
    const auto shown = renderer(domain(), options());
    surface::Surface surface = surfaceOf();
    auto scene = HybridScene::create(*shown, &surface, model(), jobs(), settings(100));
    ASSERT_TRUE(scene) << scene.error().message;
    const auto frame = scene->settle(part, sunny);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_GT(frame->drawn.voxels.voxels, 0U);
    EXPECT_GT(frame->drawn.voxels.shadowVoxels, frame->drawn.voxels.voxels);
}

} // namespace
} // namespace isofront::test

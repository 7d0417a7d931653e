#include "render/support/VoxelFixture.h"
#include "support/Random.h"

#include <isofront/render/HybridScene.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <numbers>
#include <stop_token>

namespace isofront::test {
namespace {

using render::HybridFrame;
using render::HybridScene;
using render::HybridSettings;

/// A model of voxels, and the hills that it was made from.
class SourceScenes : public VoxelFixture {
protected:
    static void SetUpTestSuite()
    {
        _hills = tests::hillySphere(60, 1.0, 0.15);
        for (std::size_t i = 0; i < _hills.positions.size(); ++i) {
            const glm::dvec3 p = 127.0 + 100.0 * _hills.positions[i];
            const auto code = [](double c) { return static_cast<std::uint32_t>(c); };
            _hills.colours.push_back(code(p.x) | code(p.y) << 8U | code(p.z) << 16U | 0xff000000U);
        }
        _store = stored(_hills, kResolution);
        _coarse = stored(_hills, kCoarse);
    }
    static void TearDownTestSuite()
    {
        _store.reset();
        _coarse.reset();
        _hills = {};
    }

    using Store = std::shared_ptr<const voxels::ChunkStore>;
    static constexpr std::uint32_t kResolution = 300;
    /// Of nine times fewer voxels, for what isn't about them: to draw them takes most of the time.
    static constexpr std::uint32_t kCoarse = 100;
    static std::shared_ptr<core::Jobs> jobs()
    {
        return core::makeJobs(core::JobsBackend::automatic, 2);
    }
    static const voxels::VoxelLattice& lattice() { return _store->model().lattice; }
    static render::RendererOptions sourceOptions()
    {
        render::RendererOptions all = options();
        all.meshColours = true;
        all.poolBytes = 16U << 20U;
        return all;
    }
    static render::Scene look()
    {
        return {.look = render::Look::studio, .backdrop = glm::vec3(0.0F), .antialias = false};
    }
    /// @param pixels  of voxels, above which the source is shown
    static HybridSettings settings(double pixels, double transitionSeconds = 0)
    {
        HybridSettings settings;
        settings.handOver.hysteresis = 1;
        settings.streaming.voxelPixels = pixels;
        settings.streaming.occlusion = false;
        settings.transitionSeconds = transitionSeconds;
        settings.source = [](const std::stop_token&) {
            return core::Result<voxels::TriangleModel>(_hills);
        };
        return settings;
    }
    struct Picture {
        std::vector<float> depth;
        std::vector<std::uint8_t> rgba;
        std::vector<render::ShownVoxel> voxels;
        HybridFrame frame;

        [[nodiscard]] bool isSame(const Picture& other, std::size_t pixel) const
        {
            return depth[pixel] == other.depth[pixel] &&
                   std::memcmp(&rgba[4 * pixel], &other.rgba[4 * pixel], 4) == 0;
        }
    };
    static Picture pictureOf(render::Renderer& shown, const HybridFrame& frame)
    {
        return {*shown.readDepth(), shown.readImage()->rgba, *shown.readVoxels(), frame};
    }
    Picture settled(
        const hierarchy::View& view,
        const HybridSettings& how,
        const render::RendererOptions& with = sourceOptions(),
        const render::Scene& looks = look(),
        const Store& store = _store)
    {
        const auto shown = renderer(render::voxelDomain(store->model().lattice), with);
        auto scene = HybridScene::create(*shown, nullptr, store, jobs(), how);
        EXPECT_TRUE(scene) << scene.error().message;
        const auto frame = scene->settle(view, looks);
        EXPECT_TRUE(frame) << frame.error().message;
        return pictureOf(*shown, *frame);
    }
    Picture voxelsAlone(const hierarchy::View& view, double pixels, const Store& store = _store)
    {
        HybridSettings how = settings(pixels);
        how.source = {};
        return settled(view, how, sourceOptions(), look(), store);
    }
    /// A bound that lies so far from the eye [px].
    static double boundAt(const hierarchy::View& view, double distance, const Store& store = _store)
    {
        return store->model().lattice.edge * view.pixelsPerUnit() / distance;
    }
    static hierarchy::View anyView(std::mt19937_64& random)
    {
        const auto any = [&](double most) { return tests::uniform(random, -most, most); };
        const double angle = any(std::numbers::pi);
        const double away = tests::uniform(random, 1.6, 2.4);
        const glm::dvec3 eye(away * std::cos(angle), away * std::sin(angle), any(0.7));
        return lookingAt(eye, {any(0.3), any(0.3), any(0.3)}, 200, 150);
    }
    static std::size_t voxelPixels(const Picture& picture)
    {
        return static_cast<std::size_t>(
            std::ranges::count(picture.voxels, true, &render::ShownVoxel::isThere));
    }
    /// Where a ray first meets the hills, as the renderer's depth would be; 0 if it doesn't.
    static double depthOf(const hierarchy::View& view, double near, const glm::dvec3& ray)
    {
        double nearest = 0;
        for (const auto& t : _hills.triangles) {
            const glm::dvec3 a = _hills.positions[t[0]] - view.eye;
            const glm::dvec3 u = _hills.positions[t[1]] - _hills.positions[t[0]];
            const glm::dvec3 v = _hills.positions[t[2]] - _hills.positions[t[0]];
            const glm::dvec3 n = glm::cross(u, v);
            const double along = glm::dot(n, a) / glm::dot(n, ray);
            const glm::dvec3 at = along * ray - a;
            const double area = glm::dot(n, n);
            const double b = glm::dot(glm::cross(at, v), n) / area;
            const double c = glm::dot(glm::cross(u, at), n) / area;
            if (along > 0 && b >= 0 && c >= 0 && b + c <= 1)
                nearest = std::max(nearest, near / along);
        }
        return nearest;
    }

    static inline voxels::TriangleModel _hills;
    static inline Store _store;
    static inline Store _coarse;
};

TEST_F(SourceScenes, showTheSourceAloneCloseUp)
{
    const hierarchy::View view = lookingAt({1.5, -0.4, 0.3}, {0.9, 0, 0.1}, 200, 150);
    const Picture all = settled(view, settings(1e-3));
    const Picture near = settled(view, settings(boundAt(view, 3.5)));
    EXPECT_EQ(voxelPixels(near), 0U);
    EXPECT_EQ(near.depth, all.depth);
    EXPECT_EQ(near.rgba, all.rgba);
    EXPECT_GT(near.frame.sourceBytes, 1000U);
    EXPECT_GT(near.frame.drawn.triangles, 1000U);
    EXPECT_FALSE(near.frame.sourceIsFull);
    EXPECT_FALSE(near.frame.sourceError);
    // and that is where the triangles are, to within a 1024th of a voxel
    const auto shown = renderer(render::voxelDomain(lattice()));
    std::size_t wrong = 0;
    std::size_t met = 0;
    for (int y = 1; y < view.height; y += 9) {
        for (int x = 1; x < view.width; x += 9) {
            const double expected = depthOf(view, shown->defaultNearPlane(), pixelRay(view, x, y));
            const auto depth = double(near.depth[static_cast<std::size_t>(y * view.width + x)]);
            met += expected > 0 ? 1U : 0U;
            wrong += std::abs(depth - expected) > 1e-4 * expected ? 1U : 0U;
        }
    }
    EXPECT_GT(met, 100U);
    EXPECT_LE(wrong, 2U) << "but for outlines";
}

TEST_F(SourceScenes, haveTheColoursOfTheSource)
{
    const hierarchy::View view = lookingAt({1.5, -0.4, 0.3}, {0.9, 0, 0.1}, 200, 150);
    const Picture source = settled(view, settings(1e-3));
    const Picture voxels = voxelsAlone(view, 1e-3);
    double difference = 0;
    double spread = 0;
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < source.depth.size(); ++i) {
        if (!(source.depth[i] > 0 && voxels.depth[i] > 0))
            continue;
        ++pixels;
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const double own = source.rgba[4 * i + channel];
            difference += std::abs(own - double(voxels.rgba[4 * i + channel]));
            spread += std::abs(own - 128);
        }
    }
    ASSERT_GT(pixels, 5000U);
    EXPECT_LT(difference / (3 * double(pixels)), 6) << "of 255: voxels have the same colours";
    EXPECT_GT(spread / (3 * double(pixels)), 15);
}

TEST_F(SourceScenes, haveNoBacksIfTheyAreClosed)
{
    render::Scene fronts = look();
    fronts.twoSided = false;
    render::Scene both = look();
    both.twoSided = true;
    const auto rgbaOf = [&](const HybridSettings& how, const render::Scene& looks) {
        const hierarchy::View inside = lookingAt({0.2, 0, 0}, {1, 0.1, 0}, 64, 48);
        return settled(inside, how, sourceOptions(), looks, _coarse).rgba;
    };
    const HybridSettings closed = settings(1e-3);
    const auto plain = rgbaOf(closed, look());
    EXPECT_EQ(plain, rgbaOf(closed, fronts));
    EXPECT_NE(plain, rgbaOf(closed, both)) << "who asks for backs gets them";

    // one that is open has backs, and shows them
    HybridSettings open = settings(1e-3);
    open.source = [](const std::stop_token&) {
        voxels::TriangleModel half = _hills;
        std::erase_if(
            half.triangles, [&](const auto& corners) { return half.positions[corners[0]].x < 0; });
        return core::Result<voxels::TriangleModel>(std::move(half));
    };
    const auto opened = rgbaOf(open, look());
    EXPECT_EQ(opened, rgbaOf(open, both));
    EXPECT_NE(opened, rgbaOf(open, fronts));
}

TEST_F(SourceScenes, haveNoHolesWhereSourceAndVoxelsMeet)
{
    auto random = tests::random(41);
    std::size_t mixed = 0;
    for (int trial = 0; trial < tests::trials(3); ++trial) {
        const hierarchy::View view = anyView(random);
        const double pixels =
            boundAt(view, tests::uniform(random, 0.45, 0.8) * glm::length(view.eye));
        const Picture both = settled(view, settings(pixels));
        const Picture source = settled(view, settings(1e-3));
        const Picture voxels = voxelsAlone(view, pixels);
        std::size_t holes = 0;
        std::size_t strange = 0;
        for (std::size_t i = 0; i < both.depth.size(); ++i) {
            const bool isCovered = source.depth[i] > 0 && voxels.depth[i] > 0;
            holes += isCovered && !(both.depth[i] > 0) ? 1U : 0U;
            const bool isOne = both.isSame(source, i) || both.isSame(voxels, i);
            // voxels at the seam show all their faces, and those that stand behind the mesh's place
            strange += isOne ? 0U : 1U;
            EXPECT_TRUE(isOne || both.voxels[i].isThere) << trial << " " << i;
        }
        EXPECT_EQ(holes, 0U) << trial;
        const std::size_t shown = voxelPixels(both);
        const auto covered = static_cast<std::size_t>(
            std::ranges::count_if(source.depth, [](float depth) { return depth > 0; }));
        EXPECT_LT(strange * 20, covered) << trial;
        mixed += shown > 200 && shown + 200 < covered ? 1U : 0U;
    }
    EXPECT_TRUE(mixed > 1 || !tests::areAllTrialsMade()) << mixed;
}

TEST_F(SourceScenes, stayVoxelsWithoutTheSource)
{
    const hierarchy::View view = lookingAt({1.5, -0.4, 0.3}, {0.9, 0, 0.1}, 200, 150);
    const double pixels = boundAt(view, 3.5);
    HybridSettings how = settings(pixels);
    how.source = [](const std::stop_token&) -> core::Result<voxels::TriangleModel> {
        return core::failure(core::ErrorCode::inputOutput, "hills.ply: gone");
    };
    const Picture picture = settled(view, how);
    const Picture voxels = voxelsAlone(view, pixels);
    EXPECT_EQ(picture.depth, voxels.depth);
    EXPECT_EQ(picture.rgba, voxels.rgba);
    ASSERT_TRUE(picture.frame.sourceError);
    EXPECT_EQ(picture.frame.sourceError->message, "hills.ply: gone");
    EXPECT_EQ(picture.frame.sourceBytes, 0U);

    // one that contradicts itself
    how.source = [](const std::stop_token&) {
        voxels::TriangleModel damaged = _hills;
        damaged.colours.pop_back();
        return core::Result<voxels::TriangleModel>(std::move(damaged));
    };
    const Picture other = settled(view, how);
    EXPECT_EQ(other.rgba, voxels.rgba);
    EXPECT_TRUE(other.frame.sourceError);

    // one that memory doesn't hold
    how.source = [](const std::stop_token&) -> core::Result<voxels::TriangleModel> {
        throw std::bad_alloc();
    };
    const Picture huge = settled(view, how);
    EXPECT_EQ(huge.rgba, voxels.rgba);
    ASSERT_TRUE(huge.frame.sourceError);
    EXPECT_EQ(huge.frame.sourceError->code, core::ErrorCode::resourceLimit);
}

TEST_F(SourceScenes, readNoSourceThatNobodyNeeds)
{
    const hierarchy::View view = lookingAt({3, 0, 0}, {0, 0, 0}, 200, 150);
    HybridSettings how = settings(boundAt(view, 1.0));
    how.source = [](const std::stop_token&) -> core::Result<voxels::TriangleModel> {
        ADD_FAILURE() << "voxels are fine enough";
        return voxels::TriangleModel();
    };
    const Picture picture = settled(view, how);
    EXPECT_GT(voxelPixels(picture), 1000U);
}

TEST_F(SourceScenes, makeDoWithTheRoomThatThereIs)
{
    render::RendererOptions small = sourceOptions();
    small.poolBytes = 3 * small.slabBytes;
    const hierarchy::View view = lookingAt({1.7, -0.4, 0.3}, {0, 0, 0}, 200, 150);
    const Picture picture = settled(view, settings(1e-2), small);
    EXPECT_TRUE(picture.frame.sourceIsFull);
    EXPECT_LE(double(picture.frame.sourceBytes), 0.75 * double(small.poolBytes));
    EXPECT_GT(picture.frame.drawn.triangles, 0U);
    EXPECT_GT(voxelPixels(picture), 100U);
    const Picture source = settled(view, settings(1e-3));
    const Picture voxels = voxelsAlone(view, 1e-2);
    for (std::size_t i = 0; i < picture.depth.size(); ++i)
        ASSERT_TRUE(picture.depth[i] > 0 || !(source.depth[i] > 0 && voxels.depth[i] > 0)) << i;

    // looking elsewhere, what was near leaves for what is
    const auto shown = renderer(render::voxelDomain(lattice()), small);
    auto scene = HybridScene::create(*shown, nullptr, _store, jobs(), settings(boundAt(view, 0.4)));
    ASSERT_TRUE(scene) << scene.error().message;
    for (const double side : {1.0, -1.0, 1.0}) {
        const hierarchy::View close =
            lookingAt({1.2 * side, 0.1, 0.1}, {0.9 * side, 0, 0}, 200, 150);
        const auto frame = scene->settle(close, look());
        ASSERT_TRUE(frame) << frame.error().message;
        EXPECT_GT(frame->meshBlocks, 0U);
        EXPECT_GT(frame->drawn.triangles, 0U) << side;
        EXPECT_LE(double(frame->sourceBytes), 0.75 * double(small.poolBytes));
    }
}

TEST_F(SourceScenes, fadeAsAllElseDoes)
{
    const auto at = [](double away) { return lookingAt({away, -0.4, 0.3}, {0.5, 0, 0.1}, 80, 60); };
    const double pixels = boundAt(at(2.4), 0.75, _coarse);
    const auto shown = renderer(render::voxelDomain(_coarse->model().lattice), sourceOptions());
    // what is asked for is there with the next frame, however fast the machine is
    auto scene = HybridScene::create(
        *shown,
        nullptr,
        _coarse,
        core::makeJobs(core::JobsBackend::inlined, 1),
        settings(pixels, 0.1));
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_TRUE(scene->settle(at(2.4), look()));
    std::size_t changes = 0;
    std::size_t blocks = 0;
    std::size_t fading = 0;
    double time = 0;
    bool isComplete = false;
    // flies in, then stays until all is there
    for (int i = 0; i < 300 && !(i > 15 && isComplete); ++i) {
        time += 1.0 / 30;
        const auto frame = scene->frame(at(std::max(2.4 - 0.06 * i, 1.5)), look(), time);
        ASSERT_TRUE(frame) << frame.error().message;
        changes += frame->meshBlocks != blocks ? 1U : 0U;
        blocks = frame->meshBlocks;
        fading += frame->drawn.cellsFading;
        isComplete = frame->isComplete;
    }
    const hierarchy::View last = at(1.5);
    const std::vector<float> depth = *shown->readDepth();
    const Picture source = settled(last, settings(1e-3), sourceOptions(), look(), _coarse);
    const Picture voxels = voxelsAlone(last, pixels, _coarse);
    std::size_t holes = 0;
    for (std::size_t i = 0; i < depth.size(); ++i)
        holes += source.depth[i] > 0 && voxels.depth[i] > 0 && !(depth[i] > 0) ? 1U : 0U;
    EXPECT_EQ(holes, 0U);
    EXPECT_TRUE(isComplete);
    EXPECT_GT(changes, 0U);
    EXPECT_GT(fading, 0U);
    EXPECT_GT(voxelPixels(pictureOf(*shown, {})), 0U) << "farther away";
    EXPECT_GT(blocks, 0U);
}

TEST_F(SourceScenes, refuseARendererOfAnotherDomain)
{
    const auto shown = renderer({.origin = {0, 0, 0}, .edge = 2}, sourceOptions());
    const auto scene = HybridScene::create(*shown, nullptr, _store, jobs(), settings(1));
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().code, core::ErrorCode::usage);
    EXPECT_FALSE(HybridScene::create(*shown, nullptr, nullptr, jobs(), settings(1)));
}

} // namespace
} // namespace isofront::test

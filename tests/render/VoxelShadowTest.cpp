#include "render/support/VoxelFixture.h"
#include "support/Random.h"

#include <isofront/voxels/ChunkStreamer.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::test {
namespace {

const hierarchy::Domain kDomain{.edge = 128.0};
const voxels::VoxelLattice kLattice{.edge = 1.0, .resolution = 128, .levels = 1};

/// Voxels with all faces and one normal, from low to high.
void addBlock(
    std::vector<voxels::Voxel>& voxels,
    std::array<std::uint32_t, 3> low,
    std::array<std::uint32_t, 3> high)
{
    for (std::uint32_t z = low[2]; z <= high[2]; ++z)
        for (std::uint32_t y = low[1]; y <= high[1]; ++y)
            for (std::uint32_t x = low[0]; x <= high[0]; ++x)
                voxels.push_back(
                    {voxels::packPlace(x, y, z, voxels::kAllFaces), voxels::packNormal({0, 0, 1})});
}

/// A plate that hangs over the ground, and the ground, if it is of voxels.
Chunk plate(bool withGround)
{
    Chunk chunk;
    if (withGround)
        addBlock(chunk.voxels, {4, 4, 29}, {123, 123, 29});
    addBlock(chunk.voxels, {50, 50, 50}, {73, 73, 51});
    return chunk;
}
const glm::dvec3 kLow(50, 50, 50);
const glm::dvec3 kHigh(74, 74, 52);

render::Scene sunny()
{
    render::Scene scene;
    scene.sunDirection = {-0.5, 0.3, 0.8};
    scene.terrain.haze = 0;
    scene.shadowDistance = 200;
    scene.antialias = false;
    return scene;
}

int greyAt(const core::Image& image, int x, int y)
{
    const auto* pixel = image.pixel(x, y);
    return pixel[0] + pixel[1] + pixel[2];
}

glm::dvec3 anyDirection(std::mt19937_64& random)
{
    for (;;) {
        const auto share = [&] { return tests::uniform(random, -1, 1); };
        const double x = share();
        const double y = share();
        const glm::dvec3 inCube(x, y, share());
        const double length = glm::length(inCube);
        if (length > 0.1 && length < 1)
            return inCube / length;
    }
}

class VoxelShadows : public VoxelFixture {};

TEST_F(VoxelShadows, fallWhereTheSunIsHidden)
{
    render::RendererOptions wanted = options();
    wanted.shadowMapSize = 1024;
    const render::Scene scene = sunny();
    const glm::dvec3 sun = glm::normalize(scene.sunDirection);
    const double texel = 2 * 0.65 * scene.shadowDistance / wanted.shadowMapSize;
    const hierarchy::View view = lookingAt({64, -30, 120}, {66, 60, 30}, 120, 90);
    for (const bool voxelGround : {false, true}) {
        const auto shown = renderer(kDomain, wanted);
        if (!voxelGround)
            show(*shown, showing(cut(sheet(8, [](double, double) { return 30.0 / 128; }), 2, 1)));
        const Chunk chunk = plate(voxelGround);
        Chunk ground = plate(true);
        ground.key.x = 1; // only so that it has another name
        std::erase_if(ground.voxels, [](const voxels::Voxel& voxel) { return voxel.z() > 29; });
        add(*shown, std::array{chunk, ground});
        const VoxelDraw draw{chunk.key};
        const VoxelDraw groundDraw{ground.key};
        for (const VoxelWay way : kWays) {
            const VoxelShot with = shootVoxels(
                *shown, view, {.lattice = kLattice, .draws = {&draw, 1}, .way = way}, scene);
            EXPECT_EQ(with.stats.voxels.shadowVoxels, chunk.voxels.size());
            voxels::VoxelLattice moved = kLattice;
            moved.origin.x = -256;
            render::VoxelScene bare{.lattice = moved, .way = way};
            if (voxelGround)
                bare.draws = {&groundDraw, 1};
            const VoxelShot without = shootVoxels(*shown, view, bare, scene);
            std::size_t dark = 0;
            std::size_t bright = 0;
            for (int y = 0; y < view.height; ++y)
                for (int x = 0; x < view.width; ++x) {
                    // Where the ray meets the ground, if it doesn't meet the plate.
                    const glm::dvec3 ray = pixelRay(view, x, y);
                    const glm::dvec3 at = view.eye + (view.eye.z - 30) / -ray.z * ray;
                    const auto pixel = static_cast<std::size_t>(y * view.width + x);
                    if (ray.z >= 0 || std::min(at.x, at.y) < 8 || std::max(at.x, at.y) > 120 ||
                        std::abs(with.depth[pixel] - without.depth[pixel]) >
                            1e-3F * without.depth[pixel])
                        continue;
                    // Where its ray to the sun meets the plate's lower and upper side.
                    const auto inside = [&](double more) {
                        const glm::dvec3 a = (kLow - more - at) / sun;
                        const glm::dvec3 b = (kHigh + more - at) / sun;
                        const glm::dvec3 from = glm::min(a, b);
                        const glm::dvec3 to = glm::max(a, b);
                        return std::max({from.x, from.y, from.z}) < std::min({to.x, to.y, to.z});
                    };
                    const double blur = 4 * texel;
                    const int now = greyAt(with.image, x, y);
                    const int before = greyAt(without.image, x, y);
                    if (inside(-0.99)) {
                        const glm::dvec3 middle = at + (51 - at.z) / sun.z * sun;
                        if (std::min(middle.x - kLow.x, middle.y - kLow.y) < blur ||
                            std::min(kHigh.x - middle.x, kHigh.y - middle.y) < blur)
                            continue;
                        ++dark;
                        ASSERT_LT(now, 0.7 * before) << x << " " << y;
                    } else if (!inside(blur)) {
                        ++bright;
                        ASSERT_NEAR(now, before, 3) << x << " " << y;
                    }
                }
            EXPECT_GT(dark, 100U);
            EXPECT_GT(bright, 1000U);
        }
    }
}

TEST_F(VoxelShadows, neverSpotAnEvenSlope)
{
    // However the slope lies, and however low the sun stands over it.
    std::mt19937_64 random(11);
    render::RendererOptions wanted = options();
    wanted.shadowMapSize = 1024;
    const glm::dvec3 middle(64);
    for (int trial = 0; trial < tests::trials(5); ++trial) {
        const glm::dvec3 out = anyDirection(random);
        const glm::dvec3 along = glm::normalize(glm::cross(out, anyDirection(random)));
        const double sine = trial % 2 == 0 ? 0.05 : 0.3;
        render::Scene scene = sunny();
        scene.sunDirection = sine * out + std::sqrt(1 - sine * sine) * along;
        scene.up = scene.sunDirection; // or the sun would have set where it is below the ground
        scene.shadowDistance = 400;    // texels of half a voxel
        const double thick = std::max({std::abs(out.x), std::abs(out.y), std::abs(out.z)});
        Chunk slope;
        for (std::uint32_t z = 24; z < 104; ++z)
            for (std::uint32_t y = 24; y < 104; ++y)
                for (std::uint32_t x = 24; x < 104; ++x)
                    if (std::abs(glm::dot(glm::dvec3(x, y, z) + 0.5 - middle, out)) <= 0.5 * thick)
                        slope.voxels.push_back(
                            {voxels::packPlace(x, y, z, voxels::kAllFaces),
                             voxels::packNormal(out)});
        const auto shown = renderer(kDomain, wanted);
        add(*shown, {&slope, 1});
        // Pixels are small, so that the deepest notches between voxels are seen, too.
        hierarchy::View view = lookingAt(middle + 100.0 * out + 30.0 * along, middle, 160, 160);
        view.up = along;
        view.verticalFieldOfView = 0.3;
        const VoxelDraw draw{slope.key};
        const render::VoxelScene voxels{.lattice = kLattice, .draws = {&draw, 1}};
        const VoxelShot lit = shootVoxels(*shown, view, voxels, scene);
        EXPECT_EQ(lit.stats.voxels.shadowVoxels, slope.voxels.size());
        scene.shadowDistance = 0;
        const VoxelShot bare = shootVoxels(*shown, view, voxels, scene);
        EXPECT_EQ(bare.stats.voxels.shadowVoxels, 0U);
        std::size_t seen = 0;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                seen += lit.depth[static_cast<std::size_t>(y * view.width + x)] > 0 ? 1U : 0U;
                ASSERT_NEAR(greyAt(lit.image, x, y), greyAt(bare.image, x, y), 6)
                    << x << " " << y << " trial " << trial;
            }
        EXPECT_GT(seen, 20000U);
    }
}

TEST_F(VoxelShadows, areThoseOfAMeshOfTheSameShape)
{
    // A ball over a ground of triangles, once of triangles and once of voxels.
    const glm::dvec3 centre(64, 64, 60);
    constexpr double kRadius = 18;
    Chunk ball;
    for (std::uint32_t z = 40; z < 80; ++z)
        for (std::uint32_t y = 44; y < 84; ++y)
            for (std::uint32_t x = 44; x < 84; ++x) {
                const glm::dvec3 out = glm::dvec3(x, y, z) + 0.5 - centre;
                // so that the outer faces lie about where the triangles do
                if (std::abs(glm::length(out) - (kRadius - 0.7)) < 0.8)
                    ball.voxels.push_back(
                        {voxels::packPlace(x, y, z, voxels::kAllFaces), voxels::packNormal(out)});
            }
    const auto ground = cut(sheet(8, [](double, double) { return 30.0 / 128; }), 2, 1);
    const auto meshBall = cut(sphere(centre / 128.0, kRadius / 128, 24), 2, 1, 1);
    render::RendererOptions wanted = options();
    wanted.shadowMapSize = 1024;
    const auto ofVoxels = renderer(kDomain, wanted);
    show(*ofVoxels, showing(ground));
    add(*ofVoxels, {&ball, 1});
    const auto ofTriangles = renderer(kDomain, wanted);
    std::vector<surface::ShownCell> both = ground;
    both.insert(both.end(), meshBall.begin(), meshBall.end());
    show(*ofTriangles, showing(both));
    const hierarchy::View view = lookingAt({64, -30, 120}, {64, 64, 40}, 120, 90);
    const VoxelDraw draw{ball.key};
    const VoxelShot voxels =
        shootVoxels(*ofVoxels, view, {.lattice = kLattice, .draws = {&draw, 1}}, sunny());
    const VoxelShot mesh = shootVoxels(*ofTriangles, view, {}, sunny());
    const auto empty = renderer(kDomain, wanted);
    show(*empty, showing(ground));
    const VoxelShot bare = shootVoxels(*empty, view, {}, sunny());
    std::size_t shaded = 0;
    std::size_t odd = 0;
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const auto pixel = static_cast<std::size_t>(y * view.width + x);
            if (bare.depth[pixel] != mesh.depth[pixel] || bare.depth[pixel] != voxels.depth[pixel])
                continue;
            const int light = greyAt(bare.image, x, y);
            const bool inMesh = greyAt(mesh.image, x, y) < 0.85 * light;
            const bool inVoxels = greyAt(voxels.image, x, y) < 0.85 * light;
            shaded += inMesh ? 1U : 0U;
            odd += inMesh == inVoxels ? 0U : 1U;
        }
    EXPECT_GT(shaded, 200U);
    EXPECT_LT(odd, shaded / 10); // the rim, where a voxel sticks out
}

TEST_F(VoxelShadows, ofStreamedChunksFallFromOutsideTheView)
{
    // Only an eighth of the model is in view, or two.
    const HillyModel model(300);
    render::RendererOptions wanted = options();
    wanted.voxelPoolBytes = 24U << 20U;
    const hierarchy::Domain domain{.origin = glm::dvec3(-2), .edge = 4};
    const auto shown = renderer(domain, wanted);
    auto streamer = voxels::ChunkStreamer::create(
        model.store,
        {.voxelPixels = 0.5, .occlusion = false, .cacheBytes = 24U << 20U},
        core::makeJobs(core::JobsBackend::inlined));
    ASSERT_TRUE(streamer);
    render::Scene scene = sunny();
    scene.shadowDistance = 8;
    hierarchy::View view = lookingAt({0.5, -4, 0.5}, {0.5, 0, 0.5}, 60, 40);
    view.verticalFieldOfView = 0.1;
    bool isComplete = false;
    for (std::uint64_t number = 1; number < 20 && !isComplete; ++number) {
        const voxels::ChunkFrame& frame = (*streamer)->update(
            voxels::perspectiveView(
                view.eye,
                view.forward,
                view.up,
                view.verticalFieldOfView,
                view.width,
                view.height,
                shown->defaultNearPlane()),
            number,
            number - 1);
        ASSERT_TRUE(shown->apply(frame));
        const auto sun = shown->sunlight(view, scene);
        ASSERT_TRUE(sun);
        const auto casters = (*streamer)->casters(sun->space, sun->texel);
        const render::VoxelScene voxels{
            .lattice = model.lattice,
            .placed = frame.draws,
            .tree = &(*streamer)->tree(),
            .casters = casters,
            .frame = number};
        const auto drawn = shown->draw(view, scene, voxels);
        ASSERT_TRUE(drawn) << drawn.error().message;
        ASSERT_TRUE(shown->finish());
        isComplete = frame.isComplete;
        if (!isComplete)
            continue;
        // What is in view casts shadows as it is drawn, the rest by the root.
        EXPECT_GT(drawn->voxels.shadowVoxels, drawn->voxels.voxels);
        for (const voxels::ChunkDraw& draw : frame.draws)
            EXPECT_TRUE(std::ranges::any_of(
                casters, [&](const voxels::ChunkDraw& caster) { return caster.key == draw.key; }));
        EXPECT_TRUE(std::ranges::any_of(casters, [](const voxels::ChunkDraw& caster) {
            return caster.key.level > 0 && caster.octants != 0xff;
        }));
    }
    EXPECT_TRUE(isComplete);
    scene.look = render::Look::studio;
    EXPECT_FALSE(shown->sunlight(view, scene));
}

} // namespace
} // namespace isofront::test

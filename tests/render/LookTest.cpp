#include "render/support/RenderFixture.h"

#include <glm/geometric.hpp>

namespace isofront::test {
namespace {

constexpr double kEdge = 4096.0;

glm::dvec3 meanColour(const core::Image& image)
{
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        sum += glm::dvec3(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]);
    return sum / (static_cast<double>(image.rgba.size()) / 4.0);
}

class Looks : public RenderFixture {
protected:
    /// A level plain, seen from above.
    Shot plain(double height, const render::Scene& scene)
    {
        const hierarchy::Domain domain{.edge = kEdge};
        const auto shown = renderer(domain);
        show(*shown, showing(cut(sheet(16, [&](double, double) { return height / kEdge; }), 2, 1)));
        return shoot(
            *shown, lookingAt({2000, 2000, height + 100}, {2050, 2060, height}, 64, 64), scene);
    }
};

TEST_F(Looks, growGrassBelowAndSnowAbove)
{
    const glm::dvec3 low = meanColour(plain(100, {}).image);
    const glm::dvec3 high = meanColour(plain(2400, {}).image);
    EXPECT_GT(low.y, low.z + 10) << "grass is not blue";
    EXPECT_GT(high.z, low.z + 60) << "snow is bright";
}

TEST_F(Looks, countHeightsFromTheBase)
{
    render::Scene raised;
    raised.terrain.baseHeight = -2300;
    const glm::dvec3 asHigh = meanColour(plain(100, raised).image);
    const glm::dvec3 high = meanColour(plain(2400, {}).image);
    EXPECT_NEAR(asHigh.z, high.z, 12.0);
}

TEST_F(Looks, areDarkerAtDuskAndFadeIntoHaze)
{
    render::Scene dusk;
    dusk.sunDirection = {1.0, 0.0, 0.02};
    const glm::dvec3 day = meanColour(plain(100, {}).image);
    EXPECT_LT(glm::length(meanColour(plain(100, dusk).image)), 0.7 * glm::length(day));
    render::Scene mist;
    mist.terrain.haze = 100;
    EXPECT_GT(meanColour(plain(100, mist).image).z, day.z + 20);
}

TEST_F(Looks, tintCapsWhereAllThreeVerticesAreCaps)
{
    const hierarchy::Domain domain{.edge = kEdge};
    auto cells = cut(sheet(8, [](double, double) { return 0.5; }), 1, 1);
    auto capped = std::make_shared<extractor::CellMesh>(*cells[0].mesh());
    for (extractor::CellVertex& vertex : capped->vertices)
        vertex.flags = extractor::CellVertex::cap;
    render::Scene scene{.look = render::Look::studio};
    scene.studio.surface = {0.1F, 0.1F, 0.6F};
    scene.studio.cap = {0.6F, 0.1F, 0.1F};
    const hierarchy::View view =
        lookingAt({2000, 2000, 0.5 * kEdge + 900}, {2000, 2100, 0.5 * kEdge}, 64, 64);
    const auto shown = renderer(domain);
    show(*shown, showing({cells[0]}));
    const glm::dvec3 open = meanColour(shoot(*shown, view, scene).image);
    EXPECT_GT(open.z, open.x + 40);
    surface::Delta step = showing({surface::ShownCell(cells[0].id, capped)}, 2);
    step.removed = {cells[0].id};
    show(*shown, step);
    const glm::dvec3 closed = meanColour(shoot(*shown, view, scene).image);
    EXPECT_GT(closed.x, closed.z + 40);
}

TEST_F(Looks, castTheShadowOfABallWhereTheSunSaysSo)
{
    const hierarchy::Domain domain{.edge = kEdge};
    const glm::dvec3 ball(0.45, 0.5, 0.40);
    auto cells = cut(sheet(16, [](double, double) { return 0.25; }), 3, 1);
    for (const surface::ShownCell& cell : cut(sphere(ball, 0.05, 24), 2, 2, 1))
        cells.push_back(cell);
    const auto shown = renderer(domain);
    show(*shown, showing(cells));
    render::Scene scene;
    scene.sunDirection = {0.4, -0.3, 1.0};
    scene.antialias = false;
    // Straight down from above the ball's shadow.
    const glm::dvec3 centre = kEdge * (ball - glm::dvec3(0.4, -0.3, 1.0) * (ball.z - 0.25));
    const hierarchy::View view = lookingAt(centre + glm::dvec3(1, 0, 1200), centre, 160, 160);
    const Shot lit = shoot(*shown, view, scene);
    scene.shadowDistance = 0;
    const Shot plain = shoot(*shown, view, scene);
    EXPECT_GT(lit.stats.shadowTriangles, 0U);
    EXPECT_EQ(plain.stats.shadowTriangles, 0U);
    EXPECT_EQ(lit.depth, plain.depth);
    const glm::dvec3 sun = glm::normalize(scene.sunDirection);
    int dark = 0;
    for (int y = 0; y < 160; ++y) {
        for (int x = 0; x < 160; ++x) {
            const glm::dvec3 ray = pixelRay(view, x, y);
            const double length = (0.25 * kEdge - view.eye.z) / ray.z;
            const double shownLength =
                shown->defaultNearPlane() / static_cast<double>(lit.depthAt(x, y));
            if (shownLength < 0.99 * length)
                continue; // the ball itself
            const glm::dvec3 hit = view.eye + ray * length;
            // How far the way from there to the sun passes by the ball's centre.
            const glm::dvec3 toBall = kEdge * ball - hit;
            const double miss = glm::length(toBall - glm::dot(toBall, sun) * sun);
            const int before = plain.image.pixel(x, y)[1];
            const int now = lit.image.pixel(x, y)[1];
            if (miss > 0.05 * kEdge + 8) {
                ASSERT_NEAR(now, before, 1) << x << " " << y;
            } else if (miss < 0.05 * kEdge - 12) {
                ASSERT_LT(now, before - 20) << x << " " << y;
                ++dark;
            }
        }
    }
    EXPECT_GT(dark, 500);
}

TEST_F(Looks, keepTheShadowMapForSomeFramesIfAsked)
{
    const hierarchy::Domain domain{.edge = kEdge};
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.1, 24), 3, 1)));
    const hierarchy::View view = lookingAt({1000, 1000, 2300}, glm::dvec3(0.5 * kEdge));
    render::Scene scene;
    const Shot first = shoot(*shown, view, scene);
    scene.shadowInterval = 3;
    std::vector<std::uint64_t> drawn;
    for (int i = 0; i < 7; ++i) {
        const Shot shot = shoot(*shown, view, scene);
        EXPECT_EQ(shot, first);
        drawn.push_back(shot.stats.shadowTriangles > 0 ? 1 : 0);
    }
    EXPECT_EQ(drawn, (std::vector<std::uint64_t>{0, 0, 1, 0, 0, 1, 0}));
}

TEST_F(Looks, areMadeForKindsOfTerrain)
{
    const render::TerrainLook canyon = render::terrainLook("canyon");
    EXPECT_GT(canyon.rock.x, 2.0F * canyon.rock.z);
    EXPECT_EQ(render::terrainLook("alpine").rock, render::TerrainLook{}.rock);
    EXPECT_EQ(render::terrainLook("no such").rock, render::TerrainLook{}.rock);
}

TEST_F(Looks, softenStairStepsOnlyWhereThereAreEdges)
{
    const hierarchy::Domain domain{.edge = kEdge};
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 48), 3, 1)));
    const hierarchy::View view = lookingAt({-2500, -1500, 3500}, glm::dvec3(0.5 * kEdge));
    render::Scene scene{.look = render::Look::studio};
    const Shot soft = shoot(*shown, view, scene);
    scene.antialias = false;
    const Shot hard = shoot(*shown, view, scene);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < soft.image.rgba.size(); i += 4) {
        changed += soft.image.rgba[i] != hard.image.rgba[i] ? 1U : 0U;
    }
    EXPECT_EQ(soft.depth, hard.depth);
    EXPECT_GT(changed, 50U);
    EXPECT_LT(changed, soft.depth.size() / 10);
}

TEST_F(Looks, tellWhatEachPassCost)
{
    const hierarchy::Domain domain{.edge = kEdge};
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 24), 3, 1)));
    const hierarchy::View view = lookingAt({-2500, -1500, 3500}, glm::dvec3(0.5 * kEdge));
    render::FrameStats stats;
    for (int i = 0; i < 4; ++i) {
        const auto drawn = shown->draw(view, {});
        ASSERT_TRUE(drawn);
        stats = *drawn;
    }
    EXPECT_GT(stats.gpuMilliseconds, 0.0);
    EXPECT_GT(stats.cpuMilliseconds, 0.0);
    EXPECT_EQ(stats.deviceBytes, device->allocatedBytes());
    const auto passes = shown->finish();
    ASSERT_TRUE(passes);
    EXPECT_GE(passes->size(), 2U);
}

} // namespace
} // namespace isofront::test

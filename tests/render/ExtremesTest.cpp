#include "render/support/RenderFixture.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::test {
namespace {

class Extremes : public RenderFixture {
protected:
    hierarchy::Domain domain{.edge = 1000};
};

bool isEmpty(const std::vector<float>& depth)
{
    return std::all_of(depth.begin(), depth.end(), [](float d) { return d <= 0; });
}

TEST_F(Extremes, oddPicturesAreDrawnInTurn)
{
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 16), 2, 1)));
    for (const auto& [width, height] :
         {std::pair{1, 1}, std::pair{1279, 719}, std::pair{3, 200}, std::pair{1, 1}}) {
        for (const bool antialias : {true, false}) {
            render::Scene scene;
            scene.antialias = antialias;
            hierarchy::View view = lookingAt({500, -500, 500}, glm::dvec3(500), width, height);
            view.verticalFieldOfView = 0.5;
            const Shot shot = shoot(*shown, view, scene);
            EXPECT_GT(shot.depthAt(width / 2, height / 2), 0.0F);
        }
    }
}

TEST_F(Extremes, anEmptySceneShowsSkyOrWall)
{
    const auto shown = renderer(domain);
    for (const render::Look look : {render::Look::terrain, render::Look::studio}) {
        const Shot shot = shoot(*shown, lookingAt({0, 0, 0}, {1, 1, 0.2}), {.look = look});
        EXPECT_TRUE(isEmpty(shot.depth));
        EXPECT_EQ(shot.stats.triangles, 0U);
        for (std::size_t i = 0; i < shot.image.rgba.size(); ++i)
            ASSERT_GT(shot.image.rgba[i], 10);
    }
}

TEST_F(Extremes, thereIsNothingToReadBeforeAPicture)
{
    const auto shown = renderer(domain);
    EXPECT_EQ(shown->readImage().error().code, core::ErrorCode::usage);
    EXPECT_EQ(shown->readDepth().error().code, core::ErrorCode::usage);
    EXPECT_TRUE(shown->finish()->empty());
}

TEST_F(Extremes, anEyeInsideSeesTheInnerSideOnlyWhereItIsAsked)
{
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 24), 3, 1)));
    const hierarchy::View view = lookingAt(glm::dvec3(500), {700, 500, 520});
    EXPECT_TRUE(isEmpty(shoot(*shown, view).depth));
    const Shot inside = shoot(*shown, view, {.look = render::Look::studio});
    for (const float depth : inside.depth) {
        const double along = shown->defaultNearPlane() / static_cast<double>(depth);
        ASSERT_LE(along, 301.0);
        ASSERT_GE(along, 150.0);
    }
    EXPECT_TRUE(
        isEmpty(shoot(*shown, view, {.look = render::Look::studio, .twoSided = false}).depth));
}

TEST_F(Extremes, anEyeFarAwayOrOnTheSurfaceBreaksNothing)
{
    const auto shown = renderer(domain);
    show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 16), 3, 1)));
    for (const double distance : {1e4, 1e7, 1e12, 1e18}) {
        const hierarchy::View view =
            lookingAt(glm::dvec3(500) + distance * glm::dvec3(0.6, 0.0, 0.8), glm::dvec3(500));
        const Shot shot = shoot(*shown, view);
        for (const float depth : shot.depth)
            ASSERT_TRUE(depth >= 0.0F && depth < 1.0F);
    }
    shoot(*shown, lookingAt({500, 200, 500}, {500, 300, 510}));
    shoot(*shown, lookingAt({500, 200.0001, 500}, {500, 199, 500}));
    // A telescope still finds it at 10^5 edges.
    hierarchy::View far = lookingAt({500, -3.2e7, 500}, glm::dvec3(500));
    far.verticalFieldOfView = 3e-5;
    const Shot shot = shoot(*shown, far);
    EXPECT_NEAR(
        static_cast<double>(shot.depthAt(80, 60)),
        shown->defaultNearPlane() / (3.2e7 + 200),
        1e-13);
}

TEST_F(Extremes, viewsThatMakeNoSenseAreRefused)
{
    const auto shown = renderer(domain);
    const hierarchy::View good = lookingAt({0, 0, 0}, {1, 0, 0});
    std::vector<hierarchy::View> bad(6, good);
    bad[0].eye.x = std::numeric_limits<double>::quiet_NaN();
    bad[1].forward = glm::dvec3(0.0);
    bad[2].up = bad[2].forward;
    bad[3].verticalFieldOfView = 4;
    bad[4].width = 0;
    bad[5].height = 1'000'000;
    for (const hierarchy::View& view : bad) {
        const auto stats = shown->draw(view, {});
        ASSERT_FALSE(stats);
        EXPECT_EQ(stats.error().code, core::ErrorCode::usage);
    }
    EXPECT_TRUE(shown->draw(good, {}));
}

TEST_F(Extremes, optionsThatMakeNoSenseAreRefused)
{
    std::vector<render::RendererOptions> bad(6, smallOptions());
    bad[0].width = 0;
    bad[1].height = -5;
    bad[2].framesInFlight = 0;
    bad[3].poolBytes = 100;
    bad[4].slabBytes = 0;
    bad[5].poolBytes = 1ULL << 40U;
    for (const render::RendererOptions& options : bad) {
        const auto created = render::Renderer::create(*device, domain, options);
        ASSERT_FALSE(created);
        EXPECT_EQ(created.error().code, core::ErrorCode::usage);
    }
}

TEST_F(Extremes, obliqueAndMirroredDomainsShowTheirFront)
{
    for (const double sign : {1.0, -1.0}) {
        hierarchy::Domain oblique{.origin = {-10, 20, 30}, .edge = 64};
        oblique.worldFromField.linear =
            glm::dmat3(0.7 * sign, 0.1, 0, 0, 0.9, 0.2, 0.1 * sign, 0, 2.5);
        oblique.worldFromField.translation = {1e5, 2e5, -7};
        const auto shown = renderer(oblique);
        show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 32), 4, 6)));
        const glm::dvec3 centre = oblique.worldFromField.point(oblique.origin + glm::dvec3(32.0));
        const glm::dvec3 eye = centre + glm::dvec3(150, -90, 60);
        const Shot shot = shoot(*shown, lookingAt(eye, centre, 161, 121));
        // Along the middle ray, in field space, the sphere is a sphere.
        const glm::dvec3 from = oblique.worldFromField.inverse().point(eye);
        const glm::dvec3 to = oblique.worldFromField.inverse().point(centre);
        const double hit = 1.0 - 0.3 * 64 / glm::length(to - from);
        const double distance = hit * glm::length(centre - eye);
        const double expected = shown->defaultNearPlane() / distance;
        EXPECT_NEAR(static_cast<double>(shot.depthAt(80, 60)), expected, 2e-3 * expected) << sign;
    }
}

TEST_F(Extremes, aTinyAndAHugeDomainLookAlike)
{
    std::vector<std::vector<float>> depths;
    for (const double edge : {0x1p-40, 0x1p0, 0x1p40}) {
        const hierarchy::Domain scaled{.edge = edge};
        const auto shown = renderer(scaled);
        show(*shown, showing(cut(sphere(glm::dvec3(0.5), 0.3, 16), 3, 2)));
        const hierarchy::View view =
            lookingAt(edge * glm::dvec3(1.5, 0.25, 0.75), edge * glm::dvec3(0.5));
        depths.push_back(shoot(*shown, view, {.look = render::Look::studio}).depth);
        EXPECT_FALSE(isEmpty(depths.back()));
        EXPECT_EQ(depths.back(), depths.front()) << edge;
    }
}

} // namespace
} // namespace isofront::test

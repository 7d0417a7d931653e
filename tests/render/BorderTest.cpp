#include "render/support/RenderFixture.h"

#include <glm/geometric.hpp>

#include <cmath>
#include <random>

namespace isofront::test {
namespace {

constexpr double kEdge = 16384.0;
constexpr double kRadius = 0.3;

/// Multiples of 2^-10, so that they stay exact beside any of the origins below.
glm::dvec3 rounded(const glm::dvec3& p)
{
    return {
        std::round(p.x * 1024) / 1024,
        std::round(p.y * 1024) / 1024,
        std::round(p.z * 1024) / 1024};
}

glm::dvec3 randomDirection(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return glm::normalize(glm::dvec3(x, y, normal(random)));
}

render::Scene onMagenta()
{
    render::Scene scene;
    scene.backdrop = glm::vec3(1, 0, 1);
    scene.antialias = false;
    return scene;
}

bool isMagenta(const core::Image& image, int x, int y)
{
    const std::uint8_t* pixel = image.pixel(x, y);
    return pixel[0] == 255 && pixel[1] == 0 && pixel[2] == 255;
}

class Border : public RenderFixture {};

TEST_F(Border, letsNoBackgroundThroughAClosedSphereAtAnyOrigin)
{
    const GridMesh mesh = sphere(glm::dvec3(0.5), kRadius, 48);
    const surface::Delta delta = showing(cut(mesh, 7, 1));
    // How far the facets lie inside of the sphere at most, snapping included, as a fraction of its
    // radius; and how far snapping may take a vertex outside.
    const double snap = std::ldexp(0.9, kExponent - hierarchy::kGridBits) / kRadius;
    const double sag = 1.0 - std::cos(0.75 * 1.5708 / 48) + snap;
    for (const double offset : {0.0, 6.4e6}) {
        const hierarchy::Domain domain{
            .origin = glm::dvec3(offset, offset, -offset), .edge = kEdge};
        const glm::dvec3 centre = domain.origin + 0.5 * kEdge;
        const auto shown = renderer(domain);
        show(*shown, delta);
        std::mt19937 random(17);
        std::size_t inside = 0;
        for (int round = 0; round < 60; ++round) {
            const double distance = kEdge * kRadius * (1.02 + 0.06 * round);
            const glm::dvec3 eye = centre + distance * randomDirection(random);
            const glm::dvec3 target = centre + 0.3 * kRadius * kEdge * randomDirection(random);
            const hierarchy::View view = lookingAt(eye, target);
            const Shot shot = shoot(*shown, view, onMagenta());
            const double pixel = 1.0 / view.pixelsPerUnit();
            const double outer = std::asin((1 + snap) * kRadius * kEdge / distance);
            const double inner = std::asin((1 - sag) * kRadius * kEdge / distance) - pixel;
            for (int y = 0; y < view.height; ++y) {
                for (int x = 0; x < view.width; ++x) {
                    const double angle = std::acos(glm::dot(
                        glm::normalize(pixelRay(view, x, y)), glm::normalize(centre - eye)));
                    const bool background = shot.depthAt(x, y) <= 0;
                    ASSERT_EQ(background, isMagenta(shot.image, x, y));
                    ASSERT_FALSE(angle < inner && background) << "hole at " << x << ", " << y;
                    ASSERT_FALSE(angle > outer + pixel && !background);
                    inside += angle < inner ? 1U : 0U;
                }
            }
        }
        EXPECT_GT(inside, 100'000U);
    }
}

TEST_F(Border, drawsTheSamePixelsHoweverTheMeshIsCut)
{
    const hierarchy::Domain domain{.origin = {6.4e6, -6.4e6, 1e5}, .edge = kEdge};
    const GridMesh mesh = sphere({0.45, 0.5, 0.55}, kRadius, 40);
    const auto shown = renderer(domain);
    std::mt19937 random(23);
    std::vector<hierarchy::View> views;
    for (int i = 0; i < 6; ++i) {
        const glm::dvec3 centre = domain.origin + 0.5 * kEdge;
        views.push_back(lookingAt(centre + 0.5 * kEdge * randomDirection(random), centre));
    }
    std::vector<Shot> first;
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        shown->clear();
        show(*shown, showing(cut(mesh, 3 + static_cast<int>(seed), seed)));
        for (std::size_t i = 0; i < views.size(); ++i) {
            const Shot shot = shoot(*shown, views[i]);
            if (seed == 1)
                first.push_back(shot);
            // A single bit of difference in a vertex would move its triangles' depth.
            ASSERT_EQ(shot, first[i]) << "cut " << seed << ", view " << i;
        }
    }
}

TEST_F(Border, drawsTheSamePictureWhereverTheDomainLies)
{
    const surface::Delta delta = showing(cut(sphere(glm::dvec3(0.5), kRadius, 32), 5, 4));
    std::vector<Shot> first;
    for (const glm::dvec3& origin :
         {glm::dvec3(0.0), glm::dvec3(6.4e6), glm::dvec3(-6.4e6, 3.2e9, 512.0)}) {
        const hierarchy::Domain domain{.origin = origin, .edge = kEdge};
        const auto shown = renderer(domain);
        show(*shown, delta);
        render::Scene scene;
        scene.terrain.baseHeight = origin.z;
        std::mt19937 random(5);
        for (std::size_t i = 0; i < 8; ++i) {
            const glm::dvec3 at = rounded(kEdge * (0.5 + 0.4 * randomDirection(random)));
            hierarchy::View view = lookingAt(origin + at, origin + at);
            view.forward = 0.5 * kEdge - at;
            const Shot shot = shoot(*shown, view, scene);
            if (first.size() <= i)
                first.push_back(shot);
            ASSERT_EQ(shot, first[i]) << "view " << i << " at " << origin.x;
        }
    }
}

TEST_F(Border, writesTheReversedDepthOfAPlane)
{
    const GridMesh mesh = sheet(24, [](double, double) { return 0.25; });
    for (const double offset : {0.0, 6.4e6}) {
        const hierarchy::Domain domain{.origin = glm::dvec3(offset), .edge = kEdge};
        const auto shown = renderer(domain);
        show(*shown, showing(cut(mesh, 6, 9)));
        for (const double height : {0.26, 0.3, 0.9}) {
            const glm::dvec3 eye = domain.origin + kEdge * glm::dvec3(0.5, 0.1, height);
            const hierarchy::View view = lookingAt(eye, eye + glm::dvec3(0.1, 1.0, -0.6));
            for (const double near : {0.0, 0.25}) {
                render::Scene scene;
                scene.nearPlane = near;
                const double plane = near > 0 ? near : shown->defaultNearPlane();
                const Shot shot = shoot(*shown, view, scene);
                int compared = 0;
                for (int y = 0; y < view.height; ++y) {
                    for (int x = 0; x < view.width; ++x) {
                        const glm::dvec3 ray = pixelRay(view, x, y);
                        const double length = (0.25 - height) * kEdge / ray.z;
                        const glm::dvec3 hit = (eye - domain.origin + length * ray) / kEdge;
                        const bool within = length > 0 && hit.x > 0.01 && hit.x < 0.99 &&
                                            hit.y > 0.01 && hit.y < 0.99;
                        if (!within)
                            continue;
                        ++compared;
                        const double expected = plane / length;
                        ASSERT_NEAR(
                            static_cast<double>(shot.depthAt(x, y)), expected, 3e-5 * expected);
                    }
                }
                EXPECT_GT(compared, 1'000);
            }
        }
    }
}

} // namespace
} // namespace isofront::test

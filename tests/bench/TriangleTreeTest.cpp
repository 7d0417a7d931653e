#include "bench/Meshes.h"
#include "support/Random.h"

#include <isofront/bench/TriangleTree.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace isofront::bench {
namespace {

template <typename Generator>
glm::dvec3 randomPoint(Generator& generator, double reach)
{
    return {
        tests::uniform(generator, -reach, reach),
        tests::uniform(generator, -reach, reach),
        tests::uniform(generator, -reach, reach)};
}

TEST(NearestOnTriangle, isNearerThanAnyOtherPointOfIt)
{
    auto generator = tests::random(81);
    for (int trial = 0; trial < 2000; ++trial) {
        const glm::dvec3 a = randomPoint(generator, 1);
        const glm::dvec3 b = trial % 10 == 0 ? a : randomPoint(generator, 1); // some without area
        const glm::dvec3 c = trial % 7 == 0 ? 0.5 * (a + b) : randomPoint(generator, 1);
        const glm::dvec3 p = randomPoint(generator, 2);
        const glm::dvec3 found = nearestOnTriangle(p, a, b, c);
        double least = 1e9;
        for (int i = 0; i <= 40; ++i)
            for (int k = 0; k <= 40 - i; ++k)
                least = std::min(
                    least,
                    glm::distance(
                        p, (double(i) * a + double(k) * b + double(40 - i - k) * c) / 40.0));
        const double size =
            std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
        EXPECT_LE(glm::distance(p, found), least + 1e-12);
        EXPECT_GE(glm::distance(p, found), least - size / 40);
    }
}

TEST(TriangleTree, findsTheNearestTriangleThatBruteForceFinds)
{
    auto generator = tests::random(82);
    surface::TriangleMesh mesh;
    for (std::uint32_t i = 0; i < 900; ++i) {
        mesh.positions.push_back(
            i % 3 == 0 ? randomPoint(generator, 1)
                       : mesh.positions.back() + randomPoint(generator, 0.2));
        mesh.indices.push_back(i);
    }
    const TriangleTree tree(mesh);
    for (int trial = 0; trial < 1000; ++trial) {
        const glm::dvec3 p = randomPoint(generator, trial % 2 == 0 ? 1 : 5);
        double least = 1e9;
        for (std::size_t t = 0; t < mesh.indices.size(); t += 3)
            least = std::min(
                least,
                glm::distance(
                    p,
                    nearestOnTriangle(
                        p, mesh.positions[t], mesh.positions[t + 1], mesh.positions[t + 2])));
        const auto found = tree.nearest(p);
        ASSERT_EQ(found.distance, least);
        EXPECT_NEAR(glm::distance(found.point, p), least, 1e-15);
        EXPECT_FALSE(std::isfinite(tree.nearest(p, 0.999 * least).distance));
        EXPECT_EQ(tree.nearest(p, 1.001 * least + 1e-9).distance, least);
    }
}

TEST(TriangleTree, blocksASegmentExactlyWhereItPassesTheSphere)
{
    const auto mesh = tests::icosphere(glm::dvec3(0), 1, 4);
    const TriangleTree tree(mesh);
    auto generator = tests::random(83);
    int blocked = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        const glm::dvec3 a = randomPoint(generator, 2);
        const glm::dvec3 b = randomPoint(generator, 2);
        // the sphere of triangles lies between two round ones
        const auto isCutBy = [&](double radius) {
            const double along = std::clamp(glm::dot(-a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
            const bool touches = glm::length(a + along * (b - a)) < radius;
            return touches && (glm::length(a) > radius || glm::length(b) > radius);
        };
        if (isCutBy(1.0) != isCutBy(0.99))
            continue;
        EXPECT_EQ(tree.isBlocked(a, b), isCutBy(1.0));
        blocked += isCutBy(1.0) ? 1 : 0;
    }
    EXPECT_GT(blocked, 1000);
    EXPECT_TRUE(tree.isBlocked({0.01, 0.02, 0}, {0.01, 0.02, 4}));
    EXPECT_FALSE(tree.isBlocked({0.01, 0.02, 0}, {0.01, 0.02, 4}, 0.3)) << "hit at a quarter";
    EXPECT_TRUE(tree.isBlocked({0.01, 0.02, 0}, {0.01, 0.02, 4}, 0.2));
}

TEST(TriangleTree, findsNothingInAnEmptyMesh)
{
    const surface::TriangleMesh empty;
    const TriangleTree tree(empty);
    EXPECT_FALSE(std::isfinite(tree.nearest({0, 0, 0}).distance));
    EXPECT_FALSE(tree.isBlocked({0, 0, 0}, {1, 1, 1}));
}

} // namespace
} // namespace isofront::bench

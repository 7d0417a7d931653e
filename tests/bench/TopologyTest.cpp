#include "bench/Meshes.h"

#include <isofront/bench/Topology.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isofront::bench {
namespace {

TEST(Topology, isThatOfABallADiscATorusAndWhatTheyMakeTogether)
{
    const auto ball = topologyOf(tests::icosphere(glm::dvec3(0), 1, 3));
    EXPECT_EQ(ball.components, 1U);
    EXPECT_EQ(ball.euler, 2);
    EXPECT_EQ(ball.openEdges, 0U);
    EXPECT_EQ(ball.nonManifold, 0U);
    EXPECT_EQ(ball.slivers, 0U);
    EXPECT_NEAR(ball.area, 4 * std::numbers::pi, 0.1);
    // twelve vertices of five triangles, all others of six; 642 of them
    EXPECT_DOUBLE_EQ(ball.sixShare, 1 - 12.0 / 642);
    EXPECT_DOUBLE_EQ(ball.meanValence, 6 - 12.0 / 642);

    const auto disc = topologyOf(tests::square(0, 5));
    EXPECT_EQ(disc.euler, 1);
    EXPECT_EQ(disc.openEdges, 20U);
    EXPECT_DOUBLE_EQ(disc.area, 1);
    EXPECT_NEAR(disc.quality, std::sqrt(3.0) / 2, 1e-12) << "right triangles with equal legs";

    surface::TriangleMesh torus;
    constexpr std::uint32_t n = 12;
    for (std::uint32_t i = 0; i < n * n; ++i) {
        const double u = 2 * std::numbers::pi * (i % n) / n;
        const double v = 2 * std::numbers::pi * (i / n) / n;
        torus.positions.emplace_back(
            (2 + std::cos(u)) * std::cos(v), (2 + std::cos(u)) * std::sin(v), std::sin(u));
        const std::uint32_t right = i / n * n + (i % n + 1) % n;
        const std::uint32_t up = (i + n) % (n * n);
        const std::uint32_t both = (right + n) % (n * n);
        torus.indices.insert(torus.indices.end(), {i, right, both, i, both, up});
    }
    EXPECT_EQ(topologyOf(torus).euler, 0);

    tests::append(torus, tests::square(9, 2));
    tests::append(torus, tests::icosphere({7, 0, 0}, 1, 1));
    torus.positions.emplace_back(0, 0, 0); // of no triangle
    const auto all = topologyOf(torus);
    EXPECT_EQ(all.components, 3U);
    EXPECT_EQ(all.euler, 0 + 1 + 2);
    EXPECT_EQ(all.componentOf.front(), 0U);
    EXPECT_EQ(all.componentOf[2 * n * n], 1U);
    EXPECT_EQ(all.componentOf.back(), 2U);
}

TEST(Topology, countsSliversAndEdgesOfManyTriangles)
{
    surface::TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 0.01, 0}, {0.5, 0, 1}, {0.5, -1, 0}};
    mesh.indices = {0, 1, 2, 0, 1, 3, 0, 1, 4};
    const auto topology = topologyOf(mesh);
    EXPECT_EQ(topology.slivers, 1U);
    EXPECT_EQ(topology.nonManifold, 1U);
    EXPECT_EQ(topology.openEdges, 6U);
    EXPECT_EQ(topologyOf({}).components, 0U);
    EXPECT_EQ(topologyOf({}).euler, 0);
}

TEST(Checksum, changesWithEveryBit)
{
    auto mesh = tests::square(0, 3);
    const std::uint64_t before = checksumOf(mesh);
    EXPECT_EQ(checksumOf(tests::square(0, 3)), before);
    mesh.positions[5].y = std::nextafter(mesh.positions[5].y, 9.0);
    EXPECT_NE(checksumOf(mesh), before);
    mesh = tests::square(0, 3);
    std::swap(mesh.indices[0], mesh.indices[1]);
    EXPECT_NE(checksumOf(mesh), before);
}

} // namespace
} // namespace isofront::bench

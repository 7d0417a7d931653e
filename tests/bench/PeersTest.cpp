#include <isofront/bench/Peers.h>
#include <isofront/bench/Topology.h>
#include <isofront/fields/Shapes.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace isofront::bench {
namespace {

TEST(GridPeers, meshTheBallThatWeMesh)
{
    const glm::dvec3 centre(0.503, 0.491, 0.507);
    const auto field = fields::sphere(centre, 0.37);
    const hierarchy::Domain domain;
    const GridSamples grid = sampledGrid(*field, domain, 40);
    const auto ours = marchingCubes(grid, 0, domain, field.get());
    for (const GridPeer& peer : gridPeers()) {
        const auto mesh = peer.mesh(grid, 0);
        EXPECT_EQ(topologyOf(mesh).euler, 2) << peer.name;
        EXPECT_EQ(mesh.indices.size(), ours.indices.size()) << peer.name;
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size()) << peer.name;
        double volume = 0;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            volume += glm::dot(
                          mesh.positions[mesh.indices[i]] - centre,
                          glm::cross(
                              mesh.positions[mesh.indices[i + 1]] - centre,
                              mesh.positions[mesh.indices[i + 2]] - centre)) /
                      6;
        EXPECT_NEAR(volume, 0.2122, 0.001) << peer.name << ": its triangles face out";
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const glm::dvec3 out = glm::normalize(mesh.positions[v] - centre);
            EXPECT_GT(glm::dot(glm::dvec3(mesh.normals[v]), out), 0.99) << peer.name;
            EXPECT_NEAR(glm::distance(mesh.positions[v], centre), 0.37, 1e-3);
        }
    }
}

} // namespace
} // namespace isofront::bench

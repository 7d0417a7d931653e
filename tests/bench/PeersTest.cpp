#include <isofront/bench/Peers.h>
#include <isofront/bench/Topology.h>
#include <isofront/fields/Shapes.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

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
        if (peer.name.starts_with("VTK")) {
            EXPECT_EQ(mesh.indices.size(), ours.indices.size()) << peer.name;
            EXPECT_EQ(mesh.normals.size(), mesh.positions.size()) << peer.name;
        }
        ASSERT_TRUE(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
        const bool isAdaptive = peer.name.find("adaptive") != std::string::npos;
        if (isAdaptive) {
            EXPECT_LT(mesh.indices.size(), 0.9 * double(ours.indices.size())) << peer.name;
        }
        double volume = 0;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            volume += glm::dot(
                          mesh.positions[mesh.indices[i]] - centre,
                          glm::cross(
                              mesh.positions[mesh.indices[i + 1]] - centre,
                              mesh.positions[mesh.indices[i + 2]] - centre)) /
                      6;
        EXPECT_NEAR(volume, 0.2122, isAdaptive ? 0.04 : 0.003) << peer.name << ": faces out";
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const glm::dvec3 out = glm::normalize(mesh.positions[v] - centre);
            if (!mesh.normals.empty()) {
                EXPECT_GT(glm::dot(glm::dvec3(mesh.normals[v]), out), 0.99) << peer.name;
            }
            EXPECT_NEAR(glm::distance(mesh.positions[v], centre), 0.37, isAdaptive ? 0.02 : 1e-3);
        }
    }
}

TEST(GridPeers, leaveTheSurfaceOpenWhereTheSamplesEnd)
{
    // a half space: all that there is to mesh is its border, once across the cube
    const auto field = fields::plane({0.5, 0.5, 0.517}, {0, 0, 1});
    const hierarchy::Domain domain;
    const GridSamples grid = sampledGrid(*field, domain, 20);
    for (const GridPeer& peer : gridPeers()) {
        const auto mesh = peer.mesh(grid, 0);
        const Topology topology = topologyOf(mesh);
        EXPECT_EQ(topology.euler, 1) << peer.name;
        EXPECT_LE(topology.area, 1.5) << peer.name << ": a polygon further at most";
        EXPECT_GT(topology.area, 0.95) << peer.name;
    }
}

} // namespace
} // namespace isofront::bench

#include "isofront/bench/Peers.h"

#ifdef ISOFRONT_WITH_VTK
#include "peers/Vtk.h"

#include <glm/geometric.hpp>

#include <utility>
#endif

namespace isofront::bench {

#ifdef ISOFRONT_WITH_VTK
namespace {

surface::TriangleMesh byFlyingEdges(const GridSamples& grid, double isovalue)
{
    peers::VtkMesh made = peers::flyingEdges(
        grid.values,
        grid.count,
        {grid.origin.x, grid.origin.y, grid.origin.z},
        grid.spacing,
        isovalue);
    surface::TriangleMesh mesh;
    for (std::size_t i = 0; i + 2 < made.positions.size(); i += 3) {
        mesh.positions.emplace_back(
            made.positions[i], made.positions[i + 1], made.positions[i + 2]);
        mesh.bounds.include(mesh.positions.back());
    }
    for (std::size_t i = 0; i + 2 < made.normals.size(); i += 3)
        mesh.normals.emplace_back(made.normals[i], made.normals[i + 1], made.normals[i + 2]);
    mesh.indices = std::move(made.indices);
    return mesh;
}

} // namespace
#endif

const std::vector<GridPeer>& gridPeers()
{
    static const std::vector<GridPeer> peers = {
#ifdef ISOFRONT_WITH_VTK
        {"VTK " + peers::vtkVersion() + " flying edges", byFlyingEdges},
#endif
    };
    return peers;
}

} // namespace isofront::bench

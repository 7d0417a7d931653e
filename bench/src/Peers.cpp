#include "isofront/bench/Peers.h"

#include "PeerModule.h"

#include <utility>

namespace isofront::bench {

namespace {

surface::TriangleMesh meshOf(peers::PeerMesh&& made)
{
    surface::TriangleMesh mesh;
    for (std::size_t i = 0; i + 2 < made.positions.size(); i += 3) {
        mesh.positions.emplace_back(
            made.positions[i], made.positions[i + 1], made.positions[i + 2]);
        mesh.bounds.include(mesh.positions.back());
    }
    for (std::size_t i = 0; i + 2 < made.normals.size(); i += 3)
        mesh.normals.emplace_back(made.normals[i], made.normals[i + 1], made.normals[i + 2]);
    mesh.indices.assign(made.indices.begin(), made.indices.end());
    return mesh;
}

surface::TriangleMesh byFlyingEdges(const GridSamples& grid, double isovalue)
{
    peers::PeerMesh made;
    flyingEdgesModule().mesh(
        grid.values,
        grid.count,
        {grid.origin.x, grid.origin.y, grid.origin.z},
        grid.spacing,
        isovalue,
        made);
    return meshOf(std::move(made));
}

surface::TriangleMesh byVolumeToMesh(const GridSamples& grid, double isovalue, double adaptivity)
{
    peers::PeerMesh made;
    volumeToMeshModule().mesh(
        grid.values,
        grid.count,
        {grid.origin.x, grid.origin.y, grid.origin.z},
        grid.spacing,
        isovalue,
        adaptivity,
        made);
    return meshOf(std::move(made));
}

} // namespace

const std::vector<GridPeer>& gridPeers()
{
    static const std::vector<GridPeer> peers = [] {
        std::vector<GridPeer> found;
        const FlyingEdgesModule& vtk = flyingEdgesModule();
        if (vtk.mesh != nullptr && vtk.version != nullptr)
            found.push_back({"VTK " + std::string(vtk.version()) + " flying edges", byFlyingEdges});
        const VolumeToMeshModule& vdb = volumeToMeshModule();
        if (vdb.mesh != nullptr && vdb.version != nullptr) {
            const std::string name = "OpenVDB " + std::string(vdb.version());
            for (const double adaptivity : {0.0, 0.1})
                found.push_back(
                    {name + (adaptivity > 0 ? ", adaptive 0.1" : ""),
                     [adaptivity](const GridSamples& grid, double isovalue) {
                         return byVolumeToMesh(grid, isovalue, adaptivity);
                     }});
        }
        return found;
    }();
    return peers;
}

} // namespace isofront::bench

#pragma once

#include "isofront/bench/GridContour.h"

#include <functional>
#include <string>
#include <vector>

namespace isofront::bench {

/// Another program's way from samples on a grid to triangles.
struct GridPeer {
    std::string name;
    /// One thread. The mesh has positions, triangles that face out, and normals if the peer makes
    /// them; in field space.
    std::function<surface::TriangleMesh(const GridSamples&, double isovalue)> mesh;
};

/// Those that this build found: VTK's flying edges, and OpenVDB's mesher, uniform and adaptive.
/// None is needed, and VTK isn't installed for us.
const std::vector<GridPeer>& gridPeers();

} // namespace isofront::bench

#pragma once

#include <cstdint>
#include <vector>

namespace isofront::bench::peers {

/// A mesh as a peer hands it over, in plain vectors.
struct PeerMesh {
    std::vector<double> positions;      ///< x, y, z of each vertex
    std::vector<float> normals;         ///< the same, or empty
    std::vector<std::uint32_t> indices; ///< three a triangle
};

} // namespace isofront::bench::peers

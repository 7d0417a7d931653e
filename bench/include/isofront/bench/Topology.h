#pragma once

#include <isofront/surface/TriangleMesh.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::bench {

/// What a mesh is, whatever its shape. Vertices without triangles don't count.
struct Topology {
    std::size_t components = 0;
    long euler = 0;              ///< vertices - edges + triangles: 2 a ball, 0 a torus, 1 a disc
    std::size_t openEdges = 0;   ///< edges of one triangle
    std::size_t nonManifold = 0; ///< edges of more than two
    std::size_t slivers = 0;     ///< triangles of quality 4 sqrt(3) A / (a^2 + b^2 + c^2) below 0.2
    double quality = 0;          ///< mean of that over the triangles; 1 for equilateral ones
    double meanValence = 0;      ///< triangles around a vertex that is on no open edge
    double sixShare = 0;         ///< of those vertices, how many have six, the best
    double area = 0;             ///< [world]
    /// Which component each triangle belongs to, in the order in which they first occur.
    std::vector<std::uint32_t> componentOf;
};

Topology topologyOf(const surface::TriangleMesh& mesh);

/// Of positions and indices, every bit: two meshes with the same sum are the same bytes.
std::uint64_t checksumOf(const surface::TriangleMesh& mesh);

} // namespace isofront::bench

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// Bits 0 to 3: the barycentric weight of that corner is zero, that is, the thing lies on the face
/// opposite to the corner. No bit: interior; one: a face; two: an edge; three: a corner.
using FeatureMask = std::uint8_t;

/// A hexahedron of the volume mesh. Corner m = a + 2 b + 4 c of its local axes.
struct Hexahedron {
    std::array<std::uint16_t, 8> vertex{};
    /// Where vertex[0] stands in the VolumeMesh::block that it belongs to.
    std::uint16_t place = 0;
    std::array<std::uint16_t, 12> edge{}; ///< in the order of MarchingCubesTable
};

/// A side of a hexahedron that lies on a face of the tetrahedron.
struct BoundaryQuad {
    /// Counter-clockwise seen from outside of a tetrahedron that is not mirrored.
    std::array<std::uint16_t, 4> vertex{};
    std::array<std::uint16_t, 4> edge{}; ///< edge[i] joins vertex[i] and vertex[i + 1]
};

/// The lattice of sample points that every cell shares: a tetrahedron is cut into four hexahedra,
/// one at each corner, and each of them into n^3 smaller ones; all four are unified.
///
/// Vertices are exact: integer barycentric weights over the denominator 12 n^3. On a face of the
/// tetrahedron they depend on the face's own corners only, so that neighbours meet in the same
/// points. Hexahedra follow a Hilbert curve within each of the four; edges are numbered in the
/// order in which hexahedra meet them.
///
/// Counts: 4n^3+6n^2+4n+1 vertices, 12n^3+12n^2+4n edges, 4n^3 hexahedra; at n = 16 all fit 16
/// bits. Memory: 2.2 MB at n = 16. Immutable; any thread.
///
/// Source: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
/// of detail and applications", section 3.2.
class VolumeMesh {
public:
    /// @param latticeSize  n: 1, 2, 4, 8 or 16 (asserted)
    explicit VolumeMesh(int latticeSize);

    /// The shared one for that size, made at first use.
    static const VolumeMesh& ofSize(int latticeSize);
    static bool isValidSize(int latticeSize);

    [[nodiscard]] int latticeSize() const { return _n; }
    /// 12 n^3: what the weights of a vertex add up to.
    [[nodiscard]] std::uint32_t denominator() const { return _denominator; }
    [[nodiscard]] std::size_t vertexCount() const { return weights.size(); }

    std::vector<std::array<std::uint32_t, 4>> weights; ///< of corners 0 to 3, for each vertex
    std::array<std::vector<double>, 4> weightColumns;  ///< the same as structure of arrays
    std::vector<FeatureMask> vertexFeature;
    std::vector<std::array<std::uint16_t, 2>> edges; ///< their two vertices
    std::vector<FeatureMask> edgeFeature;
    std::vector<Hexahedron> hexahedra; ///< n^3 of each large one, one after the other
    /// The vertices of each of the four large hexahedra as a grid of n + 1 along each axis, the
    /// first axis fastest: corner m = a + 2 b + 4 c of a hexahedron is its `place` and
    /// a + (n + 1) (b + (n + 1) c).
    std::array<std::vector<std::uint16_t>, 4> block;
    /// By the corner that the face is opposite to.
    std::array<std::vector<BoundaryQuad>, 4> boundary;

private:
    int _n;
    std::uint32_t _denominator;
};

} // namespace isofront::extractor

#pragma once

#include <isofront/hierarchy/Domain.h>

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// A vertex as it is stored, sent and drawn: 12 bytes.
struct CellVertex {
    enum Flag : std::uint16_t {
        border = 1, ///< its lattice edge lies on a face of the tetrahedron: never moved or removed
        cap = 2,    ///< it closes the surface at the border of the data or of the domain
    };

    /// Position relative to the cell's low corner [2^exponent grid units], each at most 32768.
    std::array<std::uint16_t, 3> position{};
    std::uint16_t flags = 0;
    /// Unit normal in field space, pointing to the outside (down the field), octahedral.
    std::array<std::int16_t, 2> normal{};

    bool operator==(const CellVertex&) const = default;
};
static_assert(sizeof(CellVertex) == 12);

/// What the extraction of one cell did, for reports.
struct CellStats {
    std::uint32_t samples = 0;          ///< of the field's values
    std::uint32_t sanitisedSamples = 0; ///< non-finite or huge ones among them
    bool provedEmpty = false;           ///< the field's bounds excluded the isovalue: never sampled
    /// Estimated distance between mesh and surface, root of the mean square and maximum [field];
    /// 0 if not asked for.
    float errorRms = 0;
    float errorMax = 0;
};

/// The triangles of one cell. Immutable once published; the same input gives the same bytes.
struct CellMesh {
    hierarchy::LatticePoint low; ///< the cell's low corner [lattice units]
    /// Vertices lie on multiples of 2^exponent grid units, 1 <= exponent <= 32.
    std::uint8_t exponent = 1;
    std::vector<CellVertex> vertices;
    /// Three a triangle, counter-clockwise seen from outside in field space.
    std::vector<std::uint16_t> indices;
    /// What the field says of each vertex, a colour or a material, at the vertex's own radius;
    /// empty unless asked for. Never interpolated.
    std::vector<std::uint32_t> attributes;
    CellStats stats;

    [[nodiscard]] std::size_t triangleCount() const { return indices.size() / 3; }
    [[nodiscard]] std::size_t bytes() const
    {
        return sizeof(CellMesh) + vertices.size() * sizeof(CellVertex) +
               indices.size() * sizeof(std::uint16_t) + attributes.size() * sizeof(std::uint32_t);
    }
    /// Where a vertex lies, exactly.
    [[nodiscard]] hierarchy::GridPoint gridPosition(const CellVertex& vertex) const
    {
        const hierarchy::GridPoint corner = hierarchy::gridFromLattice(low);
        return {
            corner.x + (std::int64_t{vertex.position[0]} << exponent),
            corner.y + (std::int64_t{vertex.position[1]} << exponent),
            corner.z + (std::int64_t{vertex.position[2]} << exponent)};
    }
};

/// Octahedral encoding of a unit vector in two signed 16-bit numbers, and back (to within 1e-4).
std::array<std::int16_t, 2> octahedral(const glm::dvec3& unit);
glm::dvec3 fromOctahedral(const std::array<std::int16_t, 2>& code);

} // namespace isofront::extractor

#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>
#include <isofront/voxels/Voxelization.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isofront::voxels {

/// Steps of the grid that a source's vertices lie on, along the edge of a voxel of level 0.
inline constexpr std::uint32_t kSourceSteps = 1024;
/// A source's cells have an edge of 2^5 voxels of level 0, which is 32768 steps.
inline constexpr std::uint32_t kSourceCellBits = 5;

struct SourceVertex {
    std::array<std::uint16_t, 3> place{}; ///< from the cell's low corner [steps], at most 32768
    std::uint32_t normal = 0;             ///< as in Voxel
    std::uint32_t colour = 0;             ///< as in Chunk::colours; 0 if the source has none

    friend bool operator==(const SourceVertex&, const SourceVertex&) = default;
};

/// The part of a source that lies in a cell, or in so much of it as 16 bits can number.
struct SourceCell {
    glm::uvec3 place{0U, 0U, 0U}; ///< of the cell, from the lattice's origin [cells]
    std::uint32_t part = 0;       ///< of the cell's parts
    std::vector<SourceVertex> vertices;
    std::vector<std::uint16_t> indices; ///< three a triangle, counter-clockwise seen from outside
};

/// The triangles that a voxel model was made from, cut into cells: what is to be shown where voxels
/// are too coarse.
///
/// Corners are rounded to 1/1024 voxel, and triangles that cross the border of a cell are cut
/// there. A cut's place depends on nothing but the edge that it lies on, and all arithmetic is of
/// integers: so what fits together before does so afterwards, within cells and between them,
/// whichever blocks are cut.
///
/// Normals are means of those of the triangles around a corner, of the nearest 128 in the model's
/// order where more meet, but not across creases of more than 50 degrees. Colours, textures
/// included, are taken at vertices; a model with textures is cut at every voxel, so that the
/// picture is as fine as that of the voxels.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 4 (source geometry). Differs: what is shown is cut along cells, not whole triangles.
///
/// Immutable. Thread: any number at once.
class SourceMesh {
public:
    /// @param lattice    of the voxels that were made from the model
    /// @param blockBits  parts can be cut that are 2^blockBits voxels wide; kSourceCellBits to 16
    /// @param blocks     how many there are along each axis, at least 1; what lies beyond is left
    ///                   out, as are triangles that name positions which aren't there, not
    ///                   finite, or more than 2 kMaxResolution voxels from the lattice's
    ///                   origin along an axis
    /// @return badData if the model contradicts itself; usage for block sizes out of range
    /// Cost: memory of the model, and about 40 bytes a triangle.
    static core::Result<SourceMesh> create(
        TriangleModel model,
        const VoxelLattice& lattice,
        std::uint32_t blockBits,
        const glm::uvec3& blocks);
    SourceMesh(SourceMesh&&) noexcept;
    SourceMesh& operator=(SourceMesh&&) noexcept;
    ~SourceMesh();

    /// What lies in a block, by cells: along x first, then y, then z. The same bits every time.
    [[nodiscard]] std::vector<SourceCell> cut(const glm::uvec3& block) const;
    /// Triangles that may meet a block: if there are none, nothing is cut from it.
    [[nodiscard]] std::size_t trianglesNear(const glm::uvec3& block) const;
    [[nodiscard]] std::size_t triangles() const; ///< of the model
    /// Whether its triangles have an inside that can't be seen from outside: every edge has as many
    /// of them on either side, and each part that hangs together has its inside where they say. One
    /// with bubbles inside doesn't count as such.
    [[nodiscard]] bool isClosed() const;
    [[nodiscard]] bool isColoured() const;
    [[nodiscard]] std::size_t bytes() const; ///< on the host, nearly

private:
    struct Parts;
    explicit SourceMesh(std::unique_ptr<Parts> parts);

    std::unique_ptr<const Parts> _parts;
};

} // namespace isofront::voxels

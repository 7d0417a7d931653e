#pragma once

#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/TriangleMesh.h>

#include <glm/ext/vector_uint3_sized.hpp>

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::tiles {

/// A cube of the octree over the domain.
struct TileId {
    int depth = 0;
    glm::u32vec3 at{0}; ///< from the domain's low corner, in edges of tiles of this depth

    /// Orders the tiles of one depth.
    [[nodiscard]] std::uint64_t key() const
    {
        return std::uint64_t{at.x} << 42U | std::uint64_t{at.y} << 21U | at.z;
    }
    static TileId ofKey(int depth, std::uint64_t key)
    {
        constexpr std::uint64_t kMask = (std::uint64_t{1} << 21U) - 1;
        return {
            depth,
            {static_cast<std::uint32_t>(key >> 42U),
             static_cast<std::uint32_t>(key >> 21U & kMask),
             static_cast<std::uint32_t>(key & kMask)}};
    }
    [[nodiscard]] TileId parent() const { return {depth - 1, at / 2U}; }
    /// Which of its parent's eight it is.
    [[nodiscard]] unsigned octant() const
    {
        return (at.x & 1U) | (at.y & 1U) << 1U | (at.z & 1U) << 2U;
    }
};

/// What of a mesh goes into one tile.
struct TilePart {
    TileId tile;
    std::vector<std::uint32_t> home; ///< triangles whose middle lies in the cube, in order
    std::vector<std::uint32_t> rim;  ///< others that come near the cube, in order
    std::uint8_t octants = 0;        ///< a bit for each child's cube that a triangle touches
};

/// Gives each triangle of a mesh to the tiles that show it: to the one in which its middle lies,
/// and to all others within `margin`.
/// @param margin  [edges of tiles], below 1
/// @return tiles with triangles, by their keys
std::vector<TilePart> cutIntoTiles(
    const surface::TriangleMesh& mesh, const hierarchy::Domain& domain, int depth, double margin);

/// A part of a mesh as a mesh of its own, turned from z up to y up.
/// @param bounds  receives those of its positions, not turned
surface::TriangleMesh
tileMesh(const surface::TriangleMesh& mesh, const TilePart& part, core::Box& bounds);

} // namespace isofront::tiles

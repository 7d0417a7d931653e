#pragma once

#include <isofront/voxels/Voxel.h>

#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::voxels {

/// Names a chunk: its level of detail, 0 the finest, and its place among the chunks of that level.
/// A chunk's parent is one level up, at half its place.
struct ChunkKey {
    std::uint32_t level = 0;
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    std::uint32_t z = 0;

    [[nodiscard]] constexpr ChunkKey parent() const { return {level + 1, x / 2, y / 2, z / 2}; }
    /// @param which  0 to 7: x in the lowest bit, z in the highest. Level at least 1.
    [[nodiscard]] constexpr ChunkKey child(std::uint32_t which) const
    {
        return {level - 1, 2 * x + (which & 1U), 2 * y + (which >> 1U & 1U), 2 * z + (which >> 2U)};
    }

    friend constexpr auto operator<=>(const ChunkKey&, const ChunkKey&) = default;
};

/// A key in words, for messages: "chunk 3, 0, 7 of level 2".
std::string nameOf(const ChunkKey& key);

/// How the surface looks from one side of a voxel.
struct FaceAttributes {
    std::uint32_t normal = 0; ///< as in Voxel
    std::uint32_t colour = 0; ///< as in Chunk::colours; 0 where there are none

    friend bool operator==(const FaceAttributes&, const FaceAttributes&) = default;
};

/// Says which faces of a voxel have attributes of their own, and where they are. Its other faces
/// have the voxel's.
///
/// For voxels that hold surfaces turned to different sides, as thin walls do: their mean would
/// have next to no direction, and a colour that neither side has.
struct FaceSet {
    std::uint32_t voxel = 0; ///< index in the chunk
    /// The first of its entries in Chunk::faceAttributes, 26 bits, lowest; then a mask of the faces
    /// that have one, in the order of which they follow each other.
    std::uint32_t faces = 0;

    [[nodiscard]] constexpr std::uint32_t first() const { return faces & 0x3ffffffU; }
    [[nodiscard]] constexpr std::uint8_t mask() const
    {
        return static_cast<std::uint8_t>(faces >> 26U);
    }
    /// Where a face's entry is; only for faces in the mask.
    [[nodiscard]] constexpr std::uint32_t entry(Face face) const
    {
        const auto below = static_cast<std::uint8_t>(mask() & (faceBit(face) - 1U));
        return first() + static_cast<std::uint32_t>(std::popcount(below));
    }
    friend constexpr bool operator==(const FaceSet&, const FaceSet&) = default;
};

/// A block of surface voxels, at most kChunkEdge along each axis.
struct Chunk {
    ChunkKey key;
    /// In their order (Voxel::order), each place once.
    std::vector<Voxel> voxels;
    /// 8-bit sRGB red, green, blue and opacity of each voxel, red lowest; or none at all.
    std::vector<std::uint32_t> colours = {};
    /// Of the voxels that need them, in their order, each once; most chunks have few or none.
    std::vector<FaceSet> faceSets = {};
    /// What the sets name. Voxels that look alike share their entries.
    std::vector<FaceAttributes> faceAttributes = {};

    /// As it is stored, without its header.
    [[nodiscard]] std::size_t bytes() const
    {
        return voxels.size() * sizeof(Voxel) + colours.size() * sizeof(std::uint32_t) +
               faceSets.size() * sizeof(FaceSet) + faceAttributes.size() * sizeof(FaceAttributes);
    }
    friend bool operator==(const Chunk&, const Chunk&) = default;
};

/// How a voxel looks from across one of its faces.
/// Cost: a binary search among the chunk's face sets.
FaceAttributes attributesOf(const Chunk& chunk, std::size_t voxel, Face face);

/// Whether the chunk's face sets are in order, and name voxels and attributes that there are.
bool hasSoundFaces(const Chunk& chunk);

/// Face masks with those faces added that lie in a chunk's own border: where chunks of different
/// detail meet, neighbours don't cover each other, and without these caps one could look through.
/// Never stored, because what is stored is OR-ed into coarser levels.
std::vector<std::uint8_t> cappedFaces(const Chunk& chunk);

} // namespace isofront::voxels

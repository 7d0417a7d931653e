#pragma once

#include <isofront/voxels/Voxel.h>

#include <compare>
#include <cstddef>
#include <cstdint>
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

/// A block of surface voxels, at most kChunkEdge along each axis.
struct Chunk {
    ChunkKey key;
    /// In their order (Voxel::order), each place once.
    std::vector<Voxel> voxels;
    /// 8-bit sRGB red, green, blue and opacity of each voxel, red lowest; or none at all.
    std::vector<std::uint32_t> colours;

    /// As it is stored, without its header.
    [[nodiscard]] std::size_t bytes() const
    {
        return voxels.size() * sizeof(Voxel) + colours.size() * sizeof(std::uint32_t);
    }
    friend bool operator==(const Chunk&, const Chunk&) = default;
};

/// Face masks with those faces added that lie in a chunk's own border: where chunks of different
/// detail meet, neighbours don't cover each other, and without these caps one could look through.
/// Never stored, because what is stored is OR-ed into coarser levels.
std::vector<std::uint8_t> cappedFaces(const Chunk& chunk);

} // namespace isofront::voxels

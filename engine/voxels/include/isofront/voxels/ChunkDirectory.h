#pragma once

#include <isofront/voxels/Chunk.h>

#include <array>
#include <cstdint>

namespace isofront::voxels {

/// What a store knows of a chunk without reading it.
struct ChunkEntry {
    ChunkKey key;
    std::uint32_t voxels = 0;
    bool coloured = false;
    std::uint32_t faceSets = 0;       ///< Chunk::faceSets
    std::uint32_t faceAttributes = 0; ///< Chunk::faceAttributes
    /// Of the chunk as it is stored, without its header (Chunk::bytes).
    std::uint64_t bytes = 0;
    /// The least and greatest places of its voxels along each axis, both inclusive: a tight box.
    std::array<std::uint8_t, 3> low{};
    std::array<std::uint8_t, 3> high{};
    /// How many voxels of the parent chunk contain them: an eighth of `voxels` to all of it.
    std::uint32_t parents = 0;

    /// How many nodes its transition has beside its voxels (TransitionNodes::redundant).
    [[nodiscard]] constexpr std::uint32_t redundant() const { return 8 * parents - voxels; }

    friend bool operator==(const ChunkEntry&, const ChunkEntry&) = default;
};

/// @param chunk  not empty
ChunkEntry entryOf(const Chunk& chunk);

} // namespace isofront::voxels

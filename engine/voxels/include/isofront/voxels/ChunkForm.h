#pragma once

#include <isofront/voxels/Chunk.h>
#include <isofront/voxels/ChunkDirectory.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace isofront::voxels {

/// How chunks lie in the memory of the device.
struct ChunkForm {
    /// How much a chunk takes there [bytes].
    std::function<std::uint64_t(const ChunkEntry&)> bytes;
    /// Writes exactly so much. Runs in the background, on several threads at once.
    std::function<void(const Chunk&, std::span<std::byte>)> pack;
};

/// In the second word of a voxel in the standard form: its faces have looks of their own, and the
/// other bits say where they are.
inline constexpr std::uint32_t kHasFaces = 0x80000000;

/// The form that shaders/include/voxel.glsl reads. In words of four bytes: two for each voxel, as
/// they are stored, but with the faces in the chunk's border added (cappedFaces); its colours, if
/// it has any; its face attributes, two words each; and two words for each face set.
///
/// A voxel that has a set holds the place of it instead of its normal, with `kHasFaces`; places are
/// words from the chunk's first. The set holds the voxel's normal and the place of its first
/// attributes, 28 bits; in the highest bits of both words lies the mask of its faces, the lower two
/// bits in the first word. So voxels that look the same from all sides cost nothing, neither memory
/// nor a look elsewhere, and a chunk takes as much as it does when stored (Chunk::bytes).
ChunkForm standardForm();

/// A chunk in the standard form.
/// @param chunk  hasSoundFaces
/// @param place  Chunk::bytes of them
void packInto(const Chunk& chunk, std::span<std::byte> place);

} // namespace isofront::voxels

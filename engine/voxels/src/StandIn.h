#pragma once

#include <isofront/voxels/Chunk.h>

namespace isofront::voxels {

/// What a coarser chunk shows in the place of one below it, for a chunk that can't be read: those
/// of its voxels that lie there, in its own coordinates, with the faces that border on the chunk's
/// neighbours. It has no more voxels than the chunk, as each contains one of its at least.
///
/// Attributes of single faces are left out, so that it takes no more memory either.
///
/// @param above  of a coarser level, and contains `key`
Chunk standInFor(const ChunkKey& key, const Chunk& above);

} // namespace isofront::voxels

// What the shaders know of surface voxels.
#ifndef ISOFRONT_SHARED_VOXELS_H
#define ISOFRONT_SHARED_VOXELS_H

#include "shared/types.h"

ISOFRONT_SHARED_BEGIN

// Voxels of a block, which one group of threads draws. The name of a voxel in a frame is 256 times
// its block, plus its place in the block, plus 1; 0 is no voxel.
const uint kVoxelsInBlock = 256u;
const uint kBlockBits = 8u;

// In the second word of a voxel, as voxels::kHasFaces: its faces have looks of their own.
const uint kHasFaces = 0x80000000u;

// Corners of the three faces that a voxel may show.
const uint kCornersOfVoxel = 12u;

// Where a drawn chunk's pictures are, as shared/transition.h names them.
const uint kChunkPicturesShift = 24u;
// Where the octants are that a chunk casts shadows with, one bit for each.
const uint kChunkOctantsShift = 24u;

// The frame as the voxels' lattice sees it; lengths in voxels of level 0. The lattice's axes are
// the world's.
struct VoxelView {
    // The eye within its cell of the lattice, in [0, 1); in w the edge of a voxel [world].
    vec4 eye;
    // Rows that take a vector from the eye to clip x, y and w [world / voxel]. In the w of the
    // first: clip z, the distance of the near plane [world].
    vec4 clipX;
    vec4 clipY;
    vec4 clipW;
    // The cell of the lattice that the eye is in [voxels of level 0].
    ivec4 cell;
};

// A chunk that is drawn.
struct DrawnChunk {
    // Its low corner, less the cell that the eye is in [voxels of level 0]; in w its level.
    ivec4 cornerAndLevel;
    // In the pool of words: where its voxels begin, where their colours begin (0: it has none); its
    // number of nodes: voxels, and after them redundant ones; its first block.
    uvec4 place;
    // The places of the low and of the high corner of the box around its nodes, packed as voxels
    // are, and above the first the pictures that it is part of, above the second, of what casts
    // shadows, the octants; its number of voxels; the bits of its weight: 1 for itself, 0 for its
    // parent's looks.
    uvec4 box;
    // For weights below 1, in the pool of words: where the list of its nodes' parents begins, and
    // that of the places and directions of its redundant nodes; where the parent chunk's voxels
    // begin, and their colours (0: it has none).
    uvec4 fade;
};

// Which chunk of the frame a block belongs to, and its first voxel there.
struct VoxelBlock {
    uvec2 chunkAndVoxel;
};

ISOFRONT_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(isofront::shared::VoxelView) == 5 * 16);
static_assert(sizeof(isofront::shared::DrawnChunk) == 4 * 16);
static_assert(sizeof(isofront::shared::VoxelBlock) == 8);
#endif

#endif

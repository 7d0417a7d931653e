// Who has which block of space, where meshes and voxels share a picture. What includes this has a
// frame, and says in which binding the blocks are.
#ifndef ISOFRONT_OWNERS_GLSL
#define ISOFRONT_OWNERS_GLSL

// A byte for each block: the pictures in which it is the voxels'.
layout(set = 0, binding = ISOFRONT_OWNERS_BINDING, std430) readonly buffer Owners { uint owners[]; };

// The pictures in which the voxels have a block; what lies outside counts as part of the nearest.
uint voxelsHave(ivec3 block)
{
    uvec3 count = frame.blockCount.xyz;
    uvec3 at = uvec3(clamp(block, ivec3(0), ivec3(count) - 1));
    uint index = (at.z * count.y + at.y) * count.x + at.x;
    return (owners[index >> 2u] >> (8u * (index & 3u))) & 3u;
}

#endif

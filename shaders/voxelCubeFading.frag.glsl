#version 460
#extension GL_GOOGLE_include_directive : require

// As voxelCube.frag.glsl, for chunks that are in one of two pictures only: leaves the pixels of the
// other one alone. No early tests here, which would write the depth of what is discarded.
#include "include/voxel.glsl"

layout(location = 0) flat in uint name;
layout(location = 0) out uint shown;

void main()
{
    DrawnChunk chunk = chunks[blocks[(name - 1u) >> kBlockBits].chunkAndVoxel.x];
    if (!isShownAt(uvec2(gl_FragCoord.xy), picturesOf(chunk)))
        discard;
    shown = name;
}

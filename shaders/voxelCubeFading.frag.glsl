#version 460
#extension GL_GOOGLE_include_directive : require

// As voxelCube.frag.glsl, for chunks that are in one of two pictures only, or in part where meshes
// are shown: leaves the other pixels alone. No early tests here, which would write the depth of
// what is discarded.
#include "include/voxel.glsl"

layout(location = 0) flat in uint name;
layout(location = 1) flat in uint pictures;
layout(location = 0) out uint shown;

void main()
{
    if (!isShownAt(uvec2(gl_FragCoord.xy), pictures))
        discard;
    shown = name;
}

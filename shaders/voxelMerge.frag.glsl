#version 460
#extension GL_GOOGLE_include_directive : require

// Brings the nearest splat of every pixel among what has been rasterised.
#include "include/voxel.glsl"

layout(set = 0, binding = 5, std430) readonly buffer Splats { uvec2 splats[]; };

layout(location = 0) out uint shown;

void main()
{
    uvec2 at = uvec2(gl_FragCoord.xy);
    uvec2 splat = splats[at.y * uint(frame.picture.x) + at.x];
    if (splat.x == 0u)
        discard;
    shown = splat.x;
    gl_FragDepth = uintBitsToFloat(splat.y);
}

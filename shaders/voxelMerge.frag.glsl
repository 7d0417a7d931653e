#version 460
#extension GL_GOOGLE_include_directive : require

// Brings the nearest splat of every pixel, or of each of its samples, among what has been rasterised.
#include "include/voxel.glsl"

layout(set = 0, binding = 5, std430) readonly buffer Splats { uvec2 splats[]; };

layout(location = 0) out uint shown;

void main()
{
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint place = at.y * uint(frame.picture.x) + at.x;
#ifdef ISOFRONT_SAMPLES
    place = place * uint(frame.sampling.x) + uint(gl_SampleID);
#endif
    uvec2 splat = splats[place];
    if (splat.x == 0u)
        discard;
    shown = splat.x;
    gl_FragDepth = uintBitsToFloat(splat.y);
}

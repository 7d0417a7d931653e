#version 460
#extension GL_GOOGLE_include_directive : require

// As mesh.frag.glsl, for cells that are in one of two pictures only, or in part where voxels are
// shown: leaves the other pixels alone. No early tests here, which would write the depth of what is
// discarded.
#include "include/meshSurface.glsl"
#include "shared/frame.h"
#include "shared/transition.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };

#define ISOFRONT_OWNERS_BINDING 2
#include "include/owners.glsl"

// At the outline of a triangle: of the part that is covered, never from outside.
layout(location = 0) centroid in vec4 normalAndCap;
layout(location = 1) flat in uint pictures;
layout(location = 2) centroid in vec3 place; // [blocks]

layout(location = 0) out vec4 surface;
#ifdef ISOFRONT_COLOURED
#include "include/srgb.glsl"

layout(location = 3) centroid in vec4 ownLight;
layout(location = 1) out vec4 colour; // sRGB, of what has a colour of its own
#endif

void main()
{
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint picture = pictureAt(at.x, at.y, frame.transition.x);
    if ((pictures & picture) == 0u)
        discard;
    if ((pictures & kLooksUp) != 0u) {
        vec3 block = clamp(floor(place), vec3(0.0), vec3(frame.blockCount.xyz));
        if ((voxelsHave(ivec3(block)) & picture) != 0u)
            discard;
    }
    surface = surfaceOf(normalAndCap, gl_FrontFacing);
#ifdef ISOFRONT_COLOURED
    if (ownLight.w > 0.999)
        surface.w = sign(surface.w); // as voxelSurface.frag.glsl writes it
    colour = vec4(fromLinear(clamp(ownLight.rgb, 0.0, 1.0)), 1.0);
#endif
}

#version 460
#extension GL_GOOGLE_include_directive : require

// As mesh.frag.glsl, for cells that are in one of two pictures only: leaves the pixels of the other
// one alone. No early tests here, which would write the depth of what is discarded.
#include "include/meshSurface.glsl"
#include "shared/frame.h"
#include "shared/transition.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };

// At the outline of a triangle: of the part that is covered, never from outside.
layout(location = 0) centroid in vec4 normalAndCap;
layout(location = 1) flat in uint pictures;

layout(location = 0) out vec4 surface;

void main()
{
    uvec2 at = uvec2(gl_FragCoord.xy);
    if ((pictures & pictureAt(at.x, at.y, frame.transition.x)) == 0u)
        discard;
    surface = surfaceOf(normalAndCap, gl_FrontFacing);
}

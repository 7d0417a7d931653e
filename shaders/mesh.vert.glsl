#version 460
#extension GL_GOOGLE_include_directive : require

#include "include/meshVertex.glsl"

layout(location = 1) in vec2 octahedralNormal;

layout(location = 0) out vec4 normalAndCap;

invariant gl_Position;

void main()
{
    gl_Position = clipped(fromEyeIn(cells[gl_InstanceIndex].lowAndExponent));
    normalAndCap = normalAndCapOf(octahedralNormal);
#ifdef ISOFRONT_COLOURED
    ownLight = vec4(toLinear(ownColour.rgb), ownColour.w > 0.0 ? 1.0 : 0.0);
#endif
}

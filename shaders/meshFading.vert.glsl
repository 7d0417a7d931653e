#version 460
#extension GL_GOOGLE_include_directive : require

// As mesh.vert.glsl, for cells that aren't shown in all pixels.
#include "include/meshVertex.glsl"

layout(location = 1) in vec2 octahedralNormal;

layout(location = 0) out vec4 normalAndCap;
layout(location = 1) flat out uint pictures;
layout(location = 2) out vec3 place; // [blocks]

invariant gl_Position;

void main()
{
    uvec4 cell = cells[gl_InstanceIndex].lowAndExponent;
    vec3 fromEye = fromEyeIn(cell);
    gl_Position = clipped(fromEye);
    normalAndCap = normalAndCapOf(octahedralNormal);
#ifdef ISOFRONT_COLOURED
    ownLight = vec4(toLinear(ownColour.rgb), ownColour.w > 0.0 ? 1.0 : 0.0);
#endif
    pictures = cell.w >> kCellPicturesShift;
    place = vec3(
        dot(frame.blockFromGrid[0].xyz, fromEye) + frame.blockFromGrid[0].w,
        dot(frame.blockFromGrid[1].xyz, fromEye) + frame.blockFromGrid[1].w,
        dot(frame.blockFromGrid[2].xyz, fromEye) + frame.blockFromGrid[2].w);
}

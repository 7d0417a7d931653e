#version 460
#extension GL_GOOGLE_include_directive : require

// As mesh.vert.glsl, for cells that are in one of two pictures only.
#include "include/meshVertex.glsl"

layout(location = 1) in vec2 octahedralNormal;

layout(location = 0) out vec4 normalAndCap;
layout(location = 1) flat out uint pictures;

invariant gl_Position;

void main()
{
    uvec4 cell = cells[gl_InstanceIndex].lowAndExponent;
    gl_Position = clipped(fromEyeIn(cell));
    normalAndCap = normalAndCapOf(octahedralNormal);
    pictures = cell.w >> kCellPicturesShift;
}

#version 460
#extension GL_GOOGLE_include_directive : require

// Writes what the shading pass needs. Shading itself comes later, once a pixel: a rasteriser in
// software shades whole blocks for every small triangle, twenty fragments for each.
#include "include/meshSurface.glsl"

// At the outline of a triangle: of the part that is covered, never from outside.
layout(location = 0) centroid in vec4 normalAndCap;

layout(location = 0) out vec4 surface;

void main()
{
    surface = surfaceOf(normalAndCap, gl_FrontFacing);
}

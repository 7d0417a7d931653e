#version 460
#extension GL_GOOGLE_include_directive : require

// Writes what the shading pass needs. Shading itself comes later, once a pixel: a rasteriser in
// software shades whole blocks for every small triangle, twenty fragments for each.
#include "include/meshSurface.glsl"

// At the outline of a triangle: of the part that is covered, never from outside.
layout(location = 0) centroid in vec4 normalAndCap;

layout(location = 0) out vec4 surface;
#ifdef ISOFRONT_COLOURED
#include "include/srgb.glsl"

layout(location = 3) centroid in vec4 ownLight;
layout(location = 1) out vec4 colour; // sRGB, of what has a colour of its own
#endif

void main()
{
    surface = surfaceOf(normalAndCap, gl_FrontFacing);
#ifdef ISOFRONT_COLOURED
    if (ownLight.w > 0.999)
        surface.w = sign(surface.w); // as voxelSurface.frag.glsl writes it
    colour = vec4(fromLinear(clamp(ownLight.rgb, 0.0, 1.0)), 1.0);
#endif
}

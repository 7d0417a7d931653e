// A mesh vertex on its way to the picture: what all vertex shaders of meshes share, so that all get
// the same bits.
#ifndef ISOFRONT_MESH_VERTEX_GLSL
#define ISOFRONT_MESH_VERTEX_GLSL

#include "shared/frame.h"
#include "shared/gridDifference.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1, std430) readonly buffer Cells { DrawnCell cells[]; };

layout(location = 0) in uvec4 positionAndFlags;
#ifdef ISOFRONT_COLOURED
#include "include/srgb.glsl"

layout(location = 2) in vec4 ownColour; // sRGB; in w 0 for none
layout(location = 3) out vec4 ownLight;
#endif

// From the eye to the vertex [grid units].
vec3 fromEyeIn(uvec4 cell)
{
    uint exponent = cell.w & kExponentMask;
    return vec3(
        gridDifference(cell.x, positionAndFlags.x, exponent, frame.eyeLow.x, frame.eyeHigh.x),
        gridDifference(cell.y, positionAndFlags.y, exponent, frame.eyeLow.y, frame.eyeHigh.y),
        gridDifference(cell.z, positionAndFlags.z, exponent, frame.eyeLow.z, frame.eyeHigh.z));
}

vec4 clipped(vec3 fromEye)
{
    return vec4(
        dot(frame.clipX.xyz, fromEye), dot(frame.clipY.xyz, fromEye), frame.clipX.w,
        dot(frame.clipW.xyz, fromEye));
}

vec3 unfolded(vec2 code)
{
    vec3 n = vec3(code, 1.0 - abs(code.x) - abs(code.y));
    if (n.z < 0.0) {
        vec2 signs = vec2(code.x < 0.0 ? -1.0 : 1.0, code.y < 0.0 ? -1.0 : 1.0);
        n.xy = (1.0 - abs(code.yx)) * signs;
    }
    return n;
}

// The normal in the world; in w 1 for a vertex of a cap.
vec4 normalAndCapOf(vec2 octahedralNormal)
{
    vec3 n = unfolded(octahedralNormal);
    vec3 normal = frame.worldFromNormal[0].xyz * n.x + frame.worldFromNormal[1].xyz * n.y +
                  frame.worldFromNormal[2].xyz * n.z;
    return vec4(normalize(normal), (positionAndFlags.w & 2u) != 0u ? 1.0 : 0.0);
}

#endif

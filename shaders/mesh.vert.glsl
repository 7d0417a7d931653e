#version 460
#extension GL_GOOGLE_include_directive : require

#include "shared/frame.h"
#include "shared/gridDifference.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1, std430) readonly buffer Cells { DrawnCell cells[]; };

layout(location = 0) in uvec4 positionAndFlags;
layout(location = 1) in vec2 octahedralNormal;

layout(location = 0) out vec4 normalAndCap;

invariant gl_Position;

vec3 unfolded(vec2 code)
{
    vec3 n = vec3(code, 1.0 - abs(code.x) - abs(code.y));
    if (n.z < 0.0) {
        vec2 signs = vec2(code.x < 0.0 ? -1.0 : 1.0, code.y < 0.0 ? -1.0 : 1.0);
        n.xy = (1.0 - abs(code.yx)) * signs;
    }
    return n;
}

void main()
{
    uvec4 cell = cells[gl_InstanceIndex].lowAndExponent;
    vec3 fromEye = vec3(
        gridDifference(cell.x, positionAndFlags.x, cell.w, frame.eyeLow.x, frame.eyeHigh.x),
        gridDifference(cell.y, positionAndFlags.y, cell.w, frame.eyeLow.y, frame.eyeHigh.y),
        gridDifference(cell.z, positionAndFlags.z, cell.w, frame.eyeLow.z, frame.eyeHigh.z));
    gl_Position = vec4(
        dot(frame.clipX.xyz, fromEye), dot(frame.clipY.xyz, fromEye), frame.clipX.w,
        dot(frame.clipW.xyz, fromEye));

    vec3 n = unfolded(octahedralNormal);
    vec3 normal = frame.worldFromNormal[0].xyz * n.x + frame.worldFromNormal[1].xyz * n.y +
                  frame.worldFromNormal[2].xyz * n.z;
    normalAndCap = vec4(normalize(normal), (positionAndFlags.w & 2u) != 0u ? 1.0 : 0.0);
}

#version 460
#extension GL_GOOGLE_include_directive : require

// The mesh as the sun sees it: depth alone, in parallel projection.
#include "shared/frame.h"
#include "shared/gridDifference.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1, std430) readonly buffer Cells { DrawnCell cells[]; };

layout(location = 0) in uvec4 positionAndFlags;

void main()
{
    uvec4 cell = cells[gl_InstanceIndex].lowAndExponent;
    vec3 fromEye = vec3(
        gridDifference(cell.x, positionAndFlags.x, cell.w, frame.eyeLow.x, frame.eyeHigh.x),
        gridDifference(cell.y, positionAndFlags.y, cell.w, frame.eyeLow.y, frame.eyeHigh.y),
        gridDifference(cell.z, positionAndFlags.z, cell.w, frame.eyeLow.z, frame.eyeHigh.z));
    gl_Position = vec4(
        dot(frame.shadowFromGrid[0].xyz, fromEye) + frame.shadowFromGrid[0].w,
        dot(frame.shadowFromGrid[1].xyz, fromEye) + frame.shadowFromGrid[1].w,
        dot(frame.shadowFromGrid[2].xyz, fromEye) + frame.shadowFromGrid[2].w, 1.0);
}

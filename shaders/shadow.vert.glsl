#version 460
#extension GL_GOOGLE_include_directive : require

// The mesh as the sun sees it: depth alone, in parallel projection.
#include "include/meshVertex.glsl"

void main()
{
    vec3 fromEye = fromEyeIn(cells[gl_InstanceIndex].lowAndExponent);
    gl_Position = vec4(
        dot(frame.shadowFromGrid[0].xyz, fromEye) + frame.shadowFromGrid[0].w,
        dot(frame.shadowFromGrid[1].xyz, fromEye) + frame.shadowFromGrid[1].w,
        dot(frame.shadowFromGrid[2].xyz, fromEye) + frame.shadowFromGrid[2].w, 1.0);
}

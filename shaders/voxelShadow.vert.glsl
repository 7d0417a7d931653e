#version 460
#extension GL_GOOGLE_include_directive : require

// A voxel as the sun sees it: its three faces towards the sun, in parallel projection. All three of
// them, whatever the model shows: no ray of light slips through where a coarser voxel has none.
#include "include/voxel.glsl"

// So many of its edges a voxel is moved away from the sun, or the steps of a slope would shade each
// other and spot it.
const float kBehind = 3.0;

void main()
{
    DrawnChunk chunk = chunks[gl_InstanceIndex];
    uint corner = uint(gl_VertexIndex);
    uint voxel = corner / kCornersOfVoxel;
    corner -= voxel * kCornersOfVoxel;

    ivec3 at = placeOf(words[chunk.place.x + 2u * voxel]);
    ivec3 upper = at >> 7;
    uint octant = uint(upper.x | (upper.y << 1) | (upper.z << 2));
    if (((chunk.box.y >> (kChunkOctantsShift + octant)) & 1u) == 0u) {
        gl_Position = vec4(0.0, 0.0, -1.0, 1.0);
        return;
    }
    vec3 sun = frame.sunDirection.xyz;
    uint axis = corner >> 2u;
    vec3 side = vec3(0.0);
    side[axis] = sun[axis] > 0.0 ? 1.0 : 0.0;
    side[axis == 0u ? 1 : 0] = float(corner & 1u);
    side[axis == 2u ? 1 : 2] = float((corner >> 1u) & 1u);
    Cube cube = cubeAt(chunk, at, at);
    float size = float(1 << chunk.cornerAndLevel.w);
    vec3 fromEye = (mix(cube.low, cube.high, bvec3(side)) - kBehind * size * sun) * view.eye.w;
    gl_Position = vec4(
        dot(frame.shadowFromWorld[0].xyz, fromEye) + frame.shadowFromWorld[0].w,
        dot(frame.shadowFromWorld[1].xyz, fromEye) + frame.shadowFromWorld[1].w,
        dot(frame.shadowFromWorld[2].xyz, fromEye) + frame.shadowFromWorld[2].w, 1.0);
}

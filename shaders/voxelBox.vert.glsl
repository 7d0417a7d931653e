#version 460
#extension GL_GOOGLE_include_directive : require

// A box around a chunk's voxels, half a voxel larger so that rounding can't make it smaller, to
// find out whether any of it may be seen.
#include "include/voxel.glsl"

layout(location = 0) flat out uint drawn;

void main()
{
    drawn = gl_InstanceIndex;
    DrawnChunk chunk = chunks[gl_InstanceIndex];
    Cube cube = cubeAt(chunk, placeOf(chunk.box.x), placeOf(chunk.box.y));
    float more = 0.5 * float(1 << chunk.cornerAndLevel.w);
    // Two triangles for each of six faces: an axis, a side, and corners across it.
    uint face = uint(gl_VertexIndex) / 6u;
    uint corner = uint(gl_VertexIndex) % 6u;
    corner = corner < 3u ? corner : 6u - corner;
    uint axis = face >> 1u;
    vec3 side = vec3(0.0);
    side[axis] = float(face & 1u);
    side[axis == 0u ? 1 : 0] = float(corner & 1u);
    side[axis == 2u ? 1 : 2] = float((corner >> 1u) & 1u);
    gl_Position = clipped(mix(cube.low - more, cube.high + more, bvec3(side)));
}

#version 460
#extension GL_GOOGLE_include_directive : require

// A node's three faces towards the eye, four corners each, from its place alone. Faces that it
// doesn't have shrink to nothing.
#include "include/voxel.glsl"

layout(location = 0) flat out uint name;
layout(location = 1) flat out uint pictures;

invariant gl_Position;

void main()
{
    DrawnChunk chunk = chunks[gl_InstanceIndex];
    uint corner = uint(gl_VertexIndex);
    uint voxel = corner / kCornersOfVoxel;
    corner -= voxel * kCornersOfVoxel;
    name = nameOf(chunk, voxel);

    uint faces;
    Cube cube = nodeOf(chunk, voxel, faces);
    uint axis = corner >> 2u;
    uint shown = (faces & facesTowardsEye(cube)) >> (2u * axis);
    pictures = picturesOf(chunk, packedPlaceOf(chunk, voxel));
    if ((shown & 3u) == 0u || pictures == 0u) {
        gl_Position = vec4(0.0, 0.0, -1.0, 1.0);
        return;
    }
    vec3 side = vec3(0.0);
    side[axis] = (shown & 2u) != 0u ? 1.0 : 0.0;
    side[axis == 0u ? 1 : 0] = float(corner & 1u);
    side[axis == 2u ? 1 : 2] = float((corner >> 1u) & 1u);
    gl_Position = clipped(mix(cube.low, cube.high, bvec3(side)));
}

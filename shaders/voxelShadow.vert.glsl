#version 460
#extension GL_GOOGLE_include_directive : require

// A voxel as the sun sees it: its three faces towards the sun, in parallel projection. All three of
// them, whatever the model shows: no ray of light slips through where a coarser voxel has none.
// Where meshes have a place in the present picture, they cast its shadows.
#include "include/voxel.glsl"

// The steps of a slope would shade each other and spot it. So a voxel that looks at the sun is
// moved into the ground by so many of its edges, which is from the highest corner of an even slope
// to its deepest notch: away from the sun, as that moves no outline, but where the sun is low no
// further than this, and then along its normal.
const float kBelow = 2.5;
const float kFarthest = 6.0;
// One that looks away stays below what is lit.
const float kBehind = 3.0;

vec3 normalOf(DrawnChunk chunk, uint voxel)
{
    uint word = words[chunk.place.x + 2u * voxel + 1u];
    // the mean of all its faces
    if ((word & kHasFaces) != 0u)
        word = words[chunk.place.x + (word & ~kHasFaces)];
    return normalIn(word);
}

bool castsAt(DrawnChunk chunk, ivec3 at)
{
    if (((chunk.box.x >> kChunkPicturesShift) & kLooksUp) == 0u)
        return true;
    ivec3 low = chunk.cornerAndLevel.xyz + view.cell.xyz + (at << chunk.cornerAndLevel.w);
    return (voxelsHave(low >> int(frame.blockCount.w)) & kInPresent) != 0u;
}

void main()
{
    DrawnChunk chunk = chunks[gl_InstanceIndex];
    uint corner = uint(gl_VertexIndex);
    uint voxel = corner / kCornersOfVoxel;
    corner -= voxel * kCornersOfVoxel;

    ivec3 at = placeOf(words[chunk.place.x + 2u * voxel]);
    ivec3 upper = at >> 7;
    uint octant = uint(upper.x | (upper.y << 1) | (upper.z << 2));
    bool isOwn = ((chunk.box.y >> (kChunkOctantsShift + octant)) & 1u) != 0u;
    if (!isOwn || !castsAt(chunk, at)) {
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
    vec3 normal = normalOf(chunk, voxel);
    float toSun = dot(normal, sun);
    float behind = toSun > 0.0 ? min(kBelow / max(toSun, 0.1), kFarthest) : kBehind;
    float below = toSun > 0.0 ? max(kBelow - behind * toSun, 0.0) : 0.0;
    vec3 moved = behind * sun + below * normal;
    vec3 fromEye = (mix(cube.low, cube.high, bvec3(side)) - size * moved) * view.eye.w;
    gl_Position = vec4(
        dot(frame.shadowFromWorld[0].xyz, fromEye) + frame.shadowFromWorld[0].w,
        dot(frame.shadowFromWorld[1].xyz, fromEye) + frame.shadowFromWorld[1].w,
        dot(frame.shadowFromWorld[2].xyz, fromEye) + frame.shadowFromWorld[2].w, 1.0);
}

#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

// Draws small voxels without a rasteriser: one thread for each goes over the pixels that it may
// cover, meets its cube exactly with their rays, and keeps the nearest by one atomic maximum of
// depth (reversed, so larger is nearer; its bits order as the number does) and name.
//
// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
// section 5, name compute shaders as what could replace their rasterised voxels.
#include "include/voxel.glsl"

layout(local_size_x = 256) in;

layout(set = 0, binding = 5, std430) buffer Splats { uint64_t splats[]; };
layout(set = 0, binding = 6, std430) readonly buffer Visible { uint visible[]; };

layout(push_constant) uniform Constants {
    uint firstBlock;
    uint blockCount;
    uint onlyVisible; // 1: only chunks whose flag is set
};

// Pixels of which a sample may lie in the cube's picture: from xy to zw, none if that is before.
ivec4 reachOf(Cube cube)
{
    const ivec4 kNone = ivec4(0, 0, -1, -1);
    ivec4 all = ivec4(0, 0, ivec2(frame.picture.xy) - 1);
    vec2 least = vec2(1e30);
    vec2 most = vec2(-1e30);
    vec4 outside = vec4(1e30);
    float nearest = 1e30;
    float farthest = -1e30;
    for (int i = 0; i < 8; ++i) {
        vec4 corner = clipped(mix(cube.low, cube.high, bvec3(i & 1, i & 2, i & 4)));
        vec2 at = corner.xy / corner.w;
        least = min(least, at);
        most = max(most, at);
        nearest = min(nearest, corner.w);
        farthest = max(farthest, corner.w);
        // How far the corner is beyond each side; of the cube, its least.
        outside = min(outside, vec4(corner.xy, -corner.xy) - corner.w);
    }
    if (farthest < view.clipX.w || any(greaterThan(outside, vec4(0.0))))
        return kNone;
    // In part behind the eye: the corners' pictures say nothing.
    if (nearest < view.clipX.w)
        return all;
    // A hundredth of a pixel more, for rounding; the rays decide.
    float reach = frame.sampling.y;
    vec2 from = ceil((least * 0.5 + 0.5) * frame.picture.xy - 0.51 - reach);
    vec2 to = floor((most * 0.5 + 0.5) * frame.picture.xy - 0.49 + reach);
    return ivec4(
        ivec2(clamp(from, vec2(0.0), frame.picture.xy)),
        ivec2(clamp(to, vec2(-1.0), frame.picture.xy - 1.0)));
}

// Whether a ray meets a face that is shown; how near, as reversed depth.
bool meets(Cube cube, uint shown, vec3 ray, out float depth)
{
    vec3 leaves;
    vec3 enters = entersOf(cube, ray, leaves);
    float entry = max(enters.x, max(enters.y, enters.z));
    if (entry > min(leaves.x, min(leaves.y, leaves.z)))
        return false;
    int axis = enters.x == entry ? 0 : enters.y == entry ? 1 : 2;
    if (((shown >> (2 * axis)) & 3u) == 0u)
        return false;
    depth = view.clipX.w / (entry * view.eye.w);
    return depth > 0.0 && depth <= 1.0;
}

void main()
{
    uint block = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (block >= blockCount)
        return;
    uvec2 start = blocks[firstBlock + block].chunkAndVoxel;
    DrawnChunk chunk = chunks[start.x];
    uint voxel = start.y + gl_LocalInvocationID.x;
    if (voxel >= chunk.place.z || (onlyVisible != 0u && visible[start.x] == 0u))
        return;
    uint faces;
    Cube cube = nodeOf(chunk, voxel, faces);
    uint shown = faces & facesTowardsEye(cube);
    if (shown == 0u)
        return;
    ivec4 reach = reachOf(cube);
    uint64_t name = uint64_t(nameOf(chunk, voxel));
    uint pictures = picturesOf(chunk, packedPlaceOf(chunk, voxel));
    bool fades = pictures != kInBoth;
    uint count = uint(frame.sampling.x);

    for (int y = reach.y; y <= reach.w; ++y) {
        for (int x = reach.x; x <= reach.z; ++x) {
            if (fades && !isShownAt(uvec2(x, y), pictures))
                continue;
            uint place = (uint(y) * uint(frame.picture.x) + uint(x)) * count;
            for (uint i = 0u; i < count; ++i) {
                vec2 pixel = vec2(x, y) + 0.5 + frame.samples[i].xy;
                float depth;
                if (!meets(cube, shown, rayThrough(pixel), depth))
                    continue;
                uint64_t key = (uint64_t(floatBitsToUint(depth)) << 32) | name;
                atomicMax(splats[place + i], key);
            }
        }
    }
}

#version 460
#extension GL_GOOGLE_include_directive : require

// Finds the voxel that is nearest to the eye in a picture, and how many pixels show it: each group
// the least of depth and name among its pixels, then one group the least of all groups', then all
// the pixels of that name. No atomics of 64 bits, and the same whatever the order of threads.
//
// Source: S. Jablonski and T. Martyn, "Real-time rendering of continuous levels of detail for
// sparse voxel octrees", section 5, its accurate evaluation. Differs: names are whole numbers, not
// colours, and of equally near voxels the one with the least is taken.
#include "shared/pattern.h"

layout(local_size_x = 256) in;

// Of pictures with several samples a pixel, the first ones are taken.
#ifdef ISOFRONT_SAMPLES
layout(set = 0, binding = 0) uniform usampler2DMS names;
layout(set = 0, binding = 1) uniform sampler2DMS depths;
#else
layout(set = 0, binding = 0) uniform usampler2D names;
layout(set = 0, binding = 1) uniform sampler2D depths;
#endif
layout(set = 0, binding = 2, std430) buffer Found { Pattern found; };
layout(set = 0, binding = 3, std430) buffer Partial { uvec2 partial[]; };

layout(push_constant) uniform Constants { PatternStep todo; };

shared uvec2 nearest[256];
shared uint counts[256];

bool isBefore(uvec2 a, uvec2 b)
{
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Depth, nearer is less, then name; the greatest where no voxel is.
uvec2 keyAt(uint pixel)
{
    ivec2 at = ivec2(pixel % todo.width, pixel / todo.width);
    uint name = texelFetch(names, at, 0).r;
    if (name == 0u)
        return uvec2(0xffffffffu);
    return uvec2(~floatBitsToUint(texelFetch(depths, at, 0).r), name);
}

uvec2 leastOfGroup(uvec2 mine)
{
    uint me = gl_LocalInvocationIndex;
    nearest[me] = mine;
    barrier();
    for (uint count = 128u; count > 0u; count /= 2u) {
        if (me < count && isBefore(nearest[me + count], nearest[me]))
            nearest[me] = nearest[me + count];
        barrier();
    }
    return nearest[0];
}

uint sumOfGroup(uint mine)
{
    uint me = gl_LocalInvocationIndex;
    counts[me] = mine;
    barrier();
    for (uint count = 128u; count > 0u; count /= 2u) {
        if (me < count)
            counts[me] += counts[me + count];
        barrier();
    }
    uint sum = counts[0];
    barrier();
    return sum;
}

void main()
{
    uint pixels = todo.width * todo.height;
    uint first = gl_GlobalInvocationID.x;
    uint stride = todo.groups * 256u;
    bool leads = gl_LocalInvocationIndex == 0u;
    if (todo.stage == kPatternOfGroups) {
        uvec2 least = uvec2(0xffffffffu);
        for (uint pixel = first; pixel < pixels; pixel += stride) {
            uvec2 key = keyAt(pixel);
            if (isBefore(key, least))
                least = key;
        }
        least = leastOfGroup(least);
        if (leads)
            partial[gl_WorkGroupID.x] = least;
    } else if (todo.stage == kPatternOfAll) {
        uvec2 least = uvec2(0xffffffffu);
        for (uint group = gl_LocalInvocationIndex; group < todo.groups; group += 256u)
            if (isBefore(partial[group], least))
                least = partial[group];
        least = leastOfGroup(least);
        if (leads) {
            found.nearest = least;
            found.pixels = 0u;
            found.voxelPixels = 0u;
        }
    } else {
        uint name = found.nearest.y;
        uint own = 0u;
        uint all = 0u;
        for (uint pixel = first; pixel < pixels; pixel += stride) {
            uint shown = texelFetch(names, ivec2(pixel % todo.width, pixel / todo.width), 0).r;
            all += shown == 0u ? 0u : 1u;
            own += shown == 0u || shown != name ? 0u : 1u;
        }
        own = sumOfGroup(own);
        all = sumOfGroup(all);
        if (leads) {
            atomicAdd(found.pixels, own);
            atomicAdd(found.voxelPixels, all);
        }
    }
}

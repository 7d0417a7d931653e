// Surface voxels as they lie in memory, and their cubes relative to the eye.
//
// Corners are differences of integers, turned to float in one way: neighbours agree on them to the
// last bit, and so do both ways of drawing.
#ifndef ISOFRONT_VOXEL_GLSL
#define ISOFRONT_VOXEL_GLSL

#include "shared/frame.h"
#include "shared/transition.h"
#include "shared/voxels.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1) uniform ViewBlock { VoxelView view; };
layout(set = 0, binding = 2, std430) readonly buffer Chunks { DrawnChunk chunks[]; };
layout(set = 0, binding = 3, std430) readonly buffer Blocks { VoxelBlock blocks[]; };
layout(set = 0, binding = 4, std430) readonly buffer Pool { uint words[]; };

// A cube relative to the eye [voxels of level 0].
struct Cube {
    vec3 low;
    vec3 high;
};

ivec3 placeOf(uint packed)
{
    return ivec3(packed & 0xffu, (packed >> 8u) & 0xffu, (packed >> 16u) & 0xffu);
}

Cube cubeAt(DrawnChunk chunk, ivec3 from, ivec3 to)
{
    ivec3 corner = chunk.cornerAndLevel.xyz;
    int level = chunk.cornerAndLevel.w;
    return Cube(
        vec3(corner + (from << level)) - view.eye.xyz,
        vec3(corner + ((to + 1) << level)) - view.eye.xyz);
}

Cube cubeOf(DrawnChunk chunk, uint packed)
{
    ivec3 at = placeOf(packed);
    return cubeAt(chunk, at, at);
}

// The faces that a voxel has: those that are stored, and those in its chunk's border, which a
// neighbour of other detail may leave open.
uint facesOf(uint packed)
{
    ivec3 at = placeOf(packed);
    uvec3 low = uvec3(equal(at, ivec3(0)));
    uvec3 high = uvec3(equal(at, ivec3(255)));
    uint caps = low.x | (high.x << 1u) | (low.y << 2u) | (high.y << 3u) | (low.z << 4u) |
                (high.z << 5u);
    return ((packed >> 24u) & 0x3fu) | caps;
}

// How far a chunk is on its way from its parent.
float weightOf(DrawnChunk chunk)
{
    return uintBitsToFloat(chunk.box.w);
}

#define ISOFRONT_OWNERS_BINDING 8
#include "include/owners.glsl"

// The pictures that show a voxel, or a redundant node in its place: those of the chunk in which a
// block within four voxels of it is the voxels'. So voxels and meshes overlap where they meet, and
// a ray that passes between them at a low angle finds one of them.
uint picturesOf(DrawnChunk chunk, uint packed)
{
    uint pictures = chunk.box.x >> kChunkPicturesShift;
    if ((pictures & kLooksUp) == 0u)
        return pictures & kInBoth;
    int level = chunk.cornerAndLevel.w;
    int bits = int(frame.blockCount.w);
    ivec3 low = chunk.cornerAndLevel.xyz + view.cell.xyz + (placeOf(packed) << level);
    ivec3 last = ivec3(frame.blockCount.xyz) - 1;
    ivec3 from = clamp((low - (4 << level)) >> bits, ivec3(0), last);
    ivec3 to = clamp((low + (5 << level) - 1) >> bits, ivec3(0), last);
    uint shown = 0u;
    for (int z = from.z; z <= to.z; ++z)
        for (int y = from.y; y <= to.y; ++y)
            for (int x = from.x; x <= to.x; ++x)
                shown |= voxelsHave(ivec3(x, y, z));
    return pictures & shown;
}

// Where a node's place is written.
uint packedPlaceOf(DrawnChunk chunk, uint node)
{
    return node < chunk.box.z ? words[chunk.place.x + 2u * node]
                              : words[chunk.fade.y + node - chunk.box.z];
}

// Whether a pixel shows one of these pictures.
bool isShownAt(uvec2 pixel, uint pictures)
{
    return (pictures & pictureAt(pixel.x, pixel.y, frame.transition.x)) != 0u;
}

// What a chunk's node is drawn as, and its faces. A redundant one shrinks towards the side of its
// direction, which doesn't move; as voxels::fadeExtent says.
Cube nodeOf(DrawnChunk chunk, uint node, out uint faces)
{
    if (node < chunk.box.z) {
        uint packed = words[chunk.place.x + 2u * node];
        // where voxels end for the sake of meshes, one could look at sides that are never seen
        // otherwise
        bool mayEnd = ((chunk.box.x >> kChunkPicturesShift) & kLooksUp) != 0u;
        faces = mayEnd ? 0x3fu : facesOf(packed);
        return cubeOf(chunk, packed);
    }
    uint packed = words[chunk.fade.y + node - chunk.box.z];
    faces = 0x3fu;
    Cube cube = cubeOf(chunk, packed);
    int direction = int(packed >> 24u);
    vec3 high = 0.5 * vec3(direction % 3, direction / 3 % 3, direction / 9);
    float less = weightOf(chunk) * float(1 << chunk.cornerAndLevel.w);
    return Cube(cube.low + less * high, cube.high - less * (1.0 - high));
}

// Those faces of a cube whose front the eye is before: at most one along each axis.
uint facesTowardsEye(Cube cube)
{
    uvec3 low = uvec3(greaterThan(cube.low, vec3(0.0)));
    uvec3 high = uvec3(lessThan(cube.high, vec3(0.0)));
    return low.x | (high.x << 1u) | (low.y << 2u) | (high.y << 3u) | (low.z << 4u) |
           (high.z << 5u);
}

// The ray through a place in the picture [px]; its component along the forward direction is 1.
vec3 rayThrough(vec2 pixel)
{
    vec2 at = pixel * frame.picture.zw * 2.0 - 1.0;
    return frame.rayForward.xyz + at.x * frame.rayRight.xyz + at.y * frame.rayDown.xyz;
}

// When a ray from the eye comes to the planes of a cube that it meets first, along each axis. A ray
// along a plane lies on one side of it, whichever; it never divides by zero.
vec3 entersOf(Cube cube, vec3 ray, out vec3 leaves)
{
    ray = mix(ray, vec3(1e-30), lessThan(abs(ray), vec3(1e-30)));
    vec3 toLow = cube.low / ray;
    vec3 toHigh = cube.high / ray;
    leaves = max(toLow, toHigh);
    return min(toLow, toHigh);
}

// The face by which a ray enters a node that it shows. Where rounding makes it miss the cube's edge,
// the one that is nearest.
uint enteredFace(DrawnChunk chunk, uint node, vec3 ray)
{
    uint faces;
    Cube cube = nodeOf(chunk, node, faces);
    uint shown = faces & facesTowardsEye(cube);
    vec3 leaves;
    vec3 enters = entersOf(cube, ray, leaves);
    float last = -1e30;
    uint entered = 0u;
    for (uint axis = 0u; axis < 3u; ++axis) {
        uint side = (shown >> (2u * axis)) & 3u;
        if (side == 0u || enters[axis] <= last)
            continue;
        last = enters[axis];
        entered = 2u * axis + (side >> 1u);
    }
    return entered;
}

// The words of how a voxel looks: its normal, and its colour or 0.
struct Look {
    uint normal;
    uint colour;
};

// From across a face.
// @param chunk    the first word of the voxel's chunk
// @param colours  of its first colour; 0 if it has none
// @param normal   the voxel's second word
Look lookOf(uint chunk, uint colours, uint voxel, uint normal, uint face)
{
    Look look = Look(normal, colours != 0u ? words[colours + voxel] : 0u);
    if ((normal & kHasFaces) == 0u)
        return look;
    // As voxels::standardForm says.
    uint set = chunk + (normal & ~kHasFaces);
    look.normal = words[set];
    uint attributes = words[set + 1u];
    uint mask = (look.normal >> 30u) | ((attributes >> 28u) << 2u);
    if (((mask >> face) & 1u) == 0u)
        return look;
    uint before = uint(bitCount(mask & ((1u << face) - 1u)));
    uint own = chunk + (attributes & 0x0fffffffu) + 2u * before;
    return Look(words[own], words[own + 1u]);
}

// A normal as it is packed; up where there is none.
vec3 normalIn(uint word)
{
    int packed = int(word);
    vec3 normal = vec3(
        bitfieldExtract(packed, 0, 10), bitfieldExtract(packed, 10, 10),
        bitfieldExtract(packed, 20, 10));
    return dot(normal, normal) > 0.0 ? normalize(normal) : vec3(0.0, 0.0, 1.0);
}

vec4 clipped(vec3 fromEye)
{
    return vec4(
        dot(view.clipX.xyz, fromEye), dot(view.clipY.xyz, fromEye), view.clipX.w,
        dot(view.clipW.xyz, fromEye));
}

// The name of a chunk's voxel in the frame.
uint nameOf(DrawnChunk chunk, uint voxel)
{
    return (chunk.place.w << kBlockBits) + voxel + 1u;
}

#endif

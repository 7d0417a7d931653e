#version 460
#extension GL_GOOGLE_include_directive : require

// Where a voxel is seen: writes what the shading pass needs, in the mesh's way, and notes that the
// voxel's chunk is visible.
#include "include/voxel.glsl"

layout(set = 0, binding = 6, std430) buffer Visible { uint visible[]; };
layout(set = 0, binding = 7) uniform usampler2D names;

// As mesh.frag.glsl writes it; in w 1 for what has a colour of its own.
layout(location = 0) out vec4 surface;
layout(location = 1) out vec4 colour;

void main()
{
    uint name = texelFetch(names, ivec2(gl_FragCoord.xy), 0).r;
    if (name == 0u)
        discard;
    uvec2 start = blocks[(name - 1u) >> kBlockBits].chunkAndVoxel;
    uint voxel = start.y + ((name - 1u) & (kVoxelsInBlock - 1u));
    DrawnChunk chunk = chunks[start.x];
    if (visible[start.x] == 0u)
        visible[start.x] = 1u;

    int packed = int(words[chunk.place.x + 2u * voxel + 1u]);
    vec3 normal = vec3(
        bitfieldExtract(packed, 0, 10), bitfieldExtract(packed, 10, 10),
        bitfieldExtract(packed, 20, 10));
    normal = dot(normal, normal) > 0.0 ? normalize(normal) : vec3(0.0, 0.0, 1.0);
    // Of a closed model, voxels at the outline may well look away a little. What looks away more
    // belongs to a sheet that is seen from behind.
    vec2 at = gl_FragCoord.xy * frame.picture.zw * 2.0 - 1.0;
    vec3 ray = frame.rayForward.xyz + at.x * frame.rayRight.xyz + at.y * frame.rayDown.xyz;
    bool back = dot(normal, normalize(ray)) > 0.5;

    bool coloured = chunk.place.y != 0u;
    colour = coloured ? unpackUnorm4x8(words[chunk.place.y + voxel]) : vec4(0.0);
    float kind = coloured ? 1.0 : 0.25;
    surface = vec4(normal, back ? -kind : kind);
}

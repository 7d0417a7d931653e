#version 460
#extension GL_GOOGLE_include_directive : require

// Where a voxel is seen: writes what the shading pass needs, in the mesh's way, and notes that the
// voxel's chunk is visible.
#include "include/srgb.glsl"
#include "include/voxel.glsl"

layout(set = 0, binding = 6, std430) buffer Visible { uint visible[]; };
#ifdef ISOFRONT_SAMPLES
layout(set = 0, binding = 7) uniform usampler2DMS names;
#else
layout(set = 0, binding = 7) uniform usampler2D names;
#endif

// As mesh.frag.glsl writes it; in w 1 for what has a colour of its own.
layout(location = 0) out vec4 surface;
layout(location = 1) out vec4 colour;

// A colour on the way from one to another, in light.
vec4 between(vec4 from, vec4 to, float weight)
{
    vec3 light = mix(toLinear(from.rgb), toLinear(to.rgb), weight);
    return vec4(fromLinear(light), mix(from.a, to.a, weight));
}

void main()
{
    // Of samples, gl_FragCoord may be the place or the pixel's middle: only the pixel counts.
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#ifdef ISOFRONT_SAMPLES
    int index = gl_SampleID;
#else
    const int index = 0;
#endif
    uint name = texelFetch(names, pixel, index).r;
    if (name == 0u)
        discard;
    uvec2 start = blocks[(name - 1u) >> kBlockBits].chunkAndVoxel;
    uint voxel = start.y + ((name - 1u) & (kVoxelsInBlock - 1u));
    DrawnChunk chunk = chunks[start.x];
    if (visible[start.x] == 0u)
        visible[start.x] = 1u;

    vec3 ray = rayThrough(vec2(pixel) + 0.5 + frame.samples[index].xy);
    bool redundant = voxel >= chunk.box.z;
    float weight = weightOf(chunk);
    bool fades = weight < 1.0;
    uint parent = fades ? words[chunk.fade.x + voxel] : 0u;
    uint normalAbove = fades ? words[chunk.fade.z + 2u * parent + 1u] : 0u;
    uint normalOwn = redundant ? 0u : words[chunk.place.x + 2u * voxel + 1u];
    // Few voxels look different from their sides; only they ask which one is seen.
    uint face = 0u;
    if (((normalAbove | normalOwn) & kHasFaces) != 0u)
        face = enteredFace(chunk, voxel, ray);
    Look above = Look(0u, 0u);
    if (fades)
        above = lookOf(chunk.fade.z, chunk.fade.w, parent, normalAbove, face);
    Look own = above;
    if (!redundant)
        own = lookOf(chunk.place.x, chunk.place.y, voxel, normalOwn, face);

    vec3 normal = normalIn(own.normal);
    if (fades && !redundant) {
        vec3 mixed = mix(normalIn(above.normal), normal, weight);
        normal = dot(mixed, mixed) > 1e-12 ? normalize(mixed) : normal;
    }
    // Of a closed model, voxels at the outline may well look away a little. What looks away more
    // belongs to a sheet that is seen from behind.
    bool back = dot(normal, normalize(ray)) > 0.5;

    bool coloured = chunk.place.y != 0u;
    colour = coloured ? unpackUnorm4x8(own.colour) : vec4(0.0);
    if (coloured && !redundant && fades && chunk.fade.w != 0u)
        colour = between(unpackUnorm4x8(above.colour), colour, weight);
    float kind = coloured ? 1.0 : 0.25;
    surface = vec4(normal, back ? -kind : kind);
}

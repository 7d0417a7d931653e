#version 460
#extension GL_GOOGLE_include_directive : require

// An object before a neutral wall: key, fill and rim light, soft highlights. Both sides are shown,
// because a scan may be cut open.
#include "include/shading.glsl"

vec3 backgroundAt(vec2 pixel)
{
    vec2 at = pixel * frame.picture.zw * 2.0 - 1.0;
    float centre = exp(-0.9 * dot(at * vec2(0.9, 0.8), at));
    return mix(vec3(0.035, 0.037, 0.042), vec3(0.16, 0.165, 0.175), centre);
}

// Light from a direction on a rough, slightly glossy surface.
vec3 lightFrom(vec3 direction, vec3 light, vec3 normal, vec3 toEye, vec3 albedo, float gloss)
{
    float facing = max(dot(normal, direction), 0.0);
    float soft = facing * 0.85 + 0.15 * smoothstep(-0.4, 1.0, dot(normal, direction));
    vec3 halfway = normalize(direction + toEye);
    float highlight = pow(max(dot(normal, halfway), 0.0), 42.0) * gloss * step(0.0, facing);
    return light * (albedo * soft + highlight * facing);
}

vec3 lightOf(Seen seen)
{
    if (seen.depth <= 0.0)
        return toneMapped(backgroundAt(seen.at));

    vec4 surface = seen.surface;
    bool back = surface.w < 0.0;
    bool coloured = isColoured(surface.w);
    bool cap = abs(surface.w) > 0.4 && !coloured;
    vec3 normal = normalize(back ? -surface.xyz : surface.xyz);
    vec3 toEye = -normalize(pixelRay(seen.at));
    vec3 right = normalize(frame.rayRight.xyz);
    vec3 down = normalize(frame.rayDown.xyz);
    vec3 forward = normalize(frame.rayForward.xyz);

    vec3 albedo = cap ? frame.colours[1].rgb : frame.colours[0].rgb;
    if (coloured)
        albedo = ownAlbedo(seen);
    // The inside of a surface is a shade darker and warmer than the outside.
    if (back)
        albedo *= vec3(0.62, 0.5, 0.45);
    float gloss = cap ? 0.02 : 0.22;
    vec3 key = normalize(-0.55 * right - 0.75 * down - 0.55 * forward);
    vec3 fill = normalize(0.9 * right - 0.1 * down - 0.5 * forward);
    vec3 rim = normalize(0.35 * right - 0.6 * down + 0.9 * forward);
    vec3 light = lightFrom(key, vec3(0.80, 0.76, 0.71), normal, toEye, albedo, gloss);
    light += lightFrom(fill, vec3(0.15, 0.18, 0.22), normal, toEye, albedo, 0.5 * gloss);
    light += lightFrom(rim, vec3(0.5, 0.52, 0.55), normal, toEye, albedo, gloss);
    float above = 0.5 - 0.5 * dot(normal, down);
    light += albedo * mix(vec3(0.05, 0.046, 0.043), vec3(0.12, 0.127, 0.14), above);
    // Glancing views catch the light of the room.
    float glance = pow(1.0 - max(dot(normal, toEye), 0.0), 4.0);
    light += glance * 0.1 * vec3(0.8, 0.9, 1.0) * (cap ? 0.2 : 1.0);
    return toneMapped(light);
}

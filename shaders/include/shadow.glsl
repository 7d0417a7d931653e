// How much light reaches a place, by the shadow map of the picture that a pixel shows.
#ifndef ISOFRONT_SHADOW_GLSL
#define ISOFRONT_SHADOW_GLSL

#include "include/shading.glsl"
#include "shared/transition.h"

layout(set = 0, binding = 3) uniform sampler2D shadowImage;
layout(set = 0, binding = 5) uniform sampler2D formerShadowImage;

// Sun and sky as one texel has them: in x 1 in the sun and 0 in the shadow; in y what the sky gives.
// What takes the sun away nearby, as the roof of a cave does, takes a part of the sky with it.
vec2 texelShares(sampler2D map, ivec2 texel, float depth)
{
    // Reversed: what is nearer to the sun is larger.
    float above = (texelFetch(map, texel, 0).r - depth) * frame.shadowSize.w;
    if (above <= 0.0)
        return vec2(1.0);
    return vec2(0.0, mix(0.4, 1.0, smoothstep(0.0, 150.0, above)));
}

// @param offset  from the box's axes to the map
vec2 sharesIn(sampler2D map, vec3 offset, vec3 fromEye, vec3 normal)
{
    // A step off the surface, or its own texels would shade it.
    float width = frame.shadowSize.y;
    float toSun = dot(normal, frame.sunDirection.xyz);
    vec3 at = fromEye + (normal * (1.8 - clamp(toSun, 0.0, 1.0)) + frame.sunDirection.xyz) * width;
    vec2 place = vec2(
        dot(frame.shadowFromWorld[0].xyz, at) + offset.x,
        dot(frame.shadowFromWorld[1].xyz, at) + offset.y);
    float depth = dot(frame.shadowFromWorld[2].xyz, at) + offset.z;
    float edge = max(abs(place.x), abs(place.y));
    if (edge >= 0.99)
        return vec2(1.0);

    // A square of two texels' width around the place, weighted by the part of each texel in it.
    vec2 texel = (place * 0.5 + 0.5) * frame.shadowSize.x - 0.5;
    ivec2 base = ivec2(floor(texel));
    vec2 f = texel - vec2(base);
    vec2 sum = vec2(0.0);
    for (int y = -1; y <= 2; ++y) {
        float weightY = y == -1 ? 1.0 - f.y : y == 2 ? f.y : 1.0;
        for (int x = -1; x <= 2; ++x) {
            float weightX = x == -1 ? 1.0 - f.x : x == 2 ? f.x : 1.0;
            sum += weightX * weightY * texelShares(map, base + ivec2(x, y), depth);
        }
    }
    return mix(sum / 9.0, vec2(1.0), smoothstep(0.85, 0.99, edge));
}

// Shares of the sun's and of the sky's light; both 1 where the map ends.
// @param fromEye  [world]
vec2 lightShares(vec3 fromEye, vec3 normal)
{
    if (frame.shadowSize.z == 0.0)
        return vec2(1.0);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    if (frame.formerShadow.w != 0.0 &&
        pictureAt(pixel.x, pixel.y, frame.transition.x) == kInFormer)
        return sharesIn(formerShadowImage, frame.formerShadow.xyz, fromEye, normal);
    vec3 offset = vec3(
        frame.shadowFromWorld[0].w, frame.shadowFromWorld[1].w, frame.shadowFromWorld[2].w);
    return sharesIn(shadowImage, offset, fromEye, normal);
}

#endif

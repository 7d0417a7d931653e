#version 460
#extension GL_GOOGLE_include_directive : require

// Softens stair steps: where neighbours differ much, blends along the edge.
// Source: Lottes, "FXAA", 2009 (the short form without an edge search).
#include "shared/frame.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1) uniform sampler2D picture;

layout(location = 0) out vec4 colour;

float luma(vec3 c)
{
    return dot(c, vec3(0.299, 0.587, 0.114));
}

float lumaAt(ivec2 pixel)
{
    return luma(texelFetch(picture, clamp(pixel, ivec2(0), ivec2(frame.picture.xy) - 1), 0).rgb);
}

void main()
{
    vec2 texel = frame.picture.zw;
    vec2 at = gl_FragCoord.xy * texel;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 centre = texelFetch(picture, pixel, 0).rgb;
    float here = luma(centre);
    float northWest = lumaAt(pixel + ivec2(-1, -1));
    float northEast = lumaAt(pixel + ivec2(1, -1));
    float southWest = lumaAt(pixel + ivec2(-1, 1));
    float southEast = lumaAt(pixel + ivec2(1, 1));
    float least = min(here, min(min(northWest, northEast), min(southWest, southEast)));
    float most = max(here, max(max(northWest, northEast), max(southWest, southEast)));
    if (most - least < max(0.04, 0.125 * most)) {
        colour = vec4(centre, 1.0);
        return;
    }
    vec2 direction = vec2(
        (southWest + southEast) - (northWest + northEast),
        (northWest + southWest) - (northEast + southEast));
    float reduce = max((northWest + northEast + southWest + southEast) * 0.03125, 0.0078125);
    float scale = 1.0 / (min(abs(direction.x), abs(direction.y)) + reduce);
    direction = clamp(direction * scale, -8.0, 8.0) * texel;
    vec3 near = 0.5 * (textureLod(picture, at - direction / 6.0, 0.0).rgb +
                       textureLod(picture, at + direction / 6.0, 0.0).rgb);
    vec3 far = 0.5 * near + 0.25 * (textureLod(picture, at - direction * 0.5, 0.0).rgb +
                                    textureLod(picture, at + direction * 0.5, 0.0).rgb);
    float blended = luma(far);
    colour = vec4(blended < least || blended > most ? near : far, 1.0);
}

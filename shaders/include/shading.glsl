// What the shading passes of all looks share: their inputs, and the way from light to bytes.
#ifndef ISOFRONT_SHADING_GLSL
#define ISOFRONT_SHADING_GLSL

#include "shared/frame.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1) uniform sampler2D depthImage;
layout(set = 0, binding = 2) uniform sampler2D surfaceImage;
layout(set = 0, binding = 4) uniform sampler2D colourImage;

layout(location = 0) out vec4 colour;

// The ray through the pixel [world]; its component along the forward direction is 1.
vec3 pixelRay(vec2 pixel)
{
    vec2 at = pixel * frame.picture.zw * 2.0 - 1.0;
    return frame.rayForward.xyz + at.x * frame.rayRight.xyz + at.y * frame.rayDown.xyz;
}

// How far along the pixel's ray the surface is: reversed depth is near / distance.
float rayLength(float depth)
{
    return frame.clipX.w / depth;
}

// Source: Narkowicz, "ACES Filmic Tone Mapping Curve", 2016.
vec3 toneMapped(vec3 light)
{
    vec3 x = light * frame.sunDirection.w;
    return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 encoded(vec3 linear)
{
    vec3 high = 1.055 * pow(max(linear, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * linear, lessThan(linear, vec3(0.0031308)));
}

// Whether a surface has a colour of its own, by the kind that is written with its normal.
bool isColoured(float kind)
{
    return abs(kind) > 0.7;
}

// The albedo of a surface with a colour of its own.
vec3 ownAlbedo(ivec2 pixel)
{
    vec3 bytes = texelFetch(colourImage, pixel, 0).rgb;
    vec3 high = pow((bytes + 0.055) / 1.055, vec3(2.4));
    return mix(high, bytes / 12.92, lessThanEqual(bytes, vec3(0.04045)));
}

// Half a step of noise, fixed to the pixel, so that smooth gradients show no bands.
// Source: Jimenez, "Next Generation Post Processing in Call of Duty", 2014 (interleaved gradient
// noise).
vec3 dithered(vec3 bytes)
{
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    return bytes + (noise - 0.5) / 255.0;
}

vec4 finished(vec3 light)
{
    return vec4(dithered(encoded(toneMapped(light))), 1.0);
}

#endif

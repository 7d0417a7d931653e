// What the shading passes of all looks share: their inputs, the pixels' samples, and the way from
// light to bytes. A look defines `lightOf`.
#ifndef ISOFRONT_SHADING_GLSL
#define ISOFRONT_SHADING_GLSL

#include "shared/frame.h"

layout(set = 0, binding = 0) uniform FrameBlock { Frame frame; };
#ifdef ISOFRONT_SAMPLES
#define PICTURE sampler2DMS
#else
#define PICTURE sampler2D
#endif
layout(set = 0, binding = 1) uniform PICTURE depthImage;
layout(set = 0, binding = 2) uniform PICTURE surfaceImage;
layout(set = 0, binding = 4) uniform PICTURE colourImage;

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

// What a sample of the picture shows.
struct Seen {
    vec2 at;      // [px]
    float depth;  // 0 where there is nothing
    vec4 surface; // as mesh.frag.glsl and voxelSurface.frag.glsl write it
    vec3 own;     // colour of its own, if it has one: sRGB
};

// Light as it is displayed, linear.
vec3 lightOf(Seen seen);

// The albedo of a surface with a colour of its own.
vec3 ownAlbedo(Seen seen)
{
    vec3 bytes = seen.own;
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

Seen seenAt(ivec2 pixel, int index)
{
    Seen seen;
    seen.at = gl_FragCoord.xy;
#ifdef ISOFRONT_SAMPLES
    seen.at += frame.samples[index].xy;
#endif
    seen.depth = texelFetch(depthImage, pixel, index).r;
    seen.surface = texelFetch(surfaceImage, pixel, index);
    seen.own = texelFetch(colourImage, pixel, index).rgb;
    return seen;
}

// What lies behind everything is shown as it is if it has one flat colour.
bool isFlat(Seen seen)
{
    return seen.depth <= 0.0 && frame.backdrop.w > 0.0;
}

vec3 displayedLight(Seen seen)
{
    return isFlat(seen) ? frame.backdrop.rgb : lightOf(seen);
}

vec4 finished(vec3 light, bool flatColour)
{
    vec3 bytes = encoded(light);
    return vec4(flatColour ? bytes : dithered(bytes), 1.0);
}

#ifdef ISOFRONT_SAMPLES
// Whether two samples of a pixel get the same light, nearly: of one smooth surface. So a pixel
// costs more than one only where it has an edge.
bool isAlike(Seen a, Seen b)
{
    if (a.depth <= 0.0 || b.depth <= 0.0)
        return a.depth <= 0.0 && b.depth <= 0.0;
    return a.surface.w == b.surface.w && abs(a.depth - b.depth) < 0.02 * max(a.depth, b.depth) &&
           dot(a.surface.xyz, b.surface.xyz) > 0.9998 &&
           (!isColoured(a.surface.w) || a.own == b.own);
}

// The mean of a pixel's samples, of light as it is displayed: bright edges stay smooth.
void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int count = int(frame.sampling.x);
    uint done = 0u;
    vec3 sum = vec3(0.0);
    bool flatColour = true;
    for (int i = 0; i < count; ++i) {
        if (((done >> i) & 1u) != 0u)
            continue;
        Seen seen = seenAt(pixel, i);
        float alike = 1.0;
        for (int j = i + 1; j < count; ++j) {
            if (((done >> j) & 1u) != 0u || !isAlike(seen, seenAt(pixel, j)))
                continue;
            done |= 1u << j;
            alike += 1.0;
        }
        sum += alike * displayedLight(seen);
        flatColour = flatColour && isFlat(seen);
    }
    colour = finished(sum / float(count), flatColour);
}
#else
void main()
{
    Seen seen = seenAt(ivec2(gl_FragCoord.xy), 0);
    colour = finished(displayedLight(seen), isFlat(seen));
}
#endif

#endif

// Light scattered by the air, once, with a constant density along the ray.
// Based on: Hoffman, Preetham, "Rendering Outdoor Light Scattering in Real Time", 2002. Differs: a
// part of the sky's light is added without direction, for what is scattered more than once.
#ifndef ISOFRONT_ATMOSPHERE_GLSL
#define ISOFRONT_ATMOSPHERE_GLSL

#include "include/shading.glsl"

const float kPi = 3.14159265;
// Thickness of the air and of the haze, if they were as dense everywhere as on the ground [m].
const float kAirThickness = 8400.0;
const float kHazeThickness = 1250.0;

// How much more air there is along a ray than straight up.
// Source: Kasten, Young, "Revised optical air mass tables", 1989.
float airMass(float sineOfElevation)
{
    float sine = clamp(sineOfElevation, 0.0, 1.0);
    float degrees = asin(sine) * (180.0 / kPi);
    return 1.0 / (sine + 0.50572 * pow(degrees + 6.07995, -1.6364));
}

// The light that a long way through the air sends from a direction to the eye. Tends to be the colour
// of the horizon.
vec3 scatteredLight(vec3 direction)
{
    float cosine = dot(direction, frame.sunDirection.xyz);
    float airPhase = 3.0 / (16.0 * kPi) * (1.0 + cosine * cosine);
    const float g = 0.76;
    float base = 1.0 + g * g - 2.0 * g * cosine;
    float hazePhase = (1.0 - g * g) / (4.0 * kPi * base * sqrt(base));
    vec3 air = frame.airScattering.xyz;
    vec3 haze = frame.hazeScattering.xyz;
    vec3 once = frame.sunLight.xyz * (air * airPhase + haze * hazePhase) / (air + haze);
    return once + 0.35 * frame.skyLight.xyz;
}

vec3 skyLight(vec3 direction)
{
    float sine = dot(direction, frame.up.xyz);
    // Below the horizon the sky goes on as haze over a ground that is out of sight.
    float mass = airMass(sine);
    vec3 depth = (frame.airScattering.xyz * kAirThickness +
                  frame.hazeScattering.xyz * kHazeThickness) *
                 mass;
    return scatteredLight(direction) * (1.0 - exp(-depth));
}

vec3 sunDisc(vec3 direction)
{
    float cosine = dot(direction, frame.sunDirection.xyz);
    float disc = smoothstep(0.99996, 0.99999, cosine);
    float glow = pow(max(cosine, 0.0), 800.0) * 0.3 + pow(max(cosine, 0.0), 60.0) * 0.03;
    return frame.sunLight.xyz * (disc * 40.0 + glow);
}

// What remains of a surface's light after the way to the eye.
// @param heights  of the eye and of the surface above the base [m]
vec3 transmittance(float distance, float eyeHeight, float surfaceHeight)
{
    // Mean density along the ray, thinning exponentially with the height.
    float scale = frame.airScattering.w;
    float from = exp(-max(eyeHeight, -2.0 * scale) / scale);
    float rise = (surfaceHeight - eyeHeight) / scale;
    float density = abs(rise) < 1e-3 ? from : from * (1.0 - exp(-rise)) / rise;
    vec3 extinction = (frame.airScattering.xyz + frame.hazeScattering.xyz) * frame.hazeScattering.w;
    return exp(-extinction * (distance * clamp(density, 0.0, 8.0)));
}

#endif

// Value noise on a lattice that repeats: places far from any origin look as good as near ones.
#ifndef ISOFRONT_NOISE_GLSL
#define ISOFRONT_NOISE_GLSL

// After this many metres the noise repeats. A power of two, as are all wavelengths.
const float kNoisePeriod = 4096.0;

uint hashed(uvec3 cell)
{
    // Source: Jarzynski, Olano, "Hash Functions for GPU Rendering", 2020 (the idea of pcg3d, one
    // word of it).
    uvec3 v = cell * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.x ^= v.z >> 15u;
    return v.x * 2246822519u + v.y;
}

float cornerValue(uvec3 cell, uint mask)
{
    return float(hashed(cell & uvec3(mask)) >> 8u) * (1.0 / 16777216.0);
}

// A value in [-1, 1] and its gradient in the units of `p`.
// @param p     [wavelengths]
// @param mask  wavelengths in the period, less one
vec4 noiseWithGradient(vec3 p, uint mask)
{
    vec3 base = floor(p);
    vec3 f = p - base;
    uvec3 cell = uvec3(ivec3(base));
    vec3 u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    vec3 du = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    float a = cornerValue(cell, mask);
    float b = cornerValue(cell + uvec3(1, 0, 0), mask);
    float c = cornerValue(cell + uvec3(0, 1, 0), mask);
    float d = cornerValue(cell + uvec3(1, 1, 0), mask);
    float e = cornerValue(cell + uvec3(0, 0, 1), mask);
    float g = cornerValue(cell + uvec3(1, 0, 1), mask);
    float h = cornerValue(cell + uvec3(0, 1, 1), mask);
    float i = cornerValue(cell + uvec3(1, 1, 1), mask);
    float k1 = b - a;
    float k2 = c - a;
    float k3 = e - a;
    float k4 = a - b - c + d;
    float k5 = a - c - e + h;
    float k6 = a - b - e + g;
    float k7 = -a + b + c - d + e - g - h + i;
    float value = a + k1 * u.x + k2 * u.y + k3 * u.z + k4 * u.x * u.y + k5 * u.y * u.z +
                  k6 * u.z * u.x + k7 * u.x * u.y * u.z;
    vec3 gradient = du * vec3(
                             k1 + k4 * u.y + k6 * u.z + k7 * u.y * u.z,
                             k2 + k5 * u.z + k4 * u.x + k7 * u.z * u.x,
                             k3 + k6 * u.x + k5 * u.y + k7 * u.x * u.y);
    return vec4(2.0 * value - 1.0, 2.0 * gradient);
}

// One octave: noise of a wavelength at an eye-relative place, faded where pixels are too coarse.
// @param phase      the eye's position modulo the period [m]
// @param footprint  width of a pixel there [m]
vec4 octave(vec3 phase, vec3 fromEye, float wavelength, float footprint)
{
    float fade = 1.0 - smoothstep(0.2, 0.6, footprint / wavelength);
    if (fade <= 0.0)
        return vec4(0.0);
    uint mask = uint(kNoisePeriod / wavelength) - 1u;
    return fade * noiseWithGradient((phase + fromEye) / wavelength, mask);
}

#endif

// Codes of sRGB, from 0 to 1, and the light that they stand for.
#ifndef ISOFRONT_SRGB_GLSL
#define ISOFRONT_SRGB_GLSL

vec3 toLinear(vec3 code)
{
    vec3 high = pow((code + 0.055) / 1.055, vec3(2.4));
    return mix(high, code / 12.92, lessThanEqual(code, vec3(0.04045)));
}

vec3 fromLinear(vec3 light)
{
    vec3 high = 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * light, lessThanEqual(light, vec3(0.0031308)));
}

#endif

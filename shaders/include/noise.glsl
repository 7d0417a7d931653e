// Value noise on a lattice that repeats: places far from any origin look as good as near ones.
#ifndef ISOFRONT_NOISE_GLSL
#define ISOFRONT_NOISE_GLSL

// After this many metres the noise repeats. A power of two, as are all wavelengths.
const float kNoisePeriod = 4096.0;

// From products of a cell's coordinates, of which neighbours share most, to a value in [0, 1].
float cornerValue(uint product)
{
    uint h = product ^ (product >> 15u);
    h *= 0x2c1b3c6du;
    h ^= h >> 12u;
    h *= 0x297a2d39u;
    return float(h >> 8u) * (1.0 / 16777216.0);
}

// A value in [-1, 1] and its gradient in the units of `p`.
// @param p     [wavelengths]
// @param mask  wavelengths in the period, less one
vec4 noiseWithGradient(vec3 p, uint mask)
{
    vec3 base = floor(p);
    vec3 f = p - base;
    uvec3 low = uvec3(ivec3(base)) & uvec3(mask);
    uvec3 high = (low + 1u) & uvec3(mask);
    vec3 u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    vec3 du = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    const uvec3 kPrimes = uvec3(0x9e3779b1u, 0x85ebca77u, 0xc2b2ae3du);
    low *= kPrimes;
    high *= kPrimes;
    float a = cornerValue(low.x ^ low.y ^ low.z);
    float b = cornerValue(high.x ^ low.y ^ low.z);
    float c = cornerValue(low.x ^ high.y ^ low.z);
    float d = cornerValue(high.x ^ high.y ^ low.z);
    float e = cornerValue(low.x ^ low.y ^ high.z);
    float g = cornerValue(high.x ^ low.y ^ high.z);
    float h = cornerValue(low.x ^ high.y ^ high.z);
    float i = cornerValue(high.x ^ high.y ^ high.z);
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

// How much of a wavelength pixels of some width can show: 1 well above it, 0 from there on.
float shownShare(float footprint, float wavelength)
{
    return 1.0 - smoothstep(0.15, 0.5, footprint / wavelength);
}

// Octaves of noise at a place, from broad to fine, as far as pixels can show them.
struct Texture {
    float broad;  // wavelengths of 256 m and 64 m
    float middle; // 16 m and 4 m
    float fine;   // 1 m, 0.25 m and 0.06 m
    vec3 bump;    // gradient of the finer ones
};

// @param phase      the eye's position modulo the period [m]
// @param footprint  width of a pixel there [m]
// @param finest     wavelength below which there is nothing [m]
Texture textureAt(vec3 phase, vec3 fromEye, float footprint, float finest)
{
    Texture result = Texture(0.0, 0.0, 0.0, vec3(0.0));
    float wavelength = 256.0;
    vec3 shift = vec3(0.0);
    // A loop rather than a list, because it ends early where all is far away.
    for (int i = 0; i < 7 && footprint < 0.5 * wavelength && wavelength >= finest; ++i) {
        uint mask = uint(kNoisePeriod / wavelength) - 1u;
        vec4 n = shownShare(footprint, wavelength) *
                 noiseWithGradient((phase + fromEye) / wavelength + shift, mask);
        float strong = i == 6 ? 0.35 : (i & 1) == 0 ? 0.65 : 0.45;
        if (i < 2)
            result.broad += strong * n.x;
        else if (i < 4)
            result.middle += strong * n.x;
        else
            result.fine += strong * n.x;
        result.bump += (i < 2 ? 0.0 : i == 2 ? 0.25 : strong) * n.yzw;
        wavelength *= 0.25;
        // A part of a cell, so that the octaves' lattices don't lie on each other.
        shift += vec3(0.37, 0.71, 0.13);
    }
    return result;
}

// One-dimensional noise in [0, 1].
float layerNoise(float height)
{
    float base = floor(height);
    float f = height - base;
    uint layer = uint(int(base));
    float a = cornerValue(layer * 0x9e3779b1u);
    float b = cornerValue((layer + 1u) * 0x9e3779b1u);
    // Steps rather than waves: rock breaks in ledges.
    return mix(a, b, smoothstep(0.55, 0.95, f));
}

#endif

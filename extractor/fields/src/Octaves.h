#pragma once

#include "isofront/fields/Noise.h"

#include <cstdint>
#include <vector>

namespace isofront::fields {

/// One octave of noise in space. Lattice coordinates are `frequency * p + offset + 1/2`: cells are
/// counted from their middles.
struct SpaceOctave {
    double frequency[3]; ///< [cycles / field unit] along x, y and z
    double offset[3];    ///< [cells]: keeps the zeros of the octaves apart
    float amplitude;     ///< factor on the noise
    float filterCycles;  ///< filter strength times the highest frequency [cycles / field unit]
    std::uint32_t seed;
};

/// One octave of noise over the plane (x, y): lattice coordinates are `first . (x, y) + offset[0] +
/// 1/2` and `second . (x, y) + offset[1] + 1/2`.
struct PlaneOctave {
    double first[2];  ///< [cycles / field unit]
    double second[2]; ///< [cycles / field unit]
    double offset[2]; ///< [cells]
    float amplitude;
    float filterCycles;
    std::uint32_t seed;
};

/// How the octaves of a fractal sum follow from one another.
struct FractalSettings {
    double wavelength = 1; ///< of the first octave [field]
    int octaves = 1;
    double amplitude = 1;    ///< of the first octave
    double lacunarity = 2.0; ///< frequency of an octave over that of the one before
    double gain = 0.5;       ///< amplitude of an octave over that of the one before
    double stretch = 1;      ///< how much shorter the wavelength is along z than along x and y
};

/// @param filterStrength  kappa of the octaves' weights
std::vector<SpaceOctave>
spaceOctaves(const FractalSettings& settings, std::uint64_t seed, double filterStrength);

/// Each octave is turned against the one before, so that no direction of the lattice stands out.
/// @param kind  simplices have a triangular lattice, all others a square one
std::vector<PlaneOctave> planeOctaves(
    const FractalSettings& settings,
    std::uint64_t seed,
    double filterStrength,
    NoiseKind kind = NoiseKind::gradient);

/// What noise can't exceed, whatever gradients or values its corners carry: the largest magnitude,
/// slope and second derivative (spectral norm), in lattice coordinates.
struct NoiseLimits {
    float magnitude;
    float slope;
    float curvature;
};

/// Feature points of cellular noise lie this far from the middle of their cell along each axis, at
/// most [cells].
inline constexpr float kCellularJitter = 0.375F;
/// Distances in cellular noise end here [cells]: no point two cells away can be nearer than this.
inline constexpr float kCellularCap = 2.0F - 0.5F - kCellularJitter;

// The means of the distances, taken away so that the filter leaves the mean of a sum as it is.
inline constexpr float kCellularMeanSpace = 0.506F;
inline constexpr float kCellularMeanPlane = 0.411F;
inline constexpr float kBorderMeanSpace = 0.209F;
inline constexpr float kBorderMeanPlane = 0.289F;

/// No second derivative bounds a noise that has creases.
inline constexpr float kCreased = 1e30F;

constexpr NoiseLimits cellularLimits(float mean, float slope)
{
    return {mean > kCellularCap - mean ? mean : kCellularCap - mean, slope, kCreased};
}

// The maxima over all positions, directions and choices of gradients are, as magnitude, slope and
// second derivative, in space and in the plane:
//   value     1      3.7500 14.063    1      3.7500 14.063
//   gradient  1.0364 3.7500 14.466    0.6609 2.0672 8.9773
//   simplex   1      6.9669 48.252    0.7227 4.9352 36.638  (plane: along the lattice's edges)
// Here with two per cent to spare; a test searches for them again. Distances have a slope of one.
constexpr NoiseLimits spaceLimits(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return {1.02F, 3.83F, 14.4F};
    case NoiseKind::gradient:
        return {1.06F, 3.83F, 14.8F};
    case NoiseKind::simplex:
        return {1.02F, 7.11F, 49.3F};
    case NoiseKind::cellular:
        return cellularLimits(kCellularMeanSpace, 1.0F);
    case NoiseKind::border:
        return cellularLimits(kBorderMeanSpace, 2.0F);
    }
    return {};
}
constexpr NoiseLimits planeLimits(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return {1.02F, 3.83F, 14.4F};
    case NoiseKind::gradient:
        return {0.675F, 2.11F, 9.2F};
    case NoiseKind::simplex:
        return {0.738F, 5.04F, 37.4F};
    case NoiseKind::cellular:
        return cellularLimits(kCellularMeanPlane, 1.0F);
    case NoiseKind::border:
        return cellularLimits(kBorderMeanPlane, 2.0F);
    }
    return {};
}

inline constexpr NoiseLimits kSpaceNoise = spaceLimits(NoiseKind::gradient);
inline constexpr NoiseLimits kPlaneNoise = planeLimits(NoiseKind::gradient);

/// Added to the square of noise before its root is taken, so that a crease has a slope.
inline constexpr float kCreaseRounding = 0.004F;
/// How soon ridges carry further ridges.
inline constexpr float kRidgeCarry = 4.0F;

/// What billows and ridges need to know of a kind of noise; measured, and measured again by a test.
struct FractalNorms {
    float scale;               ///< 0.5 over the noise's standard deviation
    float billowMean;          ///< mean of the magnitude of the scaled noise, rounded off at zero
    float ridgeMean;           ///< mean of the square of one less that, where it is positive
    float carry = kRidgeCarry; ///< how soon ridges carry further ridges
};

constexpr FractalNorms spaceNorms(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return {1.25F, 0.423F, 0.409F};
    case NoiseKind::gradient:
        return {1.85F, 0.418F, 0.417F};
    case NoiseKind::simplex:
        return {1.27F, 0.411F, 0.430F};
    case NoiseKind::cellular:
        return {3.11F, 0.417F, 0.420F};
    case NoiseKind::border:
        return {3.03F, 0.414F, 0.419F};
    }
    return {};
}
constexpr FractalNorms planeNorms(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return {1.11F, 0.430F, 0.397F};
    case NoiseKind::gradient:
        return {2.32F, 0.419F, 0.416F};
    case NoiseKind::simplex:
        return {1.27F, 0.442F, 0.370F};
    case NoiseKind::cellular:
        return {2.88F, 0.420F, 0.412F};
    case NoiseKind::border:
        return {2.42F, 0.424F, 0.403F};
    }
    return {};
}

} // namespace isofront::fields

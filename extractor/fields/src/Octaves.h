#pragma once

#include <cstdint>
#include <vector>

namespace isofront::fields {

/// One octave of gradient noise in space. Lattice coordinates are `frequency * p + offset`.
struct SpaceOctave {
    double frequency[3]; ///< [cycles / field unit] along x, y and z
    double offset[3];    ///< [lattice cells]: keeps the zeros of the octaves apart
    float amplitude;     ///< factor on the noise
    float filterCycles;  ///< filter strength times the highest frequency [cycles / field unit]
    std::uint32_t seed;
};

/// One octave of gradient noise over the plane (x, y): lattice coordinates are
/// `first . (x, y) + offset[0]` and `second . (x, y) + offset[1]`.
struct PlaneOctave {
    double first[2];  ///< [cycles / field unit]
    double second[2]; ///< [cycles / field unit]
    double offset[2]; ///< [lattice cells]
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
std::vector<PlaneOctave>
planeOctaves(const FractalSettings& settings, std::uint64_t seed, double filterStrength);

/// What gradient noise can't exceed, whatever gradients its corners carry: the largest magnitude,
/// slope and second derivative (spectral norm), in lattice coordinates. The maxima over all
/// positions, directions and choices of gradients are 1.0364, 3.7500 and 14.466 in space and
/// 0.6609, 2.0672 and 8.9773 in the plane; here with two per cent to spare. A test searches for
/// them again.
struct NoiseLimits {
    float magnitude;
    float slope;
    float curvature;
};
inline constexpr NoiseLimits kSpaceNoise{1.06F, 3.83F, 14.8F};
inline constexpr NoiseLimits kPlaneNoise{0.675F, 2.11F, 9.2F};

} // namespace isofront::fields

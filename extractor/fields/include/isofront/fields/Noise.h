#pragma once

#include <isofront/fields/Field.h>

#include <cstdint>
#include <memory>

namespace isofront::fields {

/// What one octave of noise is made of. Lengths are in cells of its lattice; all kinds have mean 0.
enum class NoiseKind {
    value,    ///< random values at the corners of a lattice, in [-1, 1]
    gradient, ///< random slopes there (Perlin); within 1.04 in space, 0.67 in the plane
    simplex,  ///< the same on tetrahedra or triangles; within 1 in space, 0.73 in the plane
    cellular, ///< distance to the nearest of scattered points, less its mean
    border,   ///< how much farther the second nearest point is, less its mean
};

/// How octaves are put together.
enum class FractalKind {
    brownian, ///< their sum
    /// The sum of squared crests, where the noise is near zero; only ridges carry further ridges.
    ridged,
    billow, ///< the sum of their magnitudes: round hills between creases
};

/// A sum of octaves of noise.
struct NoiseSettings {
    NoiseKind kind = NoiseKind::gradient;
    FractalKind fractal = FractalKind::brownian;
    bool plane = false; ///< noise over the plane of x and y, the same at every z
    std::uint64_t seed = 1;
    double wavelength = 1; ///< of the first, longest octave [field], > 0
    int octaves = 6;       ///< 1 to 32
    double amplitude = 1;  ///< factor on the noise of the first octave
    double lacunarity = 2; ///< frequency of an octave over that of the one before, >= 1
    double gain = 0.5;     ///< amplitude of an octave over that of the one before
    /// kappa: an octave of frequency f [cycles / field unit] carries the weight
    /// exp(-(kappa f r)^2) at filter radius r. More removes aliasing and popping and costs detail;
    /// 0 turns filtering off.
    double filterStrength = 1;
};

/// The noise as a field: value, analytic gradient, and bounds that hold for any seed.
///
/// Cells of the lattice are found in double and hashed as integers, so that the noise is as good
/// ten thousand kilometres from the origin as at the origin; the noise itself is computed in float
/// (the error stays below 1e-6 of an octave's amplitude). The same bits come from every instruction
/// set. The weight is the exponential to within 1.3e-4, and exactly 0 from kappa f r = 3 on: there
/// an octave costs nothing.
///
/// Positions beyond 2^51 cells of an octave, and filter radii that are not finite, give values of
/// no meaning. The gradient leaves out how the radius changes from place to place.
std::shared_ptr<const Field> fractalNoise(const NoiseSettings& settings);

} // namespace isofront::fields

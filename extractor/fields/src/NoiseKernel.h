#pragma once

#include "Octaves.h"
#include "isofront/fields/Field.h"
#include "isofront/fields/Noise.h"

#include <vector>

namespace isofront::fields {

/// A fractal sum with its octaves drawn: those of space, or those of the plane.
struct FractalProgram {
    NoiseKind kind = NoiseKind::gradient;
    FractalKind fractal = FractalKind::brownian;
    std::vector<SpaceOctave> space;
    std::vector<PlaneOctave> plane;
};

// The weighted sum of octaves; each call runs on the best instruction set of the machine, and gives
// the same bits on all of them.

void sampleFractal(
    const FractalProgram& program, const SampleBatch& batch, std::span<float> values);
/// @param values  as `sampleFractal` gives them; or empty, if only the gradient is asked for
void gradientFractal(
    const FractalProgram& program,
    const SampleBatch& batch,
    std::span<float> values,
    const GradientSpans& gradients);
/// True if the sum over the grid can share work between samples: value and gradient noise in space,
/// on a grid whose coordinates doubles can tell apart.
bool hasCoherentGrid(const FractalProgram& program, const SampleGrid& grid);
/// The sum over such a grid, to within rounding as `sampleFractal` gives it.
void gridFractal(const FractalProgram& program, const SampleGrid& grid, std::span<float> values);
core::Interval
boundFractal(const FractalProgram& program, const core::Box& box, const core::Interval& radius);

} // namespace isofront::fields

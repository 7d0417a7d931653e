#pragma once

#include "Octaves.h"
#include "isofront/fields/Field.h"

namespace isofront::fields {

/// The weighted sum of octaves; each call runs on the best instruction set of the machine, and
/// gives the same bits on all of them.
void sampleFractal(
    std::span<const SpaceOctave> octaves, const SampleBatch& batch, std::span<float> values);
void gradientFractal(
    std::span<const SpaceOctave> octaves, const SampleBatch& batch, const GradientSpans& gradients);
core::Interval boundFractal(
    std::span<const SpaceOctave> octaves, const core::Box& box, const core::Interval& radius);

} // namespace isofront::fields

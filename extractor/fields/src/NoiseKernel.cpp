#include "NoiseKernel.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "NoiseKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "simd/Batch-inl.h"
#include "simd/Noise-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

namespace {

struct Fractal {
    std::span<const SpaceOctave> octaves;

    template <typename N>
    HWY_INLINE N at(const Point<N>& p, const Radius& radius) const
    {
        return fractalSum(octaves.data(), octaves.size(), p, radius);
    }
};

} // namespace

void sampleFractalOn(std::span<const SpaceOctave> octaves, const SampleBatch& batch, float* values)
{
    sampleBatch(Fractal{octaves}, batch, values);
}

void gradientFractalOn(
    std::span<const SpaceOctave> octaves, const SampleBatch& batch, const GradientSpans& gradients)
{
    gradientBatch(Fractal{octaves}, batch, gradients);
}

core::Interval boundFractalOn(
    std::span<const SpaceOctave> octaves, const core::Box& box, const core::Interval& radius)
{
    double sum = 0;
    for (const SpaceOctave& octave : octaves)
        sum += std::abs(double(octave.amplitude));
    return boundsOver(Fractal{octaves}, box, radius, 1e-5 * sum);
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::fields {

HWY_EXPORT(sampleFractalOn);
HWY_EXPORT(gradientFractalOn);
HWY_EXPORT(boundFractalOn);

void sampleFractal(
    std::span<const SpaceOctave> octaves, const SampleBatch& batch, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(sampleFractalOn)(octaves, batch, values.data());
}

void gradientFractal(
    std::span<const SpaceOctave> octaves, const SampleBatch& batch, const GradientSpans& gradients)
{
    HWY_DYNAMIC_DISPATCH(gradientFractalOn)(octaves, batch, gradients);
}

core::Interval boundFractal(
    std::span<const SpaceOctave> octaves, const core::Box& box, const core::Interval& radius)
{
    return HWY_DYNAMIC_DISPATCH(boundFractalOn)(octaves, box, radius);
}

} // namespace isofront::fields
#endif

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

template <typename Octave>
struct Fractal {
    NoiseKind kind;
    FractalKind fractal;
    std::span<const Octave> octaves;

    template <typename N>
    HWY_INLINE N at(const Point<N>& p, const Radius& radius) const
    {
        switch (kind) {
        case NoiseKind::value:
            return sum<NoiseKind::value>(p, radius);
        case NoiseKind::gradient:
            return sum<NoiseKind::gradient>(p, radius);
        case NoiseKind::simplex:
            return sum<NoiseKind::simplex>(p, radius);
        case NoiseKind::cellular:
            return sum<NoiseKind::cellular>(p, radius);
        case NoiseKind::border:
            return sum<NoiseKind::border>(p, radius);
        }
        return fromConstant<N>(0.0F);
    }

private:
    template <NoiseKind kKind, typename N>
    HWY_INLINE N sum(const Point<N>& p, const Radius& radius) const
    {
        switch (fractal) {
        case FractalKind::brownian:
            return sum<kKind, FractalKind::brownian>(p, radius);
        case FractalKind::ridged:
            return sum<kKind, FractalKind::ridged>(p, radius);
        case FractalKind::billow:
            return sum<kKind, FractalKind::billow>(p, radius);
        }
        return fromConstant<N>(0.0F);
    }

    template <NoiseKind kKind, FractalKind kFractal, typename N>
    HWY_INLINE N sum(const Point<N>& p, const Radius& radius) const
    {
        return fractalSum<kKind, kFractal>(octaves.data(), octaves.size(), p, radius);
    }
};

template <typename Body>
auto withFormula(const FractalProgram& program, const Body& body)
{
    if (program.plane.empty())
        return body(Fractal<SpaceOctave>{program.kind, program.fractal, program.space});
    return body(Fractal<PlaneOctave>{program.kind, program.fractal, program.plane});
}

} // namespace

void sampleFractalOn(const FractalProgram& program, const SampleBatch& batch, float* values)
{
    withFormula(program, [&](const auto& formula) { sampleBatch(formula, batch, values); });
}

void gradientFractalOn(
    const FractalProgram& program,
    const SampleBatch& batch,
    float* values,
    const GradientSpans& gradients)
{
    withFormula(
        program, [&](const auto& formula) { gradientBatch(formula, batch, values, gradients); });
}

core::Interval
boundFractalOn(const FractalProgram& program, const core::Box& box, const core::Interval& radius)
{
    double sum = 0;
    for (const SpaceOctave& octave : program.space)
        sum += std::abs(double(octave.amplitude));
    for (const PlaneOctave& octave : program.plane)
        sum += std::abs(double(octave.amplitude));
    return withFormula(
        program, [&](const auto& formula) { return boundsOver(formula, box, radius, 1e-5 * sum); });
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::fields {

HWY_EXPORT(sampleFractalOn);
HWY_EXPORT(gradientFractalOn);
HWY_EXPORT(boundFractalOn);

void sampleFractal(const FractalProgram& program, const SampleBatch& batch, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(sampleFractalOn)(program, batch, values.data());
}

void gradientFractal(
    const FractalProgram& program,
    const SampleBatch& batch,
    std::span<float> values,
    const GradientSpans& gradients)
{
    HWY_DYNAMIC_DISPATCH(gradientFractalOn)
    (program, batch, values.empty() ? nullptr : values.data(), gradients);
}

core::Interval
boundFractal(const FractalProgram& program, const core::Box& box, const core::Interval& radius)
{
    return HWY_DYNAMIC_DISPATCH(boundFractalOn)(program, box, radius);
}

} // namespace isofront::fields
#endif

#include "graph/Program.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/Kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "graph/Machine-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

namespace simd = isofront::fields::HWY_NAMESPACE;

void sampleProgramOn(const Program& program, const SampleBatch& batch, float* values)
{
    runOverBatch<simd::Value>(program, batch, [&](const Machine<simd::Value>& machine) HWY_ATTR {
        machine.storeValues(values);
    });
}

void gridProgramOn(const Program& program, const SampleGrid& grid, float* values)
{
    runOverGrid(program, grid, values);
}

void gradientProgramOn(
    const Program& program, const SampleBatch& batch, float* values, const GradientSpans& gradients)
{
    runOverBatch<simd::Slope>(program, batch, [&](const Machine<simd::Slope>& machine) HWY_ATTR {
        machine.storeGradients(gradients);
        if (values != nullptr)
            machine.storeValues(values);
    });
}

core::Interval
boundProgramOn(const Program& program, const core::Box& box, const core::Interval& radius)
{
    const BoundedProgram bounded(program);
    return simd::boundsOver(bounded, box, radius, 0.0);
}

} // namespace isofront::fields::graph::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::fields::graph {

HWY_EXPORT(sampleProgramOn);
HWY_EXPORT(gridProgramOn);
HWY_EXPORT(gradientProgramOn);
HWY_EXPORT(boundProgramOn);

void sampleProgram(const Program& program, const SampleBatch& batch, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(sampleProgramOn)(program, batch, values.data());
}

void gridProgram(const Program& program, const SampleGrid& grid, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(gridProgramOn)(program, grid, values.data());
}

void gradientProgram(
    const Program& program, const SampleBatch& batch, const GradientSpans& gradients)
{
    HWY_DYNAMIC_DISPATCH(gradientProgramOn)(program, batch, nullptr, gradients);
}

void sampleAndGradientProgram(
    const Program& program,
    const SampleBatch& batch,
    std::span<float> values,
    const GradientSpans& gradients)
{
    HWY_DYNAMIC_DISPATCH(gradientProgramOn)(program, batch, values.data(), gradients);
}

core::Interval
boundProgram(const Program& program, const core::Box& box, const core::Interval& radius)
{
    return HWY_DYNAMIC_DISPATCH(boundProgramOn)(program, box, radius);
}

} // namespace isofront::fields::graph
#endif

#include "NoiseKernel.h"

#include <cmath>
#include <cstdint>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "NoiseGridKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "simd/Batch-inl.h"
#include "simd/NoiseGrid-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

namespace {

template <NoiseKind kKind>
void gridOfKind(const FractalProgram& program, const SampleGrid& grid, float* values)
{
    switch (program.fractal) {
    case FractalKind::brownian:
        return GridSampler<kKind, FractalKind::brownian>(program.space, grid).sample(values);
    case FractalKind::ridged:
        return GridSampler<kKind, FractalKind::ridged>(program.space, grid).sample(values);
    case FractalKind::billow:
        return GridSampler<kKind, FractalKind::billow>(program.space, grid).sample(values);
    }
}

} // namespace

void gridFractalOn(const FractalProgram& program, const SampleGrid& grid, float* values)
{
    if (program.kind == NoiseKind::value)
        gridOfKind<NoiseKind::value>(program, grid, values);
    else
        gridOfKind<NoiseKind::gradient>(program, grid, values);
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::fields {

HWY_EXPORT(gridFractalOn);

bool hasCoherentGrid(const FractalProgram& program, const SampleGrid& grid)
{
    // Beyond, coordinates are so coarse that neighbouring samples may lie anywhere.
    constexpr double kFar = 0x1p40;
    constexpr std::int64_t kFarIndex = std::int64_t{1} << 40U;
    if (program.space.empty() ||
        (program.kind != NoiseKind::value && program.kind != NoiseKind::gradient))
        return false;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        if (!(std::abs(grid.origin[axis]) < kFar * grid.spacing) || grid.first[axis] < -kFarIndex ||
            grid.first[axis] + grid.count[axis] > kFarIndex)
            return false;
    }
    return true;
}

void gridFractal(const FractalProgram& program, const SampleGrid& grid, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(gridFractalOn)(program, grid, values.data());
}

} // namespace isofront::fields
#endif

#include "isofront/fields/Noise.h"

#include "NoiseKernel.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Powers.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isofront::fields {

namespace {

FractalProgram programOf(const NoiseSettings& settings)
{
    const FractalSettings octaves{
        .wavelength = settings.wavelength,
        .octaves = settings.octaves,
        .amplitude = settings.amplitude,
        .lacunarity = settings.lacunarity,
        .gain = settings.gain};
    FractalProgram program;
    program.kind = settings.kind;
    program.fractal = settings.fractal;
    if (settings.plane)
        program.plane =
            planeOctaves(octaves, settings.seed, settings.filterStrength, settings.kind);
    else
        program.space = spaceOctaves(octaves, settings.seed, settings.filterStrength);
    return program;
}

class FractalNoise final : public Field {
public:
    explicit FractalNoise(const NoiseSettings& settings)
        : _program(programOf(settings)),
          _shortest(
              settings.wavelength /
              core::wholePower(settings.lacunarity, static_cast<unsigned>(settings.octaves - 1)))
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        sampleFractal(_program, batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        gradientFractal(_program, batch, {}, gradients);
    }
    void sampleWithGradient(
        const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const override
    {
        gradientFractal(_program, batch, values, gradients);
    }
    void sampleGrid(const SampleGrid& grid, std::span<float> values) const override
    {
        if (!_program.plane.empty())
            samplePlanes(grid, values);
        else if (hasCoherentGrid(_program, grid))
            gridFractal(_program, grid, values);
        else
            Field::sampleGrid(grid, values);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return boundFractal(_program, box, radius);
    }
    double differenceStep(double radius) const override
    {
        return std::max(0.5 * radius, 0.01 * _shortest);
    }

private:
    /// Noise over the plane is the same in every slice.
    void samplePlanes(const SampleGrid& grid, std::span<float> values) const
    {
        if (grid.size() == 0)
            return;
        SampleGrid slice = grid;
        slice.count.z = 1;
        const std::size_t size = slice.size();
        Field::sampleGrid(slice, values.first(size));
        for (std::size_t begin = size; begin < grid.size(); begin += size)
            std::ranges::copy(values.first(size), values.begin() + std::ptrdiff_t(begin));
    }

    FractalProgram _program;
    double _shortest; // [field]
};

} // namespace

std::shared_ptr<const Field> fractalNoise(const NoiseSettings& settings)
{
    ISOFRONT_ASSERT(settings.wavelength > 0, "a wavelength must be above zero");
    ISOFRONT_ASSERT(
        settings.octaves >= 1 && settings.octaves <= 32, "noise has between 1 and 32 octaves");
    ISOFRONT_ASSERT(
        settings.lacunarity >= 1, "an octave's waves are no longer than those of the one before");
    return std::make_shared<FractalNoise>(settings);
}

} // namespace isofront::fields

#include "isofront/fields/Noise.h"

#include "NoiseKernel.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <cmath>

namespace isofront::fields {

namespace {

class FractalNoise final : public Field {
public:
    explicit FractalNoise(const NoiseSettings& settings)
        : _octaves(spaceOctaves(
              {.wavelength = settings.wavelength,
               .octaves = settings.octaves,
               .amplitude = settings.amplitude,
               .lacunarity = settings.lacunarity,
               .gain = settings.gain},
              settings.seed,
              settings.filterStrength)),
          _shortest(
              settings.wavelength / std::pow(settings.lacunarity, double(settings.octaves - 1)))
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        sampleFractal(_octaves, batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        gradientFractal(_octaves, batch, gradients);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return boundFractal(_octaves, box, radius);
    }
    double differenceStep(double radius) const override
    {
        return std::max(0.5 * radius, 0.01 * _shortest);
    }

private:
    std::vector<SpaceOctave> _octaves;
    double _shortest; // [field]
};

} // namespace

std::shared_ptr<const Field> fractalNoise(const NoiseSettings& settings)
{
    ISOFRONT_ASSERT(settings.wavelength > 0, "a wavelength must be above zero");
    ISOFRONT_ASSERT(
        settings.octaves >= 1 && settings.octaves <= 32, "noise has between 1 and 32 octaves");
    return std::make_shared<FractalNoise>(settings);
}

} // namespace isofront::fields

#include "FieldChecks.h"
#include "Octaves.h"

#include <isofront/fields/Noise.h>

#include <algorithm>
#include <array>
#include <string>

namespace isofront::fields {
namespace {

using namespace test;

constexpr std::array<NoiseKind, 5> kKinds{
    NoiseKind::value,
    NoiseKind::gradient,
    NoiseKind::simplex,
    NoiseKind::cellular,
    NoiseKind::border};
constexpr std::array<FractalKind, 3> kFractals{
    FractalKind::brownian, FractalKind::ridged, FractalKind::billow};

/// Octaves from long waves to some shorter than the spacing of the grid.
NoiseSettings octaves(NoiseKind kind, FractalKind fractal, bool plane)
{
    NoiseSettings settings;
    settings.kind = kind;
    settings.fractal = fractal;
    settings.plane = plane;
    settings.seed = 5;
    settings.wavelength = 21;
    settings.octaves = 7;
    settings.lacunarity = 1.9;
    return settings;
}

TEST(NoiseGrid, givesWhatSingleSamplesGive)
{
    for (const double far : {0.0, 1e7}) {
        for (const double radius : {0.0, 0.8}) {
            const SampleGrid grid{
                .origin = {far + 0.3, -far, 7.7},
                .spacing = 0.77,
                .first = {-20, 3, -9},
                .count = {67, 21, 13},
                .radius = radius};
            const Points points = pointsOf(grid);
            for (const NoiseKind kind : kKinds) {
                for (const FractalKind fractal : kFractals) {
                    for (const bool plane : {false, true}) {
                        const std::shared_ptr<const Field> field =
                            fractalNoise(octaves(kind, fractal, plane));
                        EXPECT_LT(
                            worstDifference(gridOf(*field, grid), valuesOf(*field, points.batch())),
                            4e-6)
                            << int(kind) << ' ' << int(fractal) << ' ' << plane << ' ' << far;
                    }
                }
            }
        }
    }
}

TEST(NoiseGrid, givesTheSameBitsOnEveryInstructionSet)
{
    const SampleGrid grid{
        .origin = {0.3, -5, 7.7}, .spacing = 0.77, .first = {-20, 3, -9}, .count = {67, 21, 13}};
    for (const NoiseKind kind : {NoiseKind::value, NoiseKind::gradient}) {
        for (const FractalKind fractal : kFractals) {
            const std::shared_ptr<const Field> field = fractalNoise(octaves(kind, fractal, false));
            const std::vector<float> values = gridOf(*field, grid);
            onEveryInstructionSet([&](const std::string& name) {
                EXPECT_EQ(differingBits(gridOf(*field, grid), values), 0U) << name;
            });
        }
    }
}

TEST(NoiseGrid, givesEachPointTheSameBitsInAnyBlock)
{
    const SampleGrid whole{
        .origin = {0.3, -5, 7.7},
        .spacing = 0.77,
        .first = {-200, -40, -9},
        .count = {400, 90, 5},
        .radius = 0.2};
    Random random(1);
    for (const NoiseKind kind : kKinds) {
        for (const FractalKind fractal : kFractals) {
            const std::shared_ptr<const Field> field = fractalNoise(octaves(kind, fractal, false));
            const std::vector<float> values = gridOf(*field, whole);
            for (int block = 0; block < 12; ++block) {
                SampleGrid part = whole;
                glm::i64vec3 low(0);
                for (glm::length_t axis = 0; axis < 3; ++axis) {
                    const auto end = double(whole.count[axis]);
                    low[axis] = static_cast<std::int64_t>(random(0, end));
                    part.first[axis] += low[axis];
                    part.count[axis] = static_cast<std::int64_t>(
                        random(1, std::min(end - double(low[axis]), 40.0) + 0.99));
                }
                const std::vector<float> found = gridOf(*field, part);
                std::vector<float> expected;
                for (std::int64_t k = 0; k < part.count.z; ++k)
                    for (std::int64_t j = 0; j < part.count.y; ++j)
                        for (std::int64_t i = 0; i < part.count.x; ++i)
                            expected.push_back(values[static_cast<std::size_t>(
                                ((low.z + k) * whole.count.y + low.y + j) * whole.count.x + low.x +
                                i)]);
                ASSERT_EQ(differingBits(found, expected), 0U) << int(kind) << ' ' << int(fractal);
            }
        }
    }
}

TEST(NoiseGrid, isFilteredLikeSingleSamples)
{
    const std::shared_ptr<const Field> field =
        fractalNoise(octaves(NoiseKind::gradient, FractalKind::brownian, false));
    const SampleGrid grid{.spacing = 1, .count = {40, 9, 3}, .radius = 100};
    // Far below the filter's radius nothing is left.
    for (const float value : gridOf(*field, grid))
        ASSERT_EQ(value, 0.0F);
}

TEST(NoiseGrid, takesGridsWithoutPoints)
{
    for (const bool plane : {false, true}) {
        const std::shared_ptr<const Field> field =
            fractalNoise(octaves(NoiseKind::gradient, FractalKind::brownian, plane));
        for (glm::length_t axis = 0; axis < 3; ++axis) {
            SampleGrid grid{.count = {5, 6, 7}};
            grid.count[axis] = 0;
            EXPECT_TRUE(gridOf(*field, grid).empty());
        }
    }
}

TEST(NoiseGrid, copesWithStepsThatDoublesCannotTellApart)
{
    // Neighbouring points are the same double, or lie many cells apart.
    const std::shared_ptr<const Field> field = fractalNoise({.wavelength = 1e-9, .octaves = 2});
    const SampleGrid grid{.origin = {1e12, 1e12, 1e12}, .spacing = 1e-10, .count = {50, 3, 2}};
    EXPECT_LT(
        worstDifference(gridOf(*field, grid), valuesOf(*field, pointsOf(grid).batch())), 4e-6);
    // The indices are so large that the steps vanish beside them.
    SampleGrid far{
        .spacing = 1e-9, .first = glm::i64vec3(std::int64_t{1} << 60U), .count = {50, 3, 2}};
    EXPECT_LT(worstDifference(gridOf(*field, far), valuesOf(*field, pointsOf(far).batch())), 4e-6);
}

TEST(NoiseGrid, copesWithStepsThatAreRoundedAcrossTheMiddleOfACell)
{
    // A step is a cell, and the samples lie where a cell's index changes: by rounding, neighbours
    // may have the same index, or one that is two apart.
    NoiseSettings settings = octaves(NoiseKind::gradient, FractalKind::brownian, false);
    settings.wavelength = 0.1;
    settings.octaves = 1;
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    const SpaceOctave octave =
        spaceOctaves({.wavelength = 0.1}, settings.seed, settings.filterStrength)[0];
    for (int shift = 0; shift < 20; ++shift) {
        const double x = (2000.5 + 37 * shift - octave.offset[0]) * 0.1;
        const SampleGrid grid{.origin = {x, 0.21, 0.4}, .spacing = 0.1, .count = {300, 3, 2}};
        EXPECT_LT(
            worstDifference(gridOf(*field, grid), valuesOf(*field, pointsOf(grid).batch())), 4e-6);
    }
}

/// A field with nothing but samples.
class Ramp final : public Field {
public:
    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(
                batch.x[i] + 10 * batch.y[i] + 100 * batch.z[i] + 1000 * batch.radius[i]);
    }
    core::Interval bounds(const core::Box& /*box*/, core::Interval /*radius*/) const override
    {
        return {};
    }
    double differenceStep(double /*radius*/) const override { return 1; }
};

TEST(FieldGrid, isSampledPointByPointByDefault)
{
    const Ramp ramp;
    const SampleGrid grid{
        .origin = {1, 2, 3}, .spacing = 0.5, .first = {-1, 4, 2}, .count = {3, 2, 4}, .radius = 2};
    EXPECT_EQ(gridOf(ramp, grid), valuesOf(ramp, pointsOf(grid).batch()));
    EXPECT_EQ(gridOf(ramp, grid)[0], 0.5F + 40 + 400 + 2000);
    // x runs fastest, then y.
    EXPECT_EQ(gridOf(ramp, grid)[1] - gridOf(ramp, grid)[0], 0.5F);
    EXPECT_EQ(gridOf(ramp, grid)[3] - gridOf(ramp, grid)[0], 5.0F);
}

} // namespace
} // namespace isofront::fields

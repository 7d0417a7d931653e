#include "FieldChecks.h"
#include "NoiseReference.h"
#include "Octaves.h"

#include <isofront/fields/Noise.h>

#include <array>

namespace isofront::fields {
namespace {

using namespace test;

core::Box cube(double half, const glm::dvec3& centre = glm::dvec3(0))
{
    return {centre - half, centre + half};
}

// ---- An independent scalar reference, over the type of the arithmetic ---------------------------

/// Gradient noise at a cell and a place in it, counted from its middle; corner by corner.
template <typename T>
T noiseReference(
    const std::array<std::int64_t, 3>& cell, const std::array<T, 3>& centred, std::uint32_t seed)
{
    const auto fade = [](T u) {
        const T v = u * u;
        return u * (v * (v * T(6) - T(5)) + T(1.875)) + T(0.5);
    };
    const auto lerp = [](T a, T b, T t) { return a + t * (b - a); };
    std::array<T, 8> dots{};
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        const std::array<std::uint32_t, 3> at{corner >> 2U, (corner >> 1U) & 1U, corner & 1U};
        std::array<std::int64_t, 3> index{};
        std::array<T, 3> d{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            index[axis] = cell[axis] + at[axis];
            d[axis] = at[axis] == 0 ? centred[axis] + T(0.5) : centred[axis] - T(0.5);
        }
        dots[corner] = edgeDot<T>(cornerHash(index, seed), d);
    }
    const T x = fade(centred[0]);
    const T y = fade(centred[1]);
    const T z = fade(centred[2]);
    return lerp(
        lerp(lerp(dots[0], dots[4], x), lerp(dots[2], dots[6], x), y),
        lerp(lerp(dots[1], dots[5], x), lerp(dots[3], dots[7], x), y),
        z);
}

/// The unfiltered sum, with lattice coordinates and fractions found in `Wide`.
template <typename T, typename Wide>
T fractalReference(const std::vector<SpaceOctave>& octaves, const std::array<double, 3>& p)
{
    T sum = 0;
    for (const SpaceOctave& octave : octaves) {
        std::array<std::int64_t, 3> cell{};
        std::array<T, 3> centred{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Wide t = Wide(p[axis]) * Wide(octave.frequency[axis]) + Wide(octave.offset[axis]);
            const Wide nearest = std::nearbyint(t);
            cell[axis] = static_cast<std::int64_t>(nearest);
            centred[axis] = static_cast<T>(t - nearest);
        }
        sum = sum + noiseReference<T>(cell, centred, octave.seed) * T(octave.amplitude) * T(1);
    }
    return sum;
}

std::vector<SpaceOctave> octavesOf(const NoiseSettings& settings)
{
    return spaceOctaves(
        {.wavelength = settings.wavelength,
         .octaves = settings.octaves,
         .amplitude = settings.amplitude,
         .lacunarity = settings.lacunarity,
         .gain = settings.gain},
        settings.seed,
        settings.filterStrength);
}

// ---- Bits ---------------------------------------------------------------------------------------

TEST(Noise, equalsAScalarReferenceBitForBitOnEveryInstructionSet)
{
    const NoiseSettings settings{.seed = 5, .wavelength = 3.7, .octaves = 5};
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    const std::vector<SpaceOctave> octaves = octavesOf(settings);
    Random random(1);
    for (const double half : {1.0, 100.0, 1e7, 1e10}) {
        Points points = randomPoints(random, cube(half), 0.0, 1001);
        points.radius.clear();
        std::vector<float> expected;
        for (std::size_t i = 0; i < points.size(); ++i)
            expected.push_back(
                fractalReference<float, double>(octaves, {points.x[i], points.y[i], points.z[i]}));
        onEveryInstructionSet([&](const std::string& name) {
            EXPECT_EQ(differingBits(valuesOf(*field, points.batch()), expected), 0U)
                << name << ", within " << half;
        });
    }
}

TEST(Noise, givesTheSameFilteredBitsGradientsAndBoundsOnEveryInstructionSet)
{
    const std::shared_ptr<const Field> field =
        fractalNoise({.seed = 9, .wavelength = 8, .octaves = 9, .filterStrength = 1.3});
    Random random(2);
    const Points points = randomPoints(random, cube(300), 5.0, 2003);
    const std::vector<float> values = valuesOf(*field, points.batch());
    const Gradients gradients = gradientsOf(*field, points.batch());
    const core::Box box = cube(1.5, glm::dvec3(7, -3, 11));
    const core::Interval bounds = field->bounds(box, {0.1, 0.4});
    onEveryInstructionSet([&](const std::string& name) {
        EXPECT_EQ(differingBits(valuesOf(*field, points.batch()), values), 0U) << name;
        const Gradients other = gradientsOf(*field, points.batch());
        EXPECT_EQ(other.x, gradients.x) << name;
        EXPECT_EQ(other.y, gradients.y) << name;
        EXPECT_EQ(other.z, gradients.z) << name;
        const core::Interval again = field->bounds(box, {0.1, 0.4});
        EXPECT_EQ(again.low, bounds.low) << name;
        EXPECT_EQ(again.high, bounds.high) << name;
    });
}

TEST(Noise, givesTheSameBitsWhereverAPointStandsInItsBatch)
{
    const std::shared_ptr<const Field> field = fractalNoise({.wavelength = 8, .octaves = 9});
    Random random(3);
    expectSameBitsAnywhereInABatch(*field, randomPoints(random, cube(300), 9.0, 64));
}

TEST(Noise, takesAnEmptyBatch)
{
    EXPECT_TRUE(valuesOf(*fractalNoise({}), {}).empty());
}

// ---- Quality ------------------------------------------------------------------------------------

TEST(Noise, isAsGoodTenThousandKilometresAwayAsAtTheOrigin)
{
    // One octave of 1 cm; the reference carries 64 bits of mantissa all the way.
    const NoiseSettings settings{.seed = 3, .wavelength = 0.01, .octaves = 1};
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    const std::vector<SpaceOctave> octaves = octavesOf(settings);
    Random random(4);
    for (const double far : {0.0, 1e5, 1e7}) {
        const Points points = randomPoints(random, cube(10, glm::dvec3(far, -far, far)), 0, 4000);
        const std::vector<float> values = valuesOf(*field, points.batch());
        double worst = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const long double exact = fractalReference<long double, long double>(
                octaves, {points.x[i], points.y[i], points.z[i]});
            worst = std::max(
                worst, std::abs(static_cast<double>(exact - static_cast<long double>(values[i]))));
        }
        // At 1e7 m the product with the frequency, about 1e9 cells, is itself rounded by 6e-8.
        EXPECT_LT(worst, 1e-6) << far;
    }
}

TEST(Noise, isContinuousAcrossCells)
{
    const std::shared_ptr<const Field> field = fractalNoise({.wavelength = 1, .octaves = 1});
    const SpaceOctave octave = octavesOf({.wavelength = 1, .octaves = 1})[0];
    Random random(5);
    for (int i = 0; i < 1000; ++i) {
        const double wall = std::floor(random(-1000, 1000)) + 0.5 - octave.offset[0];
        const double y = random(-50, 50);
        const double z = random(-50, 50);
        const float before = valueAt(*field, wall - 1e-9, y, z);
        const float after = valueAt(*field, wall + 1e-9, y, z);
        ASSERT_NEAR(before, after, 1e-6);
    }
}

TEST(Noise, hasNoMeanAndTheSameSpreadAlongEveryAxis)
{
    const std::shared_ptr<const Field> field = fractalNoise({.wavelength = 1, .octaves = 1});
    Random random(6);
    const Points points = randomPoints(random, cube(5e4), 0, 200000);
    const std::vector<float> values = valuesOf(*field, points.batch());
    const Gradients gradients = gradientsOf(*field, points.batch());
    double mean = 0;
    double square = 0;
    glm::dvec3 slopes(0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        mean += double(values[i]);
        square += double(values[i]) * double(values[i]);
        slopes += glm::dvec3(
            gradients.x[i] * gradients.x[i],
            gradients.y[i] * gradients.y[i],
            gradients.z[i] * gradients.z[i]);
    }
    const double count = double(points.size());
    EXPECT_NEAR(mean / count, 0, 0.004);
    EXPECT_NEAR(std::sqrt(square / count), 0.27, 0.03);
    EXPECT_NEAR(slopes.x / slopes.y, 1, 0.02);
    EXPECT_NEAR(slopes.z / slopes.y, 1, 0.02);
}

TEST(Noise, differsFromSeedToSeed)
{
    Random random(7);
    const Points points = randomPoints(random, cube(100), 0, 1000);
    const std::vector<float> a = valuesOf(*fractalNoise({.seed = 1}), points.batch());
    const std::vector<float> b = valuesOf(*fractalNoise({.seed = 2}), points.batch());
    double product = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        product += double(a[i]) * double(b[i]);
    EXPECT_LT(std::abs(product) / double(a.size()), 0.01);
}

// ---- Gradient, filter and bounds ----------------------------------------------------------------

TEST(Noise, hasGradientsThatMatchDifferences)
{
    const std::shared_ptr<const Field> field =
        fractalNoise({.seed = 2, .wavelength = 10, .octaves = 3});
    Random random(8);
    expectGradientsMatchDifferences(*field, randomPoints(random, cube(100), 6.0, 2000), 0.01, 2e-4);
}

TEST(Noise, weighsAnOctaveByTheExponentialOfItsFrequencyTimesTheRadius)
{
    const double kappa = 1.7;
    const double wavelength = 4;
    const std::shared_ptr<const Field> field =
        fractalNoise({.wavelength = wavelength, .octaves = 1, .filterStrength = kappa});
    const float whole = valueAt(*field, 1.3, 2.1, -0.7);
    ASSERT_GT(std::abs(whole), 0.05F);
    double before = 2;
    for (double radius = 0; radius < 9; radius += 0.003) {
        const double measured = double(valueAt(*field, 1.3, 2.1, -0.7, radius)) / double(whole);
        const double argument = kappa * radius / wavelength;
        ASSERT_NEAR(measured, std::exp(-argument * argument), 1.4e-4) << radius;
        ASSERT_LE(measured, before + 1e-6);
        if (argument > 3.0001) {
            ASSERT_EQ(measured, 0);
        }
        before = measured;
    }
    EXPECT_EQ(valueAt(*field, 1.3, 2.1, -0.7, 0.0), whole);
}

TEST(Noise, ignoresTheRadiusWithoutFilter)
{
    const std::shared_ptr<const Field> field =
        fractalNoise({.wavelength = 4, .octaves = 4, .filterStrength = 0});
    EXPECT_EQ(valueAt(*field, 1.3, 2.1, -0.7, 0.0), valueAt(*field, 1.3, 2.1, -0.7, 100.0));
}

TEST(Noise, staysWithinItsBounds)
{
    const std::shared_ptr<const Field> field =
        fractalNoise({.wavelength = 30, .octaves = 8, .amplitude = 12});
    expectBoundsHold(*field, cube(500), 20.0, 2000, 200, 9);
    expectBoundsHold(*field, cube(500, glm::dvec3(1e7)), 20.0, 500, 200, 10);
}

TEST(Noise, hasBoundsThatCloseInOnTheValue)
{
    const std::shared_ptr<const Field> field = fractalNoise({.wavelength = 1, .octaves = 1});
    const glm::dvec3 at(3.3, 1.2, 0.4);
    const float value = valueAt(*field, at.x, at.y, at.z);
    for (const double half : {0.1, 0.01, 0.001}) {
        const core::Interval bounds = field->bounds(cube(half, at), {0, 0});
        EXPECT_LT(bounds.high - bounds.low, 8 * half + 1e-4);
        EXPECT_TRUE(bounds.contains(double(value)));
    }
}

TEST(Noise, knowsNothingOfABoxWithoutEnd)
{
    const std::shared_ptr<const Field> field = fractalNoise({});
    const core::Interval bounds =
        field->bounds(cube(std::numeric_limits<double>::infinity()), {0, 0});
    EXPECT_LE(bounds.low, -2);
    EXPECT_GE(bounds.high, 2);
}

} // namespace
} // namespace isofront::fields

#include "FieldChecks.h"
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

std::uint32_t stirred(std::uint32_t cell, std::uint32_t seed)
{
    std::uint32_t hash = cell ^ seed;
    hash = (hash ^ (hash >> 16U)) * 0x7feb352dU;
    hash = (hash ^ (hash >> 15U)) * 0x846ca68bU;
    return hash ^ (hash >> 16U);
}

/// Gradient noise at a cell and fraction, corner by corner.
template <typename T>
T noiseReference(
    const std::array<std::int64_t, 3>& cell, const std::array<T, 3>& f, std::uint32_t seed)
{
    const auto fade = [](T t) {
        const T u = t - T(0.5);
        const T v = u * u;
        return u * (v * (v * T(6) - T(5)) + T(1.875)) + T(0.5);
    };
    const auto lerp = [](T a, T b, T t) { return a + t * (b - a); };
    std::array<T, 8> dots{};
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        const std::array<std::uint32_t, 3> at{corner >> 2U, (corner >> 1U) & 1U, corner & 1U};
        constexpr std::array<std::uint32_t, 3> kSeeds{0U, 0x68e31da4U, 0xb5297a4dU};
        std::uint32_t sum = 0;
        std::array<T, 3> d{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sum += stirred(static_cast<std::uint32_t>(cell[axis]) + at[axis], seed ^ kSeeds[axis]);
            d[axis] = at[axis] == 0 ? f[axis] : f[axis] - T(1);
        }
        const std::uint32_t product = sum * 0x9e3779b1U;
        const std::uint32_t hash = product ^ (product >> 15U);
        // Thirds of the signed numbers pick the pair of axes.
        const auto number = static_cast<std::int32_t>(hash);
        const std::size_t u = number < 715827882 ? 0 : 1;
        const std::size_t v = number < -715827883 ? 1 : 2;
        dots[corner] = ((hash & 1U) != 0 ? -d[u] : d[u]) + ((hash & 2U) != 0 ? -d[v] : d[v]);
    }
    const T x = fade(f[0]);
    const T y = fade(f[1]);
    const T z = fade(f[2]);
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
        std::array<T, 3> fraction{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Wide t = Wide(p[axis]) * Wide(octave.frequency[axis]) + Wide(octave.offset[axis]);
            const Wide floor = std::floor(t);
            cell[axis] = static_cast<std::int64_t>(floor);
            fraction[axis] = static_cast<T>(t - floor);
        }
        sum = sum + noiseReference<T>(cell, fraction, octave.seed) * T(octave.amplitude) * T(1);
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
        const double wall = std::floor(random(-1000, 1000)) - octave.offset[0];
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

// ---- The limits that bounds rest on -------------------------------------------------------------

/// The largest value, slope and second derivative at a place and in a direction, if every corner
/// carries the gradient that makes it largest.
template <std::size_t K>
std::array<double, 3> worstCase(
    const std::vector<std::array<double, K>>& gradients,
    const std::array<double, K>& x,
    const std::array<double, K>& direction)
{
    std::array<double, 3> sum{};
    for (std::size_t corner = 0; corner < (std::size_t{1} << K); ++corner) {
        // Each axis as (weight, its slope, its curvature).
        std::array<std::array<double, 3>, K> w{};
        std::array<double, K> d{};
        for (std::size_t k = 0; k < K; ++k) {
            const double t = x[k];
            const bool far = ((corner >> k) & 1U) != 0;
            const double s = far ? 1.0 : -1.0;
            const double fade = t * t * t * (t * (t * 6 - 15) + 10);
            w[k] = {
                far ? fade : 1 - fade,
                s * 30 * t * t * (t - 1) * (t - 1),
                s * 60 * t * (2 * t * t - 3 * t + 1)};
            d[k] = t - (far ? 1.0 : 0.0);
        }
        const auto product = [&](std::size_t a, std::size_t b) {
            double result = 1;
            for (std::size_t k = 0; k < K; ++k)
                result *= w[k][(k == a ? 1U : 0U) + (k == b ? 1U : 0U)];
            return result;
        };
        double slope = 0;
        double curvature = 0;
        for (std::size_t a = 0; a < K; ++a) {
            slope += direction[a] * product(a, K);
            for (std::size_t b = 0; b < K; ++b)
                curvature += direction[a] * direction[b] * product(a, b);
        }
        std::array<double, 3> most{-1e9, -1e9, -1e9};
        for (const std::array<double, K>& g : gradients) {
            double along = 0;
            double towards = 0;
            for (std::size_t k = 0; k < K; ++k) {
                along += g[k] * d[k];
                towards += g[k] * direction[k];
            }
            most[0] = std::max(most[0], product(K, K) * along);
            most[1] = std::max(most[1], product(K, K) * towards + along * slope);
            most[2] = std::max(most[2], 2 * slope * towards + along * curvature);
        }
        for (std::size_t i = 0; i < 3; ++i)
            sum[i] += most[i];
    }
    return sum;
}

/// Random search, then climbing from the best place found.
template <std::size_t K>
std::array<double, 3>
searched(const std::vector<std::array<double, K>>& gradients, std::uint64_t seed)
{
    Random random(seed);
    std::array<double, 3> best{};
    for (std::size_t kind = 0; kind < 3; ++kind) {
        std::array<double, K> x{};
        std::array<double, K> u{};
        double step = 1;
        for (int i = 0; i < 12000; ++i) {
            std::array<double, K> tryX = x;
            std::array<double, K> tryU = u;
            double length = 0;
            for (std::size_t k = 0; k < K; ++k) {
                tryX[k] =
                    i < 4000 ? random(0, 1) : std::clamp(x[k] + step * random(-1, 1), 0.0, 1.0);
                tryU[k] = i < 4000 ? random(-1, 1) : u[k] + step * random(-1, 1);
                length += tryU[k] * tryU[k];
            }
            for (double& component : tryU)
                component /= std::sqrt(length);
            const double found = worstCase(gradients, tryX, tryU)[kind];
            if (found > best[kind]) {
                best[kind] = found;
                x = tryX;
                u = tryU;
            } else if (i >= 4000) {
                step = std::max(step * 0.998, 1e-5);
            }
        }
    }
    return best;
}

TEST(Noise, hasLimitsThatNoChoiceOfGradientsExceeds)
{
    std::vector<std::array<double, 3>> edges;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double a : {-1.0, 1.0})
            for (const double b : {-1.0, 1.0}) {
                std::array<double, 3> edge{};
                edge[axis] = a;
                edge[(axis + 1) % 3] = b;
                edges.push_back(edge);
            }
    const std::array<double, 3> space = searched(edges, 11);
    EXPECT_LT(space[0], double(kSpaceNoise.magnitude));
    EXPECT_LT(space[1], double(kSpaceNoise.slope));
    EXPECT_LT(space[2], double(kSpaceNoise.curvature));
    EXPECT_NEAR(space[0], 1.0364, 0.002);
    EXPECT_NEAR(space[1], 3.7500, 0.01);
    EXPECT_NEAR(space[2], 14.466, 0.05);

    std::vector<std::array<double, 2>> turns;
    for (int i = 0; i < 8; ++i) {
        const double angle = (22.5 + 45.0 * i) * 3.141592653589793 / 180;
        turns.push_back({std::cos(angle), std::sin(angle)});
    }
    const std::array<double, 3> plane = searched(turns, 12);
    EXPECT_LT(plane[0], double(kPlaneNoise.magnitude));
    EXPECT_LT(plane[1], double(kPlaneNoise.slope));
    EXPECT_LT(plane[2], double(kPlaneNoise.curvature));
    EXPECT_NEAR(plane[0], 0.6608, 0.002);
    EXPECT_NEAR(plane[1], 2.0671, 0.01);
    EXPECT_NEAR(plane[2], 8.9773, 0.05);
}

} // namespace
} // namespace isofront::fields

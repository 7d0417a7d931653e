#include "FieldChecks.h"
#include "NoiseReference.h"
#include "Octaves.h"

#include <isofront/fields/Noise.h>

#include <algorithm>
#include <array>
#include <string>

namespace isofront::fields {
namespace {

using namespace test;

struct Kind {
    NoiseKind kind;
    bool plane;
    const char* name;
};

void PrintTo(const Kind& kind, std::ostream* to)
{
    *to << kind.name;
}

constexpr std::array<Kind, 10> kKinds{
    {{NoiseKind::value, false, "valueInSpace"},
     {NoiseKind::gradient, false, "gradientInSpace"},
     {NoiseKind::simplex, false, "simplexInSpace"},
     {NoiseKind::cellular, false, "cellularInSpace"},
     {NoiseKind::border, false, "borderInSpace"},
     {NoiseKind::value, true, "valueInThePlane"},
     {NoiseKind::gradient, true, "gradientInThePlane"},
     {NoiseKind::simplex, true, "simplexInThePlane"},
     {NoiseKind::cellular, true, "cellularInThePlane"},
     {NoiseKind::border, true, "borderInThePlane"}}};
constexpr std::array<FractalKind, 3> kFractals{
    FractalKind::brownian, FractalKind::ridged, FractalKind::billow};

class NoiseKinds : public testing::TestWithParam<Kind> {
protected:
    /// One octave, unfiltered, unless changed.
    static NoiseSettings settings(double wavelength = 1)
    {
        NoiseSettings settings;
        settings.kind = GetParam().kind;
        settings.plane = GetParam().plane;
        settings.seed = 11;
        settings.wavelength = wavelength;
        settings.octaves = 1;
        return settings;
    }
    static NoiseSettings octaves(FractalKind fractal, double wavelength, int count)
    {
        NoiseSettings result = settings(wavelength);
        result.fractal = fractal;
        result.octaves = count;
        return result;
    }
    static bool hasCreases() { return GetParam().kind >= NoiseKind::cellular; }
};

INSTANTIATE_TEST_SUITE_P(
    All, NoiseKinds, testing::ValuesIn(kKinds), [](const testing::TestParamInfo<Kind>& kind) {
        return std::string(kind.param.name);
    });

core::Box cube(double half, const glm::dvec3& centre = glm::dvec3(0))
{
    return {centre - half, centre + half};
}

FractalSettings octaveOf(const NoiseSettings& settings)
{
    return {
        .wavelength = settings.wavelength,
        .octaves = 1,
        .amplitude = settings.amplitude,
        .lacunarity = settings.lacunarity,
        .gain = settings.gain};
}

/// The noise of one octave, in 64 bits of mantissa from the point on.
long double referenceAt(const NoiseSettings& settings, double x, double y, double z)
{
    using Wide = long double;
    const auto place = [](Wide t, std::int64_t& cell) {
        const Wide floor = std::floor(t);
        cell = static_cast<std::int64_t>(floor);
        return t - floor;
    };
    const Wide half(0.5);
    if (settings.plane) {
        const PlaneOctave o = planeOctaves(octaveOf(settings), settings.seed, 0, settings.kind)[0];
        std::array<std::int64_t, 2> cell{};
        const Wide u = Wide(x) * Wide(o.first[0]) + Wide(y) * Wide(o.first[1]);
        const Wide v = Wide(x) * Wide(o.second[0]) + Wide(y) * Wide(o.second[1]);
        const std::array<Wide, 2> at{
            place(u + Wide(o.offset[0]) + half, cell[0]),
            place(v + Wide(o.offset[1]) + half, cell[1])};
        return planeReference<Wide>(settings.kind, cell, at, o.seed);
    }
    const SpaceOctave o = spaceOctaves(octaveOf(settings), settings.seed, 0)[0];
    std::array<std::int64_t, 3> cell{};
    std::array<Wide, 3> at{};
    const std::array<double, 3> p{x, y, z};
    for (std::size_t i = 0; i < 3; ++i)
        at[i] = place(Wide(p[i]) * Wide(o.frequency[i]) + Wide(o.offset[i]) + half, cell[i]);
    return spaceReference<Wide>(settings.kind, cell, at, o.seed);
}

// ---- Exactness ----------------------------------------------------------------------------------

TEST_P(NoiseKinds, equalAReferenceTenThousandKilometresAwayAsAtTheOrigin)
{
    const NoiseSettings settings = NoiseKinds::settings(0.01);
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    Random random(1);
    for (const double far : {0.0, 1e5, 1e7}) {
        const Points points = randomPoints(random, cube(10, glm::dvec3(far, -far, far)), 0, 1500);
        const std::vector<float> values = valuesOf(*field, points.batch());
        double worst = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const long double exact = referenceAt(settings, points.x[i], points.y[i], points.z[i]);
            worst = std::max(
                worst, std::abs(static_cast<double>(exact - static_cast<long double>(values[i]))));
        }
        EXPECT_LT(worst, 1e-6) << far;
    }
}

TEST_P(NoiseKinds, repeatAfterAllCellsThatThereAre)
{
    const NoiseSettings settings = NoiseKinds::settings();
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    // A step of 2^32 cells along the lattice's first edge.
    double dx = 0x1p32;
    double dy = 0;
    if (settings.plane) {
        const PlaneOctave o = planeOctaves(octaveOf(settings), settings.seed, 0, settings.kind)[0];
        const double determinant = o.first[0] * o.second[1] - o.first[1] * o.second[0];
        dx = 0x1p32 * o.second[1] / determinant;
        dy = -0x1p32 * o.second[0] / determinant;
    }
    Random random(2);
    for (int i = 0; i < 300; ++i) {
        const double x = random(-9, 9);
        const double y = random(-9, 9);
        const double z = random(-9, 9);
        // So far out the fraction keeps 20 bits.
        ASSERT_NEAR(valueAt(*field, x, y, z), valueAt(*field, x + dx, y + dy, z), 2e-5);
    }
}

TEST_P(NoiseKinds, giveTheSameBitsOnEveryInstructionSet)
{
    Random random(3);
    const Points points = randomPoints(random, cube(300), 5.0, 701);
    const core::Box box = cube(0.7, glm::dvec3(7, -3, 11));
    for (const FractalKind fractal : kFractals) {
        const std::shared_ptr<const Field> field = fractalNoise(octaves(fractal, 8, 5));
        const std::vector<float> values = valuesOf(*field, points.batch());
        const Gradients gradients = gradientsOf(*field, points.batch());
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
}

TEST_P(NoiseKinds, giveTheSameBitsAloneAndTogetherWithTheGradient)
{
    Random random(4);
    const Points points = randomPoints(random, cube(300), 5.0, 333);
    for (const FractalKind fractal : kFractals) {
        const std::shared_ptr<const Field> field = fractalNoise(octaves(fractal, 8, 5));
        expectSameBitsAnywhereInABatch(*field, points);
        const Gradients alone = gradientsOf(*field, points.batch());
        std::vector<float> values(points.size());
        Gradients both{alone.x, alone.x, alone.x};
        field->sampleWithGradient(points.batch(), values, {both.x, both.y, both.z});
        EXPECT_EQ(differingBits(values, valuesOf(*field, points.batch())), 0U);
        EXPECT_EQ(both.x, alone.x);
        EXPECT_EQ(both.y, alone.y);
        EXPECT_EQ(both.z, alone.z);
    }
}

// ---- Shape --------------------------------------------------------------------------------------

TEST_P(NoiseKinds, haveNoJumpsAtTheWallsOfCells)
{
    const NoiseSettings settings = NoiseKinds::settings();
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    Random random(5);
    Points points;
    for (int i = 0; i < 3000; ++i) {
        // Walls, and the middles between, where simplices and nearest cells change.
        const double wall = 0.5 * std::floor(random(-1000, 1000));
        double x = 0;
        double y = random(-50, 50);
        const double z = random(-50, 50);
        if (settings.plane) {
            const PlaneOctave o =
                planeOctaves(octaveOf(settings), settings.seed, 0, settings.kind)[0];
            x = (wall - o.offset[0] - y * o.first[1]) / o.first[0];
        } else {
            const SpaceOctave o = spaceOctaves(octaveOf(settings), settings.seed, 0)[0];
            x = wall - o.offset[0];
        }
        for (const double side : {-1e-9, 1e-9}) {
            points.x.push_back(x + side);
            points.y.push_back(y);
            points.z.push_back(z);
            points.radius.push_back(0);
        }
    }
    const std::vector<float> values = valuesOf(*field, points.batch());
    const Gradients gradients = gradientsOf(*field, points.batch());
    for (std::size_t i = 0; i < points.size(); i += 2) {
        ASSERT_NEAR(values[i], values[i + 1], 1e-6);
        if (!hasCreases()) {
            ASSERT_NEAR(gradients.x[i], gradients.x[i + 1], 1e-5);
            ASSERT_NEAR(gradients.y[i], gradients.y[i + 1], 1e-5);
            ASSERT_NEAR(gradients.z[i], gradients.z[i + 1], 1e-5);
        }
    }
}

TEST_P(NoiseKinds, haveTheMeansThatFractalsTakeAway)
{
    const NoiseSettings settings = NoiseKinds::settings();
    const NoiseKind kind = settings.kind;
    const FractalNorms norms = settings.plane ? planeNorms(kind) : spaceNorms(kind);
    const NoiseLimits limits = settings.plane ? planeLimits(kind) : spaceLimits(kind);
    Random random(6);
    Points points = randomPoints(random, cube(5e4), 0, 400000);
    points.radius.clear();
    double mean = 0;
    double square = 0;
    double billow = 0;
    double ridge = 0;
    double most = 0;
    for (const float value : valuesOf(*fractalNoise(settings), points.batch())) {
        const double v = double(value);
        const double scaled = double(norms.scale) * v;
        const double creased = std::sqrt(scaled * scaled + double(kCreaseRounding));
        const double crest = std::max(1 - creased, 0.0);
        mean += v;
        square += v * v;
        billow += creased;
        ridge += crest * crest;
        most = std::max(most, std::abs(v));
    }
    const double count = double(points.size());
    EXPECT_NEAR(mean / count, 0, 0.006);
    EXPECT_NEAR(double(norms.scale) * std::sqrt(square / count), 0.5, 0.015);
    EXPECT_NEAR(billow / count, double(norms.billowMean), 0.006);
    EXPECT_NEAR(ridge / count, double(norms.ridgeMean), 0.006);
    EXPECT_LE(most, double(limits.magnitude));
    EXPECT_GE(most, 0.85 * double(limits.magnitude));
}

TEST_P(NoiseKinds, leaveTheMeanOfASumAsItIsHoweverMuchIsFiltered)
{
    Random random(7);
    for (const FractalKind fractal : kFractals) {
        const std::shared_ptr<const Field> field = fractalNoise(octaves(fractal, 4, 3));
        Points points = randomPoints(random, cube(5e4), 0, 100000);
        for (const double radius : {0.0, 0.5, 2.0, 13.0}) {
            std::ranges::fill(points.radius, radius);
            double mean = 0;
            for (const float value : valuesOf(*field, points.batch()))
                mean += double(value);
            // The higher octaves of ridges go with the lower ones, and so have a mean of their own.
            EXPECT_NEAR(
                mean / double(points.size()), 0, fractal == FractalKind::ridged ? 0.1 : 0.012)
                << radius;
        }
    }
}

TEST_P(NoiseKinds, haveGradientsThatMatchDifferences)
{
    Random random(8);
    for (const FractalKind fractal : kFractals) {
        const std::shared_ptr<const Field> field = fractalNoise(octaves(fractal, 10, 3));
        // On a crease, of cells or of ridges, differences have no meaning.
        const bool creased = hasCreases() || fractal != FractalKind::brownian;
        expectGradientsMatchDifferences(
            *field, randomPoints(random, cube(100), 6.0, 1500), 0.004, 1e-3, creased ? 0.06 : 0.0);
    }
}

TEST_P(NoiseKinds, stayWithinTheirBounds)
{
    for (const FractalKind fractal : kFractals) {
        const std::shared_ptr<const Field> field = fractalNoise(octaves(fractal, 30, 6));
        expectBoundsHold(*field, cube(500), 20.0, 700, 150, 9);
        expectBoundsHold(*field, cube(500, glm::dvec3(1e7)), 20.0, 200, 100, 10);
    }
}

TEST_P(NoiseKinds, haveBoundsThatCloseInOnTheValue)
{
    const NoiseSettings settings = NoiseKinds::settings();
    const std::shared_ptr<const Field> field = fractalNoise(settings);
    const float slope =
        (settings.plane ? planeLimits(settings.kind) : spaceLimits(settings.kind)).slope;
    const glm::dvec3 at(3.3, 1.2, 0.4);
    const float value = valueAt(*field, at.x, at.y, at.z);
    for (const double half : {0.01, 0.001}) {
        const core::Interval bounds = field->bounds(cube(half, at), {0, 0});
        EXPECT_LT(bounds.high - bounds.low, 4 * double(slope) * half + 1e-4);
        EXPECT_TRUE(bounds.contains(double(value)));
    }
}

} // namespace
} // namespace isofront::fields

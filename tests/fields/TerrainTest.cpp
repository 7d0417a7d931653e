#include "FieldChecks.h"
#include "TerrainPrinting.h"

#include <isofront/fields/Terrain.h>

#include <glm/geometric.hpp>

namespace isofront::fields {
namespace {

using namespace test;

class Terrain : public testing::TestWithParam<TerrainPreset> {
protected:
    [[nodiscard]] static std::shared_ptr<const Field> make(std::uint64_t seed = 1)
    {
        return terrain({.preset = GetParam().name, .seed = seed});
    }

    /// Points around the surface, where every part of the formula is at work.
    static Points pointsNearTheSurface(const Field& field, double reach, std::size_t count)
    {
        Random random(51);
        const core::Box& box = GetParam().box;
        Points points;
        while (points.size() < count) {
            const double x = random(box.low.x, box.high.x);
            const double y = random(box.low.y, box.high.y);
            const double height = surfaceHeight(field, box, x, y, 32);
            if (height == box.low.z)
                continue;
            for (int i = 0; i < 20; ++i) {
                points.x.push_back(x);
                points.y.push_back(y);
                points.z.push_back(height + random(-reach, reach));
                points.radius.push_back(random(0, 1) < 0.3 ? 0.0 : random(0, 20));
            }
        }
        return points;
    }
};

INSTANTIATE_TEST_SUITE_P(
    Presets,
    Terrain,
    testing::ValuesIn(terrainPresets()),
    [](const testing::TestParamInfo<TerrainPreset>& instance) { return instance.param.name; });

TEST_P(Terrain, givesTheSameBitsOnEveryInstructionSet)
{
    const std::shared_ptr<const Field> field = make();
    // Many points: where a fade ends, a skipped octave may differ from an added one in few places.
    for (const double reach : {30.0, 600.0}) {
        const Points points = pointsNearTheSurface(*field, reach, 10003);
        const std::vector<float> values = valuesOf(*field, points.batch());
        const Gradients gradients = gradientsOf(*field, points.batch());
        const glm::dvec3 at(points.x[0], points.y[0], points.z[0]);
        const core::Box box{at - 40.0, at + 40.0};
        const core::Interval bounds = field->bounds(box, {0, 4});
        onEveryInstructionSet([&](const std::string& name) {
            EXPECT_EQ(differingBits(valuesOf(*field, points.batch()), values), 0U) << name;
            const Gradients other = gradientsOf(*field, points.batch());
            EXPECT_EQ(other.x, gradients.x) << name;
            EXPECT_EQ(other.y, gradients.y) << name;
            EXPECT_EQ(other.z, gradients.z) << name;
            const core::Interval again = field->bounds(box, {0, 4});
            EXPECT_EQ(again.low, bounds.low) << name;
            EXPECT_EQ(again.high, bounds.high) << name;
        });
    }
}

TEST_P(Terrain, givesTheSameBitsWhereverAPointStandsInItsBatch)
{
    // Neighbours in the batch lie far away from one another, so that each skips what others need.
    const std::shared_ptr<const Field> field = make();
    const Points near = pointsNearTheSurface(*field, 500, 64);
    expectSameBitsAnywhereInABatch(*field, near);
}

TEST_P(Terrain, staysWithinItsBounds)
{
    const std::shared_ptr<const Field> field = make();
    expectBoundsHold(*field, GetParam().box, 100.0, 1000, 100, 52);
    // Boxes around the surface, of all sizes: with the others a third of a million samples a
    // preset.
    Random random(53);
    for (int i = 0; i < 800; ++i) {
        const double x = random(-8000, 8000);
        const double y = random(-8000, 8000);
        const double edge = 4000 * std::exp2(-random(0, 14));
        const double z = surfaceHeight(*field, GetParam().box, x, y, 64) - edge * random(0, 1);
        const double most = i % 3 == 0 ? 0.0 : edge * random(0, 0.3);
        const core::Box box{{x, y, z}, {x + edge, y + edge, z + edge}};
        const core::Interval bounds = field->bounds(box, {0, most});
        const Points points = randomPoints(random, box, most, 300);
        for (const float value : valuesOf(*field, points.batch()))
            ASSERT_TRUE(bounds.contains(double(value))) << value << ", edge " << edge;
    }
}

TEST_P(Terrain, provesNineteenInTwentyEmptyBoxesOfASixtyFourthEmpty)
{
    const std::shared_ptr<const Field> field = make();
    const double edge = GetParam().box.size().x / 64;
    Random random(54);
    std::size_t empty = 0;
    std::size_t proved = 0;
    for (int i = 0; i < 900; ++i) {
        const glm::dvec3 low(
            random(-8192, 8192 - edge), random(-8192, 8192 - edge), random(-8192, 8192 - edge));
        Points points;
        for (int k = 0; k < 10 * 10 * 10; ++k) {
            points.x.push_back(low.x + edge * (k % 10) / 9);
            points.y.push_back(low.y + edge * (k / 10 % 10) / 9);
            points.z.push_back(low.z + edge * (k / 100) / 9);
        }
        const std::vector<float> values = valuesOf(*field, points.batch());
        const bool solid = values[0] >= 0;
        const core::Interval bounds = field->bounds({low, low + edge}, {0, 0});
        const bool decided = bounds.low > 0 || bounds.high < 0;
        if (std::any_of(
                values.begin(), values.end(), [&](float value) { return (value >= 0) != solid; })) {
            ASSERT_FALSE(decided);
            continue;
        }
        ++empty;
        proved += decided ? 1U : 0U;
    }
    RecordProperty("provedPercent", static_cast<int>(100 * proved / empty));
    EXPECT_GT(double(proved), 0.95 * double(empty));
}

TEST_P(Terrain, hasGradientsThatMatchDifferences)
{
    const std::shared_ptr<const Field> field = make();
    // Values are floats of some hundreds of metres, rounded by up to 1e-4 m; a few differences
    // straddle the crease of a ridge or a join. Without octaves below a metre, a step of 10 cm
    // leaves no truncation to speak of.
    Points points = pointsNearTheSurface(*field, 20, 2000);
    for (double& radius : points.radius)
        radius = std::max(radius, 4.0);
    expectGradientsMatchDifferences(*field, points, 0.1, 0.01, 0.005);
}

TEST_P(Terrain, hasAGradientNearOneAtTheSurface)
{
    const std::shared_ptr<const Field> field = make();
    const Points points = pointsNearTheSurface(*field, 1, 4000);
    const Gradients g = gradientsOf(*field, points.batch());
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        sum += glm::length(glm::dvec3(g.x[i], g.y[i], g.z[i]));
    const double mean = sum / double(points.size());
    EXPECT_GT(mean, 0.6);
    EXPECT_LT(mean, 1.6);
}

TEST_P(Terrain, losesDetailSmoothlyAsTheRadiusGrows)
{
    // At one point near the surface the value is a continuous function of the radius.
    const std::shared_ptr<const Field> field = make();
    const Points points = pointsNearTheSurface(*field, 5, 64);
    for (std::size_t i = 0; i < points.size(); i += 8) {
        float before = valueAt(*field, points.x[i], points.y[i], points.z[i], 0);
        for (double radius = 0.01; radius < 200; radius *= 1.002) {
            const float value = valueAt(*field, points.x[i], points.y[i], points.z[i], radius);
            ASSERT_NEAR(value, before, 2.0) << radius;
            before = value;
        }
    }
}

TEST_P(Terrain, differsFromSeedToSeed)
{
    const std::shared_ptr<const Field> first = make(1);
    const std::shared_ptr<const Field> second = make(2);
    const Points points = pointsNearTheSurface(*first, 100, 500);
    EXPECT_GT(
        differingBits(valuesOf(*first, points.batch()), valuesOf(*second, points.batch())), 450U);
}

TEST_P(Terrain, isFiniteFarOutsideItsBox)
{
    const std::shared_ptr<const Field> field = make();
    for (const double far : {1e5, 1e7, 1e9}) {
        EXPECT_TRUE(std::isfinite(valueAt(*field, far, -far, 100)));
        EXPECT_LT(valueAt(*field, far, far, 2e4), 0);
    }
}

TEST(TerrainPresets, areTheFourThatUsersKnow)
{
    std::vector<std::string> names;
    for (const TerrainPreset& preset : terrainPresets())
        names.push_back(preset.name);
    EXPECT_EQ(names, (std::vector<std::string>{"alpine", "canyon", "islands", "karst"}));
}

TEST(TerrainPresets, areListedWhenOneIsUnknown)
{
    const core::Result<std::shared_ptr<const Field>> made = makeTerrain({.preset = "moon"});
    ASSERT_FALSE(made.has_value());
    EXPECT_EQ(made.error().code, core::ErrorCode::usage);
    EXPECT_NE(made.error().message.find("'moon'"), std::string::npos);
    EXPECT_NE(made.error().message.find("alpine, canyon, islands, karst"), std::string::npos);
}

TEST(SurfaceHeight, findsTheHighestSolidPoint)
{
    // z below 10 x, roughly: taken from a field with a known height.
    class Ramp final : public Field {
    public:
        void sample(const SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(10 * batch.x[i] - batch.z[i]);
        }
        core::Interval bounds(const core::Box&, core::Interval) const override { return {}; }
        double differenceStep(double) const override { return 0.1; }
    };
    const core::Box box{glm::dvec3(-1000), glm::dvec3(1000)};
    EXPECT_NEAR(surfaceHeight(Ramp{}, box, 12.3, 0), 123, 0.11);
    EXPECT_EQ(surfaceHeight(Ramp{}, box, -500, 0), -1000);
    EXPECT_NEAR(surfaceHeight(Ramp{}, box, 500, 0), 1000, 0.11);
}

} // namespace
} // namespace isofront::fields

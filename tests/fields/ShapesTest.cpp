#include "FieldChecks.h"

#include <isofront/fields/Combine.h>
#include <isofront/fields/Shapes.h>

#include <glm/geometric.hpp>

#include <ostream>

namespace isofront::fields {
namespace {

using namespace test;

core::Box cube(double half, const glm::dvec3& centre = glm::dvec3(0))
{
    return {centre - half, centre + half};
}

struct Case {
    const char* name;
    std::shared_ptr<const Field> field;
    bool distance; ///< the value is a distance: its gradient has length 1
};

void PrintTo(const Case& shape, std::ostream* stream)
{
    *stream << shape.name;
}

std::vector<Case> cases()
{
    const auto ball = sphere({0.1, -0.2, 0.3}, 0.8);
    const auto ring = torus({0.2, 0.1, 0}, 0.7, 0.25);
    return {
        {"sphere", ball, true},
        {"torus", ring, true},
        {"box", solidBox({{-0.7, -0.5, -0.6}, {0.8, 0.4, 0.9}}), true},
        {"plane", plane({0, 0, 0.1}, {1, 2, -3}), true},
        {"gyroid", gyroid(0.9), false},
        {"union", unionOf(ball, ring), true},
        {"intersection", intersectionOf(gyroid(0.7), ball), false},
        {"difference", differenceOf(ball, ring), true},
        {"placed", placed(ring, {0.2, -0.3, 0.1}, 1.7), true},
    };
}

class Shapes : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(
    All, Shapes, testing::ValuesIn(cases()), [](const testing::TestParamInfo<Case>& instance) {
        return std::string(instance.param.name);
    });

TEST_P(Shapes, stayWithinTheirBounds)
{
    expectBoundsHold(*GetParam().field, cube(2), 0.1, 3000, 50, 21);
    expectBoundsHold(*GetParam().field, cube(2, glm::dvec3(1000, 0, -1000)), 0.1, 300, 50, 22);
}

TEST_P(Shapes, haveGradientsThatMatchDifferences)
{
    Random random(23);
    // Where two parts meet, a difference across the crease sees both.
    expectGradientsMatchDifferences(
        *GetParam().field, randomPoints(random, cube(2), 0, 3000), 1e-3, 2e-3, 0.01);
}

TEST_P(Shapes, proveBoxesFarFromTheSurfaceEmptyOrFull)
{
    // A box whose samples all lie further from zero than its own diagonal must be decided.
    Random random(25);
    std::size_t clear = 0;
    std::size_t decided = 0;
    for (int i = 0; i < 3000; ++i) {
        const glm::dvec3 at(random(-2, 2), random(-2, 2), random(-2, 2));
        const double half = random(0.002, 0.05);
        const core::Interval bounds = GetParam().field->bounds(cube(half, at), {0, 0});
        if (std::abs(valueAt(*GetParam().field, at.x, at.y, at.z)) < 4 * float(half))
            continue;
        ++clear;
        decided += bounds.low > 0 || bounds.high < 0 ? 1U : 0U;
    }
    EXPECT_GT(clear, 1000U);
    EXPECT_EQ(decided, clear);
}

TEST(Sphere, hasTheDistanceAsValue)
{
    const auto field = sphere({1, 2, 3}, 2);
    EXPECT_EQ(valueAt(*field, 1, 2, 3), 2);
    EXPECT_EQ(valueAt(*field, 3, 2, 3), 0);
    EXPECT_EQ(valueAt(*field, 1, 2, 13), -8);
}

TEST(Torus, hasTheDistanceAsValue)
{
    const auto field = torus({0, 0, 0}, 3, 1);
    EXPECT_EQ(valueAt(*field, 3, 0, 0), 1);
    EXPECT_EQ(valueAt(*field, 0, 4, 0), 0);
    EXPECT_EQ(valueAt(*field, 0, 0, 0), -2);
    EXPECT_EQ(valueAt(*field, 0, 3, 5), -4);
}

TEST(SolidBox, hasTheDistanceAsValue)
{
    const auto field = solidBox({{-1, -2, -3}, {1, 2, 3}});
    EXPECT_EQ(valueAt(*field, 0, 0, 0), 1);
    EXPECT_EQ(valueAt(*field, 1, 2, 3), 0);
    EXPECT_EQ(valueAt(*field, 0, 1.5, 0), 0.5);
    EXPECT_EQ(valueAt(*field, 4, 6, 0), -5);
}

TEST(Gyroid, vanishesAlongItsKnownStraightAndPeriodicPlaces)
{
    // sin X cos Y + sin Y cos Z + sin Z cos X is zero at the origin and wherever X = Y = 0, Z = pi.
    const auto field = gyroid(2);
    EXPECT_EQ(valueAt(*field, 0, 0, 0), 0);
    EXPECT_NEAR(valueAt(*field, 0, 0, 1), 0, 1e-7);
    Random random(26);
    for (int i = 0; i < 1000; ++i) {
        const double x = random(-3, 3);
        const double y = random(-3, 3);
        const double z = random(-3, 3);
        const double radians = 3.141592653589793;
        const double expected = 2 / (3 * radians) *
                                (std::sin(radians * x) * std::cos(radians * y) +
                                 std::sin(radians * y) * std::cos(radians * z) +
                                 std::sin(radians * z) * std::cos(radians * x));
        ASSERT_NEAR(valueAt(*field, x, y, z), expected, 1e-7);
        ASSERT_NEAR(valueAt(*field, x + 2, y - 4, z), expected, 1e-7);
    }
}

TEST(Combinations, areSolidAsTheLogicSays)
{
    const auto a = sphere({0, 0, 0}, 1);
    const auto b = sphere({0.7, 0, 0}, 1);
    const auto either = unionOf(a, b);
    const auto both = intersectionOf(a, b);
    const auto without = differenceOf(a, b);
    Random random(27);
    for (int i = 0; i < 5000; ++i) {
        const double x = random(-2, 3);
        const double y = random(-2, 2);
        const double z = random(-2, 2);
        const bool inA = valueAt(*a, x, y, z) >= 0;
        const bool inB = valueAt(*b, x, y, z) >= 0;
        ASSERT_EQ(valueAt(*either, x, y, z) >= 0, inA || inB);
        ASSERT_EQ(valueAt(*both, x, y, z) >= 0, inA && inB);
        ASSERT_EQ(valueAt(*without, x, y, z) >= 0, inA && !inB);
    }
}

TEST(Placed, keepsDistances)
{
    const auto field = placed(sphere({0, 0, 0}, 1), {10, 0, 0}, 3);
    EXPECT_EQ(valueAt(*field, 10, 0, 0), 3);
    EXPECT_EQ(valueAt(*field, 10, 5, 0), -2);
}

TEST(AllShapes, haveUnitGradientsWhereTheValueIsADistance)
{
    for (const Case& shape : cases()) {
        if (!shape.distance)
            continue;
        Random random(24);
        const Points points = randomPoints(random, cube(2), 0, 1000);
        const Gradients g = gradientsOf(*shape.field, points.batch());
        for (std::size_t i = 0; i < points.size(); ++i)
            ASSERT_NEAR(glm::length(glm::dvec3(g.x[i], g.y[i], g.z[i])), 1, 1e-9) << shape.name;
    }
}

TEST(AllShapes, giveFiniteGradientsAtTheirCentres)
{
    for (const Case& shape : cases()) {
        const double zero = 0;
        double x = 0;
        double y = 0;
        double z = 0;
        shape.field->gradient({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {{&x, 1}, {&y, 1}, {&z, 1}});
        EXPECT_TRUE(std::isfinite(x) && std::isfinite(y) && std::isfinite(z)) << shape.name;
    }
}

} // namespace
} // namespace isofront::fields

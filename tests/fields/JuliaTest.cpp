#include "FieldChecks.h"

#include <isofront/fields/Julia.h>

#include <complex>

namespace isofront::fields {
namespace {

using namespace test;

const core::Box kDomain{glm::dvec3(-2), glm::dvec3(2)};

TEST(Julia, isSolidExactlyWhereTheOrbitStaysWithinTwo)
{
    // With c and the start in one plane, quaternions are complex numbers.
    const JuliaSettings settings{.c = {-0.2, 0.68, 0, 0}, .iterations = 9};
    const std::shared_ptr<const Field> field = julia(settings);
    Random random(31);
    std::size_t solid = 0;
    for (int i = 0; i < 20000; ++i) {
        const double x = random(-1.6, 1.6);
        const double y = random(-1.6, 1.6);
        std::complex<double> q(x, y);
        double largest = std::abs(q);
        for (int n = 0; n < settings.iterations; ++n) {
            q = q * q + std::complex<double>(-0.2, 0.68);
            largest = std::max(largest, std::abs(q));
        }
        const bool expected = std::abs(q) <= 2;
        ASSERT_EQ(expected, largest <= 2) << "an orbit that left came back";
        solid += expected ? 1U : 0U;
        if (std::abs(std::abs(q) - 2) > 1e-6) {
            ASSERT_EQ(valueAt(*field, x, y, 0) >= 0, expected) << x << ' ' << y;
        }
    }
    EXPECT_GT(solid, 1000U);
}

TEST(Julia, isTheUnitBallWithoutAConstant)
{
    // q -> q^2 keeps spheres: the surface is |q| = 2^(2^-N), and the estimate is half the distance.
    const std::shared_ptr<const Field> field = julia({.c = glm::dvec4(0), .iterations = 10});
    const double surface = std::exp2(std::exp2(-10.0));
    Random random(32);
    for (int i = 0; i < 1000; ++i) {
        const double r = surface + random(-0.01, 0.01);
        EXPECT_NEAR(valueAt(*field, 0, r, 0), 0.5 * (surface - r), 1e-4) << r;
    }
}

TEST(Julia, isContinuousWherePointsStopAtDifferentSteps)
{
    const std::shared_ptr<const Field> field = julia({});
    Random random(33);
    for (int i = 0; i < 300; ++i) {
        const double x = random(-2, 2);
        const double y = random(-2, 2);
        const double z = random(-2, 2);
        float before = valueAt(*field, x, y, z);
        for (int k = 1; k < 200; ++k) {
            const float value = valueAt(*field, x + k * 1e-7, y, z);
            // The estimate's slope is a few at most, and unbounded only where it is clamped.
            ASSERT_NEAR(value, before, 1e-5 * (1 + std::abs(double(value))))
                << x << ' ' << y << ' ' << z;
            before = value;
        }
    }
}

TEST(Julia, staysWithinItsBounds)
{
    for (const double slice : {0.0, 0.3})
        for (const glm::dvec4& c :
             {glm::dvec4(-0.2, 0.68, 0, 0),
              glm::dvec4(-0.29, -0.36, 0.4, -0.4),
              glm::dvec4(0),
              glm::dvec4(-1, 0.2, 0, 0)})
            expectBoundsHold(*julia({.c = c, .slice = slice}), kDomain, 0.1, 500, 100, 34);
}

TEST(Julia, isProvedEmptyFarOutAndNearTheSurfaceInSmallBoxes)
{
    const std::shared_ptr<const Field> field = julia({});
    const core::Interval corner = field->bounds({glm::dvec3(1.2), glm::dvec3(2)}, {0, 0});
    EXPECT_LT(corner.high, 0);

    Random random(35);
    std::size_t empty = 0;
    std::size_t proved = 0;
    const double edge = 4.0 / 64;
    for (int i = 0; i < 4000; ++i) {
        const glm::dvec3 low(random(-2, 2 - edge), random(-2, 2 - edge), random(-2, 2 - edge));
        const core::Box box{low, low + edge};
        const Points points = randomPoints(random, box, 0, 200);
        const std::vector<float> values = valuesOf(*field, points.batch());
        const bool solid = values[0] >= 0;
        const bool mixed = std::any_of(
            values.begin(), values.end(), [&](float value) { return (value >= 0) != solid; });
        if (mixed)
            continue;
        ++empty;
        const core::Interval bounds = field->bounds(box, {0, 0});
        proved += bounds.low > 0 || bounds.high < 0 ? 1U : 0U;
    }
    RecordProperty("provedPercent", static_cast<int>(100 * proved / empty));
    EXPECT_GT(double(proved), 0.8 * double(empty));
}

TEST(Julia, survivesOrbitsThroughTheOrigin)
{
    const std::shared_ptr<const Field> field = julia({.c = glm::dvec4(-1, 0, 0, 0)});
    for (const double x : {0.0, 1.0, -1.0}) {
        const float value = valueAt(*field, x, 0, 0);
        EXPECT_TRUE(std::isfinite(value)) << x;
        EXPECT_GE(value, 0) << x;
    }
    EXPECT_TRUE(std::isfinite(valueAt(*field, 1e200, 0, 0)));
}

} // namespace
} // namespace isofront::fields

#include "../support/FunctionField.h"
#include "../support/Random.h"

#include <isofront/fields/FieldRay.h>
#include <isofront/fields/Shapes.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::fields {
namespace {

glm::dvec3 pointIn(std::mt19937_64& generator, double reach)
{
    const double x = tests::uniform(generator, -reach, reach);
    const double y = tests::uniform(generator, -reach, reach);
    return {x, y, tests::uniform(generator, -reach, reach)};
}

FieldRay randomRay(std::mt19937_64& generator)
{
    const glm::dvec3 origin = pointIn(generator, 3);
    return {origin, pointIn(generator, 1) - origin, 0, 4};
}

/// Where a ray meets a sphere about the origin for the first time, in [from, to].
std::optional<double> sphereHit(const FieldRay& ray, double radius)
{
    const double a = glm::dot(ray.direction, ray.direction);
    const double b = glm::dot(ray.origin, ray.direction);
    const double root = b * b - a * (glm::dot(ray.origin, ray.origin) - radius * radius);
    if (root <= 0)
        return std::nullopt;
    for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a})
        if (ray.from <= t && t <= ray.to)
            return t;
    return std::nullopt;
}

TEST(FieldRay, meetsASphereWhereItIs)
{
    const auto ball = sphere({0, 0, 0}, 1);
    auto generator = tests::random(1);
    int hits = 0;
    int misses = 0;
    for (int i = 0; i < tests::trials(300); ++i) {
        const FieldRay ray = randomRay(generator);
        for (const double offset : {0.0, 0.25, -0.5}) {
            const double radius = 1 - offset;
            const auto expected = sphereHit(ray, radius);
            const auto found = castRay(*ball, ray, {.isovalue = offset});
            ASSERT_TRUE(found);
            ASSERT_EQ(found->has_value(), expected.has_value());
            expected ? ++hits : ++misses;
            if (!expected)
                continue;
            EXPECT_NEAR((*found)->t, *expected, 1e-6);
            const glm::dvec3 out = ray.at(*expected) / radius;
            EXPECT_LT(glm::distance(glm::normalize((*found)->gradient), -out), 1e-5);
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(hits, 100);
        EXPECT_GT(misses, 20);
    }
}

TEST(FieldRay, meetsAPlaneAtAnyDistance)
{
    const auto half = plane({0, 0, 0}, {1, 2, 2});
    auto generator = tests::random(2);
    for (int i = 0; i < tests::trials(300); ++i) {
        const FieldRay ray = randomRay(generator);
        const double from = glm::dot(ray.at(0), glm::dvec3(1, 2, 2)) / 3;
        const double to = glm::dot(ray.at(4), glm::dvec3(1, 2, 2)) / 3;
        const auto found = castRay(*half, ray, {});
        ASSERT_TRUE(found);
        ASSERT_EQ(found->has_value(), (from > 0) != (to > 0));
        if (*found) {
            EXPECT_NEAR((*found)->t, 4 * from / (from - to), 1e-9);
        }
    }
}

/// What is found is the first: before it the surface isn't crossed, by samples a hundred times as
/// close as the tube is thick.
TEST(FieldRay, meetsTheNearSideOfATorus)
{
    const auto ring = torus({0, 0, 0}, 1, 0.3);
    const auto value = [](const glm::dvec3& p) {
        return 0.3 - std::hypot(std::hypot(p.x, p.y) - 1, p.z);
    };
    auto generator = tests::random(3);
    int hits = 0;
    for (int i = 0; i < tests::trials(200); ++i) {
        const FieldRay ray = randomRay(generator);
        const auto found = castRay(*ring, ray, {});
        ASSERT_TRUE(found);
        const double end = *found ? (*found)->t : ray.to;
        if (*found) {
            ++hits;
            EXPECT_LT(std::abs(value(ray.at(end))), 1e-7);
        }
        constexpr int kSamples = 4000;
        const double margin = 1e-6 * end;
        for (int j = 0; j <= kSamples; ++j)
            ASSERT_EQ(value(ray.at((end - margin) * j / kSamples)) >= 0, value(ray.origin) >= 0);
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(hits, 50);
    }
}

TEST(FieldRay, findsWhatBoundsSayNothingOfByItsStep)
{
    // walls a hundredth thick, a tenth apart
    const tests::FunctionField walls([](const glm::dvec3& p, double) {
        return 0.005 - std::abs(p.x - 0.1 * std::round(p.x / 0.1));
    });
    for (int i = 0; i < 20; ++i) {
        const double start = 0.03 + 0.1 * i;
        const FieldRay ray{{start, 0, 0}, {2, 0, 0}, 0, 10};
        const auto found = castRay(walls, ray, {.step = 0.004});
        ASSERT_TRUE(found && *found);
        EXPECT_NEAR(ray.at((*found)->t).x, start + 0.065, 1e-8);
    }
}

TEST(FieldRay, takesWhatIsNoNumberForEmpty)
{
    const tests::FunctionField half([](const glm::dvec3& p, double) {
        return p.x < 0.5 ? std::numeric_limits<double>::quiet_NaN() : 1.0;
    });
    const auto found = castRay(half, {{0, 0, 0}, {1, 0, 0}, 0, 1}, {});
    ASSERT_TRUE(found && *found);
    EXPECT_NEAR((*found)->t, 0.5, 1e-12);
}

TEST(FieldRay, isGivenUpWhenAsked)
{
    std::stop_source source;
    source.request_stop();
    const auto found =
        castRay(*sphere({0, 0, 0}, 1), {{-2, 0, 0}, {1, 0, 0}, 0, 4}, {.stop = source.get_token()});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::interrupted);
}

TEST(ClippedRay, isWhatOfItLiesInTheBox)
{
    const core::Box box{{-1, -1, -1}, {1, 1, 1}};
    auto generator = tests::random(4);
    for (int i = 0; i < tests::trials(300); ++i) {
        const FieldRay ray = randomRay(generator);
        const auto inside = clipped(ray, box);
        for (int j = 0; j <= 400; ++j) {
            const double t = 0.01 * j;
            const glm::dvec3 point = glm::abs(ray.at(t));
            const double most = std::max({point.x, point.y, point.z});
            if (std::abs(most - 1) > 1e-9) {
                ASSERT_EQ(inside && inside->from <= t && t <= inside->to, most < 1);
            }
        }
    }
    // along a side
    EXPECT_TRUE(clipped({{0.5, 0.5, -3}, {0, 0, 1}, 0, 10}, box));
    EXPECT_FALSE(clipped({{1.5, 0.5, -3}, {0, 0, 1}, 0, 10}, box));
    EXPECT_FALSE(clipped({{0.5, 0.5, -3}, {0, 0, 1}, 5, 10}, box));
}

} // namespace
} // namespace isofront::fields

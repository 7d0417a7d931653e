#include "FieldChecks.h"

#include <isofront/fields/Embed.h>
#include <isofront/fields/Noise.h>
#include <isofront/fields/Shapes.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::fields {
namespace {

using namespace test;

/// Turned, stretched differently along each axis, and moved.
core::Affine oblique()
{
    core::Affine place;
    place.linear = {{0, 2, 0}, {-3, 0, 0.5}, {0, 0, 4}};
    place.translation = {10, -20, 30};
    return place;
}

/// Another field, of which only a box is known.
class Boxed final : public Field {
public:
    Boxed(std::shared_ptr<const Field> field, const core::Box& box)
        : _field(std::move(field)), _box(box)
    {
    }
    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        _field->sample(batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        _field->gradient(batch, gradients);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return _field->bounds(box, radius);
    }
    double differenceStep(double radius) const override { return _field->differenceStep(radius); }
    std::optional<core::Box> dataBox() const override { return _box; }

private:
    std::shared_ptr<const Field> _field;
    core::Box _box;
};

std::shared_ptr<const Field> waves()
{
    return fractalNoise({.seed = 5, .wavelength = 3, .octaves = 3});
}

TEST(Embedded, hasTheValueOfTheOwnPlaceLessTheIsovalue)
{
    const core::Affine place = oblique();
    const auto inner = waves();
    const auto field = embedded(inner, {.place = place, .isovalue = 0.25});
    // The map enlarges volumes 24 times.
    const double scale = std::cbrt(24.0);
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 own(random(-9, 9), random(-9, 9), random(-9, 9));
        const double radius = random(0, 2);
        const glm::dvec3 p = place.point(own);
        EXPECT_NEAR(
            double(valueAt(*field, p.x, p.y, p.z, radius * scale)),
            double(valueAt(*inner, own.x, own.y, own.z, radius)) - 0.25,
            2e-6);
    }
    EXPECT_FALSE(field->dataBox().has_value());
}

TEST(Embedded, endsWithAWallWhereTheDataEnds)
{
    const core::Affine place = oblique();
    const core::Box box{{-2, -3, -4}, {5, 6, 7}};
    const auto field = embedded(
        std::make_shared<Boxed>(plane({0, 0, 0}, {0, 0, -1}), box),
        {.place = place, .isovalue = -100, .sharpness = 8});
    // All is solid within, so the surface is the box.
    Random random(2);
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 own(random(-5, 8), random(-6, 9), random(-7, 10));
        const glm::dvec3 inset = glm::min(own - box.low, box.high - own);
        const double nearest = std::min({inset.x, inset.y, inset.z});
        const glm::dvec3 p = place.point(own);
        const double expected = std::min(own.z + 100, 8 * nearest);
        EXPECT_NEAR(double(valueAt(*field, p.x, p.y, p.z)), expected, 1e-4);
    }
}

TEST(Embedded, hasTheGradientOfItsValues)
{
    const core::Box box{{-2, -3, -4}, {5, 6, 7}};
    const auto field = embedded(
        std::make_shared<Boxed>(waves(), box),
        {.place = oblique(), .isovalue = 0.1, .sharpness = 1});
    Random random(3);
    const Points points = randomPoints(random, {{-30, -40, -10}, {40, 20, 80}}, 1, 400);
    // A few lie on edges where the wall begins.
    expectGradientsMatchDifferences(*field, points, 1e-3, 5e-3, 0.03);
}

TEST(Embedded, isWithinItsBounds)
{
    const core::Box box{{-2, -3, -4}, {5, 6, 7}};
    for (const double sharpness : {0.0, 1.0, 30.0}) {
        const auto field = embedded(
            std::make_shared<Boxed>(waves(), box),
            {.place = oblique(), .isovalue = 0.1, .sharpness = sharpness});
        expectBoundsHold(*field, {{-30, -30, -10}, {40, 40, 60}}, 4, 300, 60, 4);
    }
    const auto field = embedded(waves(), {.place = oblique(), .isovalue = 0.1});
    expectBoundsHold(*field, {{-30, -30, -10}, {40, 40, 60}}, 4, 300, 60, 5);
    // Far from the surface they say so.
    const auto ball = embedded(sphere({0, 0, 0}, 1), {.place = oblique()});
    EXPECT_LT(ball->bounds({{80, 80, 80}, {90, 90, 90}}, {0, 0}).high, -10);
}

} // namespace
} // namespace isofront::fields

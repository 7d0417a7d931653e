#include "isofront/fields/Shapes.h"

#include "Portable.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

namespace isofront::fields {

namespace {

double sign(double value)
{
    return value < 0 ? -1.0 : 1.0;
}

/// A unit vector, or zero for the zero vector: where a distance has no gradient.
glm::dvec3 direction(const glm::dvec3& v)
{
    const double length = glm::length(v);
    return length > 0 ? v / length : glm::dvec3(0);
}

/// The least and the most of |p| over an interval of p.
core::Interval magnitudes(double low, double high)
{
    const double least = low > 0 ? low : (high < 0 ? -high : 0.0);
    return {least, std::max(std::abs(low), std::abs(high))};
}

/// A field with `double value(p)`, `dvec3 slope(p)` and `Interval range(box)`, the last without
/// rounding. Written once for all, so that the loops hold no virtual call.
template <typename Shape>
class ShapeField final : public Field {
public:
    ShapeField(const Shape& shape, double size) : _shape(shape), _size(size) {}

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "as many values as points");
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(_shape.value({batch.x[i], batch.y[i], batch.z[i]}));
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const glm::dvec3 slope = _shape.slope({batch.x[i], batch.y[i], batch.z[i]});
            gradients.x[i] = slope.x;
            gradients.y[i] = slope.y;
            gradients.z[i] = slope.z;
        }
    }
    core::Interval bounds(const core::Box& box, core::Interval) const override
    {
        const core::Interval exact = _shape.range(box);
        return rounded(exact.low, exact.high, magnitudeOf(box) + _size);
    }
    double differenceStep(double radius) const override
    {
        return std::max(0.5 * radius, 1e-4 * _size);
    }

private:
    Shape _shape;
    double _size; // [field]: of features
};

template <typename Shape>
std::shared_ptr<const Field> fieldOf(const Shape& shape, double size)
{
    return std::make_shared<ShapeField<Shape>>(shape, size);
}

struct Sphere {
    glm::dvec3 centre;
    double radius;

    [[nodiscard]] double value(const glm::dvec3& p) const
    {
        return radius - glm::length(p - centre);
    }
    [[nodiscard]] glm::dvec3 slope(const glm::dvec3& p) const { return -direction(p - centre); }
    [[nodiscard]] core::Interval range(const core::Box& box) const
    {
        const glm::dvec3 low = box.low - centre;
        const glm::dvec3 high = box.high - centre;
        const core::Interval x = magnitudes(low.x, high.x);
        const core::Interval y = magnitudes(low.y, high.y);
        const core::Interval z = magnitudes(low.z, high.z);
        return {
            radius - glm::length(glm::dvec3(x.high, y.high, z.high)),
            radius - glm::length(glm::dvec3(x.low, y.low, z.low))};
    }
};

struct Torus {
    glm::dvec3 centre;
    double ring;
    double tube;

    [[nodiscard]] double value(const glm::dvec3& p) const
    {
        const glm::dvec3 d = p - centre;
        const double out = std::sqrt(d.x * d.x + d.y * d.y) - ring;
        return tube - std::sqrt(out * out + d.z * d.z);
    }
    [[nodiscard]] glm::dvec3 slope(const glm::dvec3& p) const
    {
        const glm::dvec3 d = p - centre;
        const glm::dvec3 outward = direction({d.x, d.y, 0});
        const double out = std::sqrt(d.x * d.x + d.y * d.y) - ring;
        return -direction(outward * out + glm::dvec3(0, 0, d.z));
    }
    [[nodiscard]] core::Interval range(const core::Box& box) const
    {
        const glm::dvec3 low = box.low - centre;
        const glm::dvec3 high = box.high - centre;
        const core::Interval x = magnitudes(low.x, high.x);
        const core::Interval y = magnitudes(low.y, high.y);
        const core::Interval z = magnitudes(low.z, high.z);
        const core::Interval out = magnitudes(
            std::sqrt(x.low * x.low + y.low * y.low) - ring,
            std::sqrt(x.high * x.high + y.high * y.high) - ring);
        return {
            tube - std::sqrt(out.high * out.high + z.high * z.high),
            tube - std::sqrt(out.low * out.low + z.low * z.low)};
    }
};

struct SolidBox {
    glm::dvec3 centre;
    glm::dvec3 half;

    /// @param q  |p - centre| - half
    [[nodiscard]] static double valueAt(const glm::dvec3& q)
    {
        const double inside = std::min(std::max({q.x, q.y, q.z}), 0.0);
        return -(glm::length(glm::max(q, glm::dvec3(0))) + inside);
    }
    [[nodiscard]] double value(const glm::dvec3& p) const
    {
        return valueAt(glm::abs(p - centre) - half);
    }
    [[nodiscard]] glm::dvec3 slope(const glm::dvec3& p) const
    {
        const glm::dvec3 d = p - centre;
        const glm::dvec3 q = glm::abs(d) - half;
        const glm::dvec3 signs(sign(d.x), sign(d.y), sign(d.z));
        if (q.x > 0 || q.y > 0 || q.z > 0)
            return -signs * direction(glm::max(q, glm::dvec3(0)));
        if (q.x >= q.y && q.x >= q.z)
            return {-signs.x, 0, 0};
        return q.y >= q.z ? glm::dvec3(0, -signs.y, 0) : glm::dvec3(0, 0, -signs.z);
    }
    [[nodiscard]] core::Interval range(const core::Box& box) const
    {
        const glm::dvec3 low = box.low - centre;
        const glm::dvec3 high = box.high - centre;
        const core::Interval x = magnitudes(low.x, high.x);
        const core::Interval y = magnitudes(low.y, high.y);
        const core::Interval z = magnitudes(low.z, high.z);
        // The value falls with each component of q.
        return {
            valueAt(glm::dvec3(x.high, y.high, z.high) - half),
            valueAt(glm::dvec3(x.low, y.low, z.low) - half)};
    }
};

struct Plane {
    glm::dvec3 point;
    glm::dvec3 outside;

    [[nodiscard]] double value(const glm::dvec3& p) const { return glm::dot(point - p, outside); }
    [[nodiscard]] glm::dvec3 slope(const glm::dvec3&) const { return -outside; }
    [[nodiscard]] core::Interval range(const core::Box& box) const
    {
        const double middle = value(box.centre());
        const double reach = glm::dot(0.5 * box.size(), glm::abs(outside));
        return {middle - reach, middle + reach};
    }
};

struct Gyroid {
    double turnsPerUnit;
    double scale;

    // Of the sum of products, X, Y and Z in radians. A slope along one axis is at most sqrt 2 (a
    // cosine times one number of magnitude up to 1, less a sine times another); a second derivative
    // along one axis too, and a mixed one at most 1.
    static constexpr double kSlope = 2.4494897427831781;     // sqrt 6
    static constexpr double kCurvature = 3.4142135623730951; // sqrt 2 + 2
    static constexpr double kTwoPi = 6.283185307179586;

    [[nodiscard]] double value(const glm::dvec3& p) const
    {
        const glm::dvec3 t = p * turnsPerUnit;
        return scale *
               (sineOfTurns(t.x) * cosineOfTurns(t.y) + sineOfTurns(t.y) * cosineOfTurns(t.z) +
                sineOfTurns(t.z) * cosineOfTurns(t.x));
    }
    [[nodiscard]] glm::dvec3 slope(const glm::dvec3& p) const
    {
        const glm::dvec3 t = p * turnsPerUnit;
        const glm::dvec3 s(sineOfTurns(t.x), sineOfTurns(t.y), sineOfTurns(t.z));
        const glm::dvec3 c(cosineOfTurns(t.x), cosineOfTurns(t.y), cosineOfTurns(t.z));
        return scale * kTwoPi * turnsPerUnit *
               glm::dvec3(c.x * c.y - s.z * s.x, c.y * c.z - s.x * s.y, c.z * c.x - s.y * s.z);
    }
    [[nodiscard]] core::Interval range(const core::Box& box) const
    {
        const glm::dvec3 centre = box.centre();
        const glm::dvec3 half = 0.5 * box.size();
        const double radians = kTwoPi * turnsPerUnit;
        const double distance = radians * glm::length(half);
        const double lipschitz = scale * kSlope * distance;
        const double taylor = glm::dot(glm::abs(slope(centre)), half) +
                              scale * 0.5 * kCurvature * distance * distance;
        const double reach = std::min(lipschitz, taylor) + scale * 1e-11;
        // A product is at most half the sum of its factors' squares, and those sum to 3.
        const double most = 1.5 * scale + scale * 1e-11;
        const double middle = value(centre);
        return {std::max(middle - reach, -most), std::min(middle + reach, most)};
    }
};

} // namespace

std::shared_ptr<const Field> sphere(const glm::dvec3& centre, double radius)
{
    return fieldOf(Sphere{centre, radius}, radius + glm::length(centre));
}

std::shared_ptr<const Field> torus(const glm::dvec3& centre, double ring, double tube)
{
    return fieldOf(Torus{centre, ring, tube}, ring + tube + glm::length(centre));
}

std::shared_ptr<const Field> solidBox(const core::Box& box)
{
    return fieldOf(
        SolidBox{box.centre(), 0.5 * box.size()}, glm::length(box.size()) + magnitudeOf(box));
}

std::shared_ptr<const Field> plane(const glm::dvec3& point, const glm::dvec3& outside)
{
    ISOFRONT_ASSERT(glm::length(outside) > 0, "a plane needs a normal");
    return fieldOf(Plane{point, glm::normalize(outside)}, 1 + glm::length(point));
}

std::shared_ptr<const Field> gyroid(double period)
{
    ISOFRONT_ASSERT(period > 0, "a period must be above zero");
    // The slope of the product sum is about 1.5 a radian where it is zero.
    return fieldOf(Gyroid{1.0 / period, period / (Gyroid::kTwoPi * 1.5)}, period);
}

} // namespace isofront::fields

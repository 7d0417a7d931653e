#include "isofront/fields/Julia.h"

#include "Portable.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

namespace isofront::fields {

namespace {

constexpr double kBailout = 1e8;
constexpr double kLogTwo = 0.6931471805599453;
constexpr double kLowest = -4.0;
constexpr double kHighest = 0.25;
// Keeps logarithm and quotient finite where an orbit runs through the origin.
constexpr double kSmallest = 1e-100;

glm::dvec4 squared(const glm::dvec4& q)
{
    return {
        q.x * q.x - q.y * q.y - q.z * q.z - q.w * q.w, 2 * q.x * q.y, 2 * q.x * q.z, 2 * q.x * q.w};
}

/// log |q_n| / 2^n relative to the potential of the surface, in units of 2^-n.
double potential(double length, int stepsLeft)
{
    double level = kLogTwo;
    for (int i = 0; i < stepsLeft; ++i)
        level *= 0.5;
    return logarithm(std::max(length, kSmallest)) - level;
}

class Julia final : public Field {
public:
    explicit Julia(const JuliaSettings& settings) : _settings(settings) {}

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "as many values as points");
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] =
                static_cast<float>(value({batch.x[i], batch.y[i], batch.z[i], _settings.slice}));
    }

    core::Interval bounds(const core::Box& box, core::Interval) const override
    {
        // Rounding of the points' own orbits: far above what forty steps lose within the bailout.
        constexpr double kGrown = 1 + 1e-9;
        glm::dvec4 q(box.centre(), _settings.slice);
        double radius = 0.5 * glm::length(box.size()) * kGrown + 1e-12;
        core::Interval slope{1, 1};
        core::Interval hull{
            std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        core::Interval length{0, 1e100};
        for (int n = 0; n <= _settings.iterations; ++n) {
            const double centre = glm::length(q);
            // What the ball says, and what the lengths of the step before say.
            length.low = std::max(length.low, centre - radius);
            length.high = std::min(length.high, centre + radius);
            if (!(length.high < 1e50))
                length.high = 1e50;
            if (n == _settings.iterations || length.high * length.high > kBailout)
                include(hull, quotient(length, slope, n));
            if (n == _settings.iterations || length.low * length.low > kBailout)
                break;
            // Orbits beyond the bailout have stopped; those that go on are no longer than it.
            const double longest = std::min(length.high, std::sqrt(kBailout) * kGrown);
            slope = {2 * length.low * slope.low * (1 - 1e-9), 2 * longest * slope.high * kGrown};
            const double shift = glm::length(_settings.c);
            length = {
                std::max(length.low * length.low - shift, 0.0) * (1 - 1e-9),
                (longest * longest + shift) * kGrown};
            radius = std::min((2 * centre * radius + radius * radius) * kGrown + 1e-12, 1e100);
            q = centre < 1e50 ? squared(q) + _settings.c : q;
        }
        const double slack = 1e-6;
        return {
            std::clamp(hull.low - slack * std::abs(hull.low) - 1e-12, kLowest, kHighest),
            std::clamp(hull.high + slack * std::abs(hull.high) + 1e-12, kLowest, kHighest)};
    }

    double differenceStep(double radius) const override { return std::max(0.5 * radius, 1e-5); }

private:
    [[nodiscard]] double value(glm::dvec4 q) const
    {
        double slope = 1;
        int n = 0;
        double square = glm::dot(q, q);
        while (n < _settings.iterations && square <= kBailout) {
            slope *= 2 * std::sqrt(square);
            q = squared(q) + _settings.c;
            square = glm::dot(q, q);
            ++n;
        }
        const double length = std::sqrt(square);
        const double estimate = -0.5 * length * potential(length, _settings.iterations - n) /
                                std::max(slope, kSmallest);
        return std::min(std::max(estimate, kLowest), kHighest);
    }

    /// The range of -length * potential / (2 slope).
    [[nodiscard]] core::Interval
    quotient(const core::Interval& length, const core::Interval& slope, int n) const
    {
        const int left = _settings.iterations - n;
        // A product of a length with a number that may have either sign.
        const double lowPotential = potential(length.low, left);
        const double highPotential = potential(length.high, left);
        const double low = lowPotential * (lowPotential < 0 ? length.high : length.low);
        const double high = highPotential * (highPotential < 0 ? length.low : length.high);
        const double least = std::max(slope.low, kSmallest);
        const double most = std::max(slope.high, kSmallest);
        return {-0.5 * high / (high > 0 ? least : most), -0.5 * low / (low > 0 ? most : least)};
    }

    static void include(core::Interval& hull, const core::Interval& more)
    {
        hull.low = std::min(hull.low, more.low);
        hull.high = std::max(hull.high, more.high);
    }

    JuliaSettings _settings;
};

} // namespace

std::shared_ptr<const Field> julia(const JuliaSettings& settings)
{
    ISOFRONT_ASSERT(glm::length(settings.c) <= 2, "the constant of a Julia set is at most 2 long");
    ISOFRONT_ASSERT(
        settings.iterations >= 1 && settings.iterations <= 40,
        "a Julia set takes between 1 and 40 steps");
    return std::make_shared<Julia>(settings);
}

} // namespace isofront::fields

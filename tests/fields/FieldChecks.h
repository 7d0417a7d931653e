#pragma once

#include "support/SameBits.h"

#include <isofront/fields/Field.h>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace isofront::fields::test {

/// Points with radii, drawn from fixed seeds.
struct Points {
    std::vector<double> x, y, z, radius;

    [[nodiscard]] SampleBatch batch() const { return {x, y, z, radius}; }
    [[nodiscard]] std::size_t size() const { return x.size(); }
};

class Random {
public:
    explicit Random(std::uint64_t seed) : _engine(seed) {}
    double operator()(double low, double high)
    {
        return low + (high - low) * (static_cast<double>(_engine() >> 11U) * 0x1p-53);
    }
    std::uint64_t word() { return _engine(); }

private:
    std::mt19937_64 _engine;
};

inline Points randomPoints(Random& random, const core::Box& box, double radius, std::size_t count)
{
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        points.x.push_back(random(box.low.x, box.high.x));
        points.y.push_back(random(box.low.y, box.high.y));
        points.z.push_back(random(box.low.z, box.high.z));
        points.radius.push_back(random(0, radius));
    }
    return points;
}

inline std::vector<float> valuesOf(const Field& field, const SampleBatch& batch)
{
    std::vector<float> values(batch.size());
    field.sample(batch, values);
    return values;
}

inline float valueAt(const Field& field, double x, double y, double z, double radius = 0)
{
    return valuesOf(field, {{&x, 1}, {&y, 1}, {&z, 1}, {&radius, 1}})[0];
}

inline std::vector<float> gridOf(const Field& field, const SampleGrid& grid)
{
    // A value that no noise has, to see that all are written.
    std::vector<float> values(grid.size(), 1e9F);
    field.sampleGrid(grid, values);
    return values;
}

/// The most by which two lists of numbers differ.
inline double worstDifference(const std::vector<float>& a, const std::vector<float>& b)
{
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, std::abs(double(a[i]) - double(b[i])));
    return worst;
}

/// The points of a grid, x fastest.
inline Points pointsOf(const SampleGrid& grid)
{
    Points points;
    for (std::int64_t k = 0; k < grid.count.z; ++k) {
        for (std::int64_t j = 0; j < grid.count.y; ++j) {
            for (std::int64_t i = 0; i < grid.count.x; ++i) {
                const auto at = [&](glm::length_t axis, std::int64_t index) {
                    return grid.origin[axis] +
                           grid.spacing * static_cast<double>(grid.first[axis] + index);
                };
                points.x.push_back(at(0, i));
                points.y.push_back(at(1, j));
                points.z.push_back(at(2, k));
                points.radius.push_back(grid.radius);
            }
        }
    }
    return points;
}

struct Gradients {
    std::vector<double> x, y, z;
};

inline Gradients gradientsOf(const Field& field, const SampleBatch& batch)
{
    Gradients gradients{
        std::vector<double>(batch.size()),
        std::vector<double>(batch.size()),
        std::vector<double>(batch.size())};
    field.gradient(batch, {gradients.x, gradients.y, gradients.z});
    return gradients;
}

using tests::differingBits;

/// Runs the body once for each instruction set that this machine has and the library was built for,
/// from the best to plain scalar code.
template <typename Body>
void onEveryInstructionSet(const Body& body)
{
    const std::int64_t all = hwy::SupportedTargets() | HWY_SCALAR | HWY_EMU128;
    for (std::int64_t left = all; left != 0; left &= left - 1) {
        const std::int64_t target = left & -left;
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(target);
        body(std::string(hwy::TargetName(target)));
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// Values mustn't depend on where in a batch a point stands.
inline void expectSameBitsAnywhereInABatch(const Field& field, const Points& points)
{
    const std::vector<float> whole = valuesOf(field, points.batch());
    for (std::size_t begin = 0; begin < 20; ++begin) {
        for (std::size_t count = 1; count < 40; ++count) {
            const SampleBatch part{
                std::span(points.x).subspan(begin, count),
                std::span(points.y).subspan(begin, count),
                std::span(points.z).subspan(begin, count),
                std::span(points.radius).subspan(begin, count)};
            const std::vector<float> expected(
                whole.begin() + std::ptrdiff_t(begin),
                whole.begin() + std::ptrdiff_t(begin + count));
            ASSERT_EQ(differingBits(valuesOf(field, part), expected), 0U)
                << begin << " + " << count;
        }
    }
}

/// Draws boxes of many sizes, and points and radii in them; none may leave the bounds.
inline void expectBoundsHold(
    const Field& field,
    const core::Box& domain,
    double radius,
    std::size_t boxes,
    std::size_t pointsPerBox,
    std::uint64_t seed)
{
    Random random(seed);
    const double edge = domain.size().x;
    for (std::size_t i = 0; i < boxes; ++i) {
        const glm::dvec3 size(
            edge * std::exp2(-random(0, 16)),
            edge * std::exp2(-random(0, 16)),
            edge * std::exp2(-random(0, 16)));
        const glm::dvec3 low(
            random(domain.low.x, domain.high.x - size.x),
            random(domain.low.y, domain.high.y - size.y),
            random(domain.low.z, domain.high.z - size.z));
        const core::Box box{low, low + size};
        const double most = i % 2 == 0 ? 0.0 : random(0, radius);
        const core::Interval bounds = field.bounds(box, {0.0, most});
        ASSERT_LE(bounds.low, bounds.high);
        const Points points = randomPoints(random, box, most, pointsPerBox);
        for (const float value : valuesOf(field, points.batch()))
            ASSERT_TRUE(bounds.contains(double(value)))
                << value << " outside [" << bounds.low << ", " << bounds.high << "], box " << i
                << " of edges " << size.x << ' ' << size.y << ' ' << size.z;
    }
}

/// The analytic gradient against central differences of the values.
/// @param tolerance  relative to 1 + the gradient's length; all but a share of the points keep it
inline void expectGradientsMatchDifferences(
    const Field& field, const Points& points, double step, double tolerance, double share = 0)
{
    const Gradients gradients = gradientsOf(field, points.batch());
    std::size_t misses = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto difference = [&](double dx, double dy, double dz) {
            const double r = points.radius[i];
            const double x = points.x[i];
            const double y = points.y[i];
            const double z = points.z[i];
            return (double(valueAt(field, x + dx, y + dy, z + dz, r)) -
                    double(valueAt(field, x - dx, y - dy, z - dz, r))) /
                   (2 * step);
        };
        const double ex = difference(step, 0, 0) - gradients.x[i];
        const double ey = difference(0, step, 0) - gradients.y[i];
        const double ez = difference(0, 0, step) - gradients.z[i];
        const double length = std::sqrt(
            gradients.x[i] * gradients.x[i] + gradients.y[i] * gradients.y[i] +
            gradients.z[i] * gradients.z[i]);
        const double error = std::sqrt(ex * ex + ey * ey + ez * ez) / (1 + length);
        misses += error <= tolerance ? 0U : 1U;
    }
    EXPECT_LE(double(misses), share * double(points.size()));
}

} // namespace isofront::fields::test

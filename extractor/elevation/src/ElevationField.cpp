#include "isofront/elevation/ElevationField.h"

#include "HeightPyramid.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace isofront::elevation {

namespace {

/// Calls take(begin, points) for one block of a batch after the other.
template <typename Take>
void forBlocks(const fields::SampleBatch& batch, const Take& take)
{
    HeightPoints points;
    const auto copy = [](std::span<const double> from, BlockOfDoubles& to) {
        std::ranges::copy(from, to.begin());
        // Vectors reach beyond the last point, and are cheapest where all are alike.
        std::fill(to.begin() + static_cast<std::ptrdiff_t>(from.size()), to.end(), from.back());
    };
    points.radius = {};
    for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
        points.size = std::min(kBlock, batch.size() - begin);
        copy(batch.x.subspan(begin, points.size), points.x);
        copy(batch.y.subspan(begin, points.size), points.y);
        if (!batch.radius.empty())
            copy(batch.radius.subspan(begin, points.size), points.radius);
        take(begin, points);
    }
}

void putSlopes(
    const HeightSlopes& slopes,
    std::size_t begin,
    std::size_t count,
    const fields::GradientSpans& gradients)
{
    for (std::size_t i = 0; i < count; ++i) {
        gradients.x[begin + i] = slopes.alongX[i];
        gradients.y[begin + i] = slopes.alongY[i];
        gradients.z[begin + i] = -1;
    }
}

void putValues(
    const HeightSlopes& slopes,
    std::size_t begin,
    std::size_t count,
    std::span<const double> z,
    std::span<float> values)
{
    for (std::size_t i = 0; i < count; ++i)
        values[begin + i] = static_cast<float>(slopes.height[i] - z[begin + i]);
}

} // namespace

ElevationField::ElevationField(HeightGrid grid, double reach)
{
    ISOFRONT_ASSERT(grid.columns >= 2 && grid.rows >= 2, "a raster has at least 2 x 2 posts");
    ISOFRONT_ASSERT(
        grid.heights.size() == grid.index(0, grid.rows), "a height for every post is needed");
    ISOFRONT_ASSERT(grid.spacing.x > 0 && grid.spacing.y > 0, "spacings are above 0");
    const glm::dvec2 low = grid.origin;
    const glm::dvec2 high = grid.origin + grid.extent();
    _pyramid = std::make_unique<const HeightPyramid>(std::move(grid));
    const core::Interval heights = _pyramid->allHeights();
    _dataBox = {{low.x, low.y, heights.low - reach}, {high.x, high.y, heights.high + reach}};
}

ElevationField::~ElevationField() = default;

void ElevationField::sample(const fields::SampleBatch& batch, std::span<float> values) const
{
    HeightSlopes found;
    forBlocks(batch, [&](std::size_t begin, const HeightPoints& points) {
        _pyramid->heights(points, found);
        putValues(found, begin, points.size, batch.z, values);
    });
}

void ElevationField::gradient(
    const fields::SampleBatch& batch, fields::GradientSpans gradients) const
{
    HeightSlopes found;
    forBlocks(batch, [&](std::size_t begin, const HeightPoints& points) {
        _pyramid->slopes(points, found);
        putSlopes(found, begin, points.size, gradients);
    });
}

void ElevationField::sampleWithGradient(
    const fields::SampleBatch& batch,
    std::span<float> values,
    fields::GradientSpans gradients) const
{
    HeightSlopes found;
    forBlocks(batch, [&](std::size_t begin, const HeightPoints& points) {
        _pyramid->slopes(points, found);
        putValues(found, begin, points.size, batch.z, values);
        putSlopes(found, begin, points.size, gradients);
    });
}

core::Interval ElevationField::bounds(const core::Box& box, core::Interval radius) const
{
    if (box.isEmpty())
        return {};
    const core::Interval heights = _pyramid->heights(box, radius);
    // Rounding to float is monotone, so that of the bounds holds that of the samples.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const auto outward = [](double value, float towards) {
        return double(std::nextafter(static_cast<float>(value), towards));
    };
    return {
        outward(heights.low - box.high.z, -kInfinity),
        outward(heights.high - box.low.z, kInfinity)};
}

double ElevationField::differenceStep(double) const
{
    return 0.25 * _pyramid->spacing();
}

std::uint64_t ElevationField::memoryBytes() const
{
    return _pyramid->memoryBytes();
}

} // namespace isofront::elevation

#include "isofront/elevation/ElevationField.h"

#include "HeightPyramid.h"

#include <isofront/core/Assert.h>

#include <cmath>
#include <limits>
#include <utility>

namespace isofront::elevation {

namespace {

double radiusAt(const fields::SampleBatch& batch, std::size_t i)
{
    return batch.radius.empty() ? 0.0 : batch.radius[i];
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
    for (std::size_t i = 0; i < batch.size(); ++i)
        values[i] = static_cast<float>(
            _pyramid->height(batch.x[i], batch.y[i], radiusAt(batch, i)) - batch.z[i]);
}

void ElevationField::gradient(
    const fields::SampleBatch& batch, fields::GradientSpans gradients) const
{
    for (std::size_t i = 0; i < batch.size(); ++i) {
        const HeightSlope slope = _pyramid->slope(batch.x[i], batch.y[i], radiusAt(batch, i));
        gradients.x[i] = slope.alongX;
        gradients.y[i] = slope.alongY;
        gradients.z[i] = -1;
    }
}

void ElevationField::sampleWithGradient(
    const fields::SampleBatch& batch,
    std::span<float> values,
    fields::GradientSpans gradients) const
{
    for (std::size_t i = 0; i < batch.size(); ++i) {
        const HeightSlope slope = _pyramid->slope(batch.x[i], batch.y[i], radiusAt(batch, i));
        values[i] = static_cast<float>(slope.height - batch.z[i]);
        gradients.x[i] = slope.alongX;
        gradients.y[i] = slope.alongY;
        gradients.z[i] = -1;
    }
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

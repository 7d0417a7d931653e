#include "isofront/fields/Field.h"

#include <algorithm>
#include <array>
#include <vector>

namespace isofront::fields {

void Field::gradient(const SampleBatch& batch, GradientSpans gradients) const
{
    // Six samples a point, a block of points at a time so that the scratch stays in cache.
    constexpr std::size_t kBlock = 64;
    std::array<double, 6 * kBlock> x; // all that is read is written before
    std::array<double, 6 * kBlock> y;
    std::array<double, 6 * kBlock> z;
    std::array<double, 6 * kBlock> radius;
    std::array<float, 6 * kBlock> value;
    std::array<double, kBlock> step;

    for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
        const std::size_t count = std::min(kBlock, batch.size() - begin);
        for (std::size_t i = 0; i < count; ++i) {
            const double r = batch.radius.empty() ? 0.0 : batch.radius[begin + i];
            step[i] = differenceStep(r);
            for (std::size_t k = 0; k < 6; ++k) {
                const double offset = k % 2 == 0 ? step[i] : -step[i];
                x[6 * i + k] = batch.x[begin + i] + (k / 2 == 0 ? offset : 0.0);
                y[6 * i + k] = batch.y[begin + i] + (k / 2 == 1 ? offset : 0.0);
                z[6 * i + k] = batch.z[begin + i] + (k / 2 == 2 ? offset : 0.0);
                radius[6 * i + k] = r;
            }
        }
        const std::size_t samples = 6 * count;
        sample(
            {std::span(x).first(samples),
             std::span(y).first(samples),
             std::span(z).first(samples),
             std::span(radius).first(samples)},
            std::span(value).first(samples));
        for (std::size_t i = 0; i < count; ++i) {
            const auto difference = [&](std::size_t k) {
                return (double(value[6 * i + k]) - double(value[6 * i + k + 1])) / (2 * step[i]);
            };
            gradients.x[begin + i] = difference(0);
            gradients.y[begin + i] = difference(2);
            gradients.z[begin + i] = difference(4);
        }
    }
}

void Field::sampleWithGradient(
    const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const
{
    sample(batch, values);
    gradient(batch, gradients);
}

void Field::sampleGrid(const SampleGrid& grid, std::span<float> values) const
{
    // Row after row, so that the scratch stays in cache.
    const auto length = static_cast<std::size_t>(grid.count.x);
    std::vector<double> x(length);
    std::vector<double> y(length);
    std::vector<double> z(length);
    const std::vector<double> radius(length, grid.radius);
    const auto at = [&](std::size_t axis, std::int64_t i) {
        return grid.origin[axis] + grid.spacing * static_cast<double>(grid.first[axis] + i);
    };
    for (std::size_t i = 0; i < length; ++i)
        x[i] = at(0, static_cast<std::int64_t>(i));
    for (std::int64_t k = 0; k < grid.count.z; ++k) {
        std::ranges::fill(z, at(2, k));
        for (std::int64_t j = 0; j < grid.count.y; ++j) {
            std::ranges::fill(y, at(1, j));
            const auto row = static_cast<std::size_t>(k * grid.count.y + j);
            sample({x, y, z, radius}, values.subspan(row * length, length));
        }
    }
}

void Field::attributes(const SampleBatch& /*batch*/, std::span<std::uint32_t> words) const
{
    std::ranges::fill(words, 0U);
}

} // namespace isofront::fields

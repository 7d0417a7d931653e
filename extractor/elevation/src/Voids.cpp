#include "Voids.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace isofront::elevation {

namespace {

struct Grid {
    std::size_t columns = 0;
    std::size_t rows = 0;
    std::vector<float> values; ///< NaN where nothing is known
};

/// Means of blocks of 2 x 2, of what is known in them.
Grid halved(const Grid& fine)
{
    Grid coarse{(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
    coarse.values.reserve(coarse.columns * coarse.rows);
    for (std::size_t row = 0; row < coarse.rows; ++row) {
        for (std::size_t column = 0; column < coarse.columns; ++column) {
            double sum = 0;
            int count = 0;
            for (std::size_t y = 2 * row; y < std::min(2 * row + 2, fine.rows); ++y)
                for (std::size_t x = 2 * column; x < std::min(2 * column + 2, fine.columns); ++x)
                    if (const float value = fine.values[y * fine.columns + x]; !std::isnan(value)) {
                        sum += double(value);
                        ++count;
                    }
            coarse.values.push_back(
                count > 0 ? static_cast<float>(sum / count)
                          : std::numeric_limits<float>::quiet_NaN());
        }
    }
    return coarse;
}

/// A first guess: what the coarser grid, itself filled, has at the place.
void fillFromCoarser(Grid& grid)
{
    if (std::none_of(grid.values.begin(), grid.values.end(), [](float v) { return std::isnan(v); }))
        return;
    Grid coarse = halved(grid);
    fillFromCoarser(coarse);
    for (std::size_t row = 0; row < grid.rows; ++row)
        for (std::size_t column = 0; column < grid.columns; ++column)
            if (float& value = grid.values[row * grid.columns + column]; std::isnan(value))
                value = coarse.values[row / 2 * coarse.columns + column / 2];
}

} // namespace

std::uint64_t fillVoids(HeightGrid& grid)
{
    std::vector<std::size_t> voids;
    for (std::size_t i = 0; i < grid.heights.size(); ++i)
        if (std::isnan(grid.heights[i]))
            voids.push_back(i);
    if (voids.empty() || voids.size() == grid.heights.size())
        return voids.size();

    const auto columns = static_cast<std::size_t>(grid.columns);
    const auto rows = static_cast<std::size_t>(grid.rows);
    Grid guess{columns, rows, std::move(grid.heights)};
    fillFromCoarser(guess);
    grid.heights = std::move(guess.values);

    // Gauss-Seidel with over-relaxation, in place and in order.
    constexpr double kRelaxation = 1.8;
    constexpr std::size_t kMostSteps = 200'000'000;
    constexpr double kEnough = 0.01; // [m] the largest change of a sweep
    std::vector<double> heights(voids.size());
    for (std::size_t i = 0; i < voids.size(); ++i)
        heights[i] = double(grid.heights[voids[i]]);
    const std::size_t sweeps = std::clamp<std::size_t>(kMostSteps / voids.size(), 4, 2000);
    for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
        double change = 0;
        for (std::size_t i = 0; i < voids.size(); ++i) {
            const std::size_t at = voids[i];
            const std::size_t column = at % columns;
            const std::size_t row = at / columns;
            double sum = 0;
            int count = 0;
            const auto add = [&](std::size_t neighbour) {
                sum += double(grid.heights[neighbour]);
                ++count;
            };
            if (column > 0)
                add(at - 1);
            if (column + 1 < columns)
                add(at + 1);
            if (row > 0)
                add(at - columns);
            if (row + 1 < rows)
                add(at + columns);
            const double step = kRelaxation * (sum / count - heights[i]);
            heights[i] += step;
            grid.heights[at] = static_cast<float>(heights[i]);
            change = std::max(change, std::abs(step));
        }
        if (change < kEnough)
            break;
    }
    return voids.size();
}

} // namespace isofront::elevation

#include "HeightRange.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isofront::elevation {

namespace {

constexpr int kBrickBits = 3;
/// A query looks at no more bricks than this along an axis; a larger box uses a coarser level.
constexpr int kMostBricks = 4;

/// Bernstein coefficients of the Catmull-Rom segment between b and c.
template <typename T>
std::array<double, 4> bernstein(T a, T b, T c, T d)
{
    const auto [pa, pb, pc, pd] = std::array<double, 4>{double(a), double(b), double(c), double(d)};
    return {pb, pb + (pc - pa) / 6, pc - (pd - pb) / 6, pc};
}

HeightRange rangeOfPatch(const PaddedGrid& grid, int column, int row)
{
    std::array<std::array<double, 4>, 4> rows{};
    const float* post = grid.cornerOf(column, row);
    for (std::array<double, 4>& coefficients : rows) {
        coefficients = bernstein(post[0], post[1], post[2], post[3]);
        post += grid.stride();
    }
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t i = 0; i < 4; ++i)
        for (const double value : bernstein(rows[0][i], rows[1][i], rows[2][i], rows[3][i])) {
            low = std::min(low, value);
            high = std::max(high, value);
        }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    return {
        std::nextafter(static_cast<float>(low), -kInfinity),
        std::nextafter(static_cast<float>(high), kInfinity)};
}

} // namespace

HeightRangeTree::HeightRangeTree(const PaddedGrid& grid)
    : _patchColumns(std::max(grid.columns - 1, 1)), _patchRows(std::max(grid.rows - 1, 1))
{
    const auto bricksFor = [](int patches) { return (patches + 7) >> kBrickBits; };
    Level finest{bricksFor(_patchColumns), bricksFor(_patchRows), {}};
    finest.bricks.reserve(
        static_cast<std::size_t>(finest.columns) * static_cast<std::size_t>(finest.rows));
    for (int row = 0; row < finest.rows; ++row) {
        for (int column = 0; column < finest.columns; ++column) {
            HeightRange found = rangeOfPatch(grid, column << kBrickBits, row << kBrickBits);
            for (int y = row << kBrickBits; y < std::min((row + 1) << kBrickBits, _patchRows); ++y)
                for (int x = column << kBrickBits;
                     x < std::min((column + 1) << kBrickBits, _patchColumns);
                     ++x)
                    found.include(rangeOfPatch(grid, x, y));
            finest.bricks.push_back(found);
        }
    }
    _levels.push_back(std::move(finest));
    while (_levels.back().bricks.size() > 1) {
        const Level& fine = _levels.back();
        Level coarse{(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
        for (int row = 0; row < coarse.rows; ++row) {
            for (int column = 0; column < coarse.columns; ++column) {
                HeightRange found = fine.at(2 * column, 2 * row);
                for (int y = 2 * row; y < std::min(2 * row + 2, fine.rows); ++y)
                    for (int x = 2 * column; x < std::min(2 * column + 2, fine.columns); ++x)
                        found.include(fine.at(x, y));
                coarse.bricks.push_back(found);
            }
        }
        _levels.push_back(std::move(coarse));
    }
}

HeightRange HeightRangeTree::range(double lowX, double highX, double lowY, double highY) const
{
    // A point on a line of posts belongs to the patches of either side, which agree there.
    const auto firstPatch = [](double low, int patches) {
        return std::clamp(static_cast<int>(low), 0, patches - 1);
    };
    const auto lastPatch = [](double high, int first, int patches) {
        return std::clamp(static_cast<int>(std::ceil(high)) - 1, first, patches - 1);
    };
    const int x0 = firstPatch(lowX, _patchColumns);
    const int y0 = firstPatch(lowY, _patchRows);
    const int x1 = lastPatch(highX, x0, _patchColumns);
    const int y1 = lastPatch(highY, y0, _patchRows);
    int shift = kBrickBits;
    while ((x1 >> shift) - (x0 >> shift) >= kMostBricks ||
           (y1 >> shift) - (y0 >> shift) >= kMostBricks)
        ++shift;
    const Level& level = _levels[static_cast<std::size_t>(shift - kBrickBits)];
    HeightRange found = level.at(x0 >> shift, y0 >> shift);
    for (int y = y0 >> shift; y <= y1 >> shift; ++y)
        for (int x = x0 >> shift; x <= x1 >> shift; ++x)
            found.include(level.at(x, y));
    return found;
}

std::uint64_t HeightRangeTree::memoryBytes() const
{
    std::uint64_t bytes = 0;
    for (const Level& level : _levels)
        bytes += level.bricks.size() * sizeof(HeightRange);
    return bytes;
}

} // namespace isofront::elevation

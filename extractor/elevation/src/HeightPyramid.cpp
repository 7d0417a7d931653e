#include "HeightPyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isofront::elevation {

namespace {

/// A value of a row of at least two, mirrored at the point where it ends (odd reflection): linear
/// rows go on in a straight line.
/// @param at  gives the value at 0 .. count - 1
template <typename At>
double continued(int index, int count, const At& at)
{
    const int last = count - 1;
    if (index < 0)
        return 2 * at(0) - continued(-index, count, at);
    if (index > last)
        return 2 * at(last) - continued(2 * last - index, count, at);
    return at(index);
}

/// [1 4 6 4 1] / 16 around a value of a row.
template <typename At>
double binomial(int index, int count, const At& at)
{
    const auto value = [&](int offset) { return continued(index + offset, count, at); };
    return ((value(-2) + value(2)) + 4 * (value(-1) + value(1)) + 6 * value(0)) * 0.0625;
}

/// How many posts half the resolution has, so that the first stay and the last are not lost.
int halved(int count)
{
    return count / 2 + 1;
}

PaddedGrid padded(int columns, int rows, const std::vector<float>& heights)
{
    PaddedGrid grid;
    grid.columns = columns;
    grid.rows = rows;
    grid.posts.resize(grid.stride() * (static_cast<std::size_t>(rows) + 2));
    const auto post = [&](int column, int row) {
        return continued(row, rows, [&](int r) {
            return continued(column, columns, [&](int c) {
                return double(heights
                                  [static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
                                   static_cast<std::size_t>(c)]);
            });
        });
    };
    std::size_t next = 0;
    for (int row = -1; row <= rows; ++row)
        for (int column = -1; column <= columns; ++column)
            grid.posts[next++] = static_cast<float>(post(column, row));
    return grid;
}

/// Low passed along x, then along y, every second post kept.
std::vector<float> reduced(const PaddedGrid& fine)
{
    const int columns = halved(fine.columns);
    const int rows = halved(fine.rows);
    const auto width = static_cast<std::size_t>(columns);
    std::vector<double> narrow(width * static_cast<std::size_t>(fine.rows));
    for (int row = 0; row < fine.rows; ++row) {
        const float* posts = fine.cornerOf(1, row + 1); // the row's own first post
        for (int column = 0; column < columns; ++column)
            narrow[static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column)] =
                binomial(2 * column, fine.columns, [&](int i) { return double(posts[i]); });
    }
    std::vector<float> result(width * static_cast<std::size_t>(rows));
    for (int row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < width; ++column)
            result[static_cast<std::size_t>(row) * width + column] =
                static_cast<float>(binomial(2 * row, fine.rows, [&](int j) {
                    return narrow[static_cast<std::size_t>(j) * width + column];
                }));
    return result;
}

/// The greatest sum of c_k * value_k over weights that add up to 1, each within its limits.
struct Share {
    double value;
    double least;
    double most;
};
double greatestMean(std::vector<Share>& shares)
{
    std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
        return a.value > b.value;
    });
    double free = 1;
    double sum = 0;
    for (const Share& share : shares) {
        free -= share.least;
        sum += share.least * share.value;
    }
    for (const Share& share : shares) {
        const double more = std::clamp(share.most - share.least, 0.0, std::max(free, 0.0));
        sum += more * share.value;
        free -= more;
    }
    return sum;
}

} // namespace

HeightPyramid::HeightPyramid(HeightGrid grid)
    : _origin(grid.origin), _postsPerMetre(1.0 / grid.spacing),
      _lastPost(grid.columns - 1, grid.rows - 1),
      _spacing(std::sqrt(grid.spacing.x * grid.spacing.y)), _cyclesPerMetre(0.3 / _spacing)
{
    PaddedGrid level = padded(grid.columns, grid.rows, grid.heights);
    grid.heights = {};
    while (true) {
        const bool isLast = level.columns <= 2 && level.rows <= 2;
        const int columns = halved(level.columns);
        const int rows = halved(level.rows);
        const std::vector<float> next = isLast ? std::vector<float>{} : reduced(level);
        HeightRangeTree ranges(level);
        _levels.push_back({std::move(level), std::move(ranges)});
        if (isLast)
            break;
        level = padded(columns, rows, next);
    }
    for (const Level& made : _levels)
        _grids.push_back(&made.grid);
}

void HeightPyramid::heights(const HeightPoints& points, HeightSlopes& out) const
{
    sumLevels(levels(), points, false, out);
}

void HeightPyramid::slopes(const HeightPoints& points, HeightSlopes& out) const
{
    sumLevels(levels(), points, true, out);
}

HeightLevels HeightPyramid::levels() const
{
    return {_grids, _origin, _postsPerMetre, _lastPost, _cyclesPerMetre};
}

HeightPyramid::Place HeightPyramid::placeOf(double x, double y) const
{
    // written so that NaN goes to the low side
    const auto clamped = [](double value, double last) {
        return value > 0 ? std::min(value, last) : 0.0;
    };
    return {
        clamped((x - _origin.x) * _postsPerMetre.x, _lastPost.x),
        clamped((y - _origin.y) * _postsPerMetre.y, _lastPost.y)};
}

core::Interval HeightPyramid::heights(const core::Box& box, core::Interval radius) const
{
    const Place low = placeOf(box.low.x, box.low.y);
    const Place high = placeOf(box.high.x, box.high.y);
    const std::size_t last = _levels.size() - 1;
    // The weight of level k is w(f_k r) - w(f_(k-1) r), and w never increases.
    const double leastCycles = std::max(radius.low, 0.0) * _cyclesPerMetre;
    const double mostCycles = std::max(radius.high, 0.0) * _cyclesPerMetre;
    double scale = 1;
    double beforeAtLeast = 0;
    double beforeAtMost = 0;
    std::vector<Share> tops;
    std::vector<Share> bottoms;
    for (std::size_t k = 0; k <= last; ++k, scale *= 0.5) {
        const double atLeast = k == last ? 1.0 : filterWeight(leastCycles * scale);
        const double atMost = k == last ? 1.0 : filterWeight(mostCycles * scale);
        const double most = std::max(atLeast - beforeAtMost, 0.0);
        if (most > 0) {
            const double least = std::max(atMost - beforeAtLeast, 0.0);
            const HeightRange range = _levels[k].ranges.range(
                low.u * scale, high.u * scale, low.v * scale, high.v * scale);
            tops.push_back({double(range.high), least, most});
            bottoms.push_back({-double(range.low), least, most});
        }
        if (atMost >= 1)
            break;
        beforeAtLeast = atLeast;
        beforeAtMost = atMost;
    }
    const double most = greatestMean(tops);
    const double least = -greatestMean(bottoms);
    const double slack = 1e-13 * (std::abs(most) + std::abs(least)) + 1e-30; // for rounding
    return {least - slack, most + slack};
}

core::Interval HeightPyramid::allHeights() const
{
    const HeightRange found = _levels.front().ranges.all();
    return {double(found.low), double(found.high)};
}

std::uint64_t HeightPyramid::memoryBytes() const
{
    std::uint64_t bytes = 0;
    for (const Level& level : _levels)
        bytes += level.grid.posts.size() * sizeof(float) + level.ranges.memoryBytes();
    return bytes;
}

} // namespace isofront::elevation

#include "HeightPyramid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isofront::elevation {

namespace {

constexpr double kPassing = 1.0 / 64; // below it the filter passes everything
constexpr double kStopping = 3.0;     // and from here on nothing

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

/// Where a point lies between the posts of a level.
struct Patch {
    const float* corner; ///< the post before the patch's first, on both axes
    double s, t;         ///< from 0 to 1 in it
};

Patch patchOf(const PaddedGrid& grid, double u, double v)
{
    const int column = std::min(static_cast<int>(u), std::max(grid.columns - 2, 0));
    const int row = std::min(static_cast<int>(v), std::max(grid.rows - 2, 0));
    return {grid.cornerOf(column, row), u - column, v - row};
}

/// Weights of four posts in a row, between the middle two (Catmull-Rom).
std::array<double, 4> weights(double t)
{
    return {
        t * (-0.5 + t * (1 - 0.5 * t)),
        1 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t)};
}

/// Their derivatives.
std::array<double, 4> slopes(double t)
{
    return {
        -0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t), t * (-1 + 1.5 * t)};
}

double dot(const std::array<double, 4>& w, const float* posts)
{
    return (w[0] * double(posts[0]) + w[1] * double(posts[1])) +
           (w[2] * double(posts[2]) + w[3] * double(posts[3]));
}

double dot(const std::array<double, 4>& w, const std::array<double, 4>& values)
{
    return (w[0] * values[0] + w[1] * values[1]) + (w[2] * values[2] + w[3] * values[3]);
}

std::array<double, 4>
rowValues(const PaddedGrid& grid, const float* corner, const std::array<double, 4>& w)
{
    const std::size_t stride = grid.stride();
    return {
        dot(w, corner),
        dot(w, corner + stride),
        dot(w, corner + 2 * stride),
        dot(w, corner + 3 * stride)};
}

double heightAt(const PaddedGrid& grid, double u, double v)
{
    const Patch patch = patchOf(grid, u, v);
    return dot(weights(patch.t), rowValues(grid, patch.corner, weights(patch.s)));
}

/// Slopes in metres a post.
HeightSlope slopeAt(const PaddedGrid& grid, double u, double v)
{
    const Patch patch = patchOf(grid, u, v);
    const std::array<double, 4> across = weights(patch.t);
    const std::array<double, 4> values = rowValues(grid, patch.corner, weights(patch.s));
    return {
        dot(across, values),
        dot(across, rowValues(grid, patch.corner, slopes(patch.s))),
        dot(slopes(patch.t), values)};
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

double filterWeight(double x)
{
    if (!(x < kStopping))
        return 0;
    if (x < kPassing)
        return 1;
    // exp(-q) as the 16th power of its Taylor polynomial at q / 16 < 0.6
    const double t = x * x * 0.0625;
    double power = -1.0 / 5040;
    power = power * t + 1.0 / 720;
    power = power * t - 1.0 / 120;
    power = power * t + 1.0 / 24;
    power = power * t - 1.0 / 6;
    power = power * t + 0.5;
    power = power * t - 1;
    power = power * t + 1;
    power *= power;
    power *= power;
    power *= power;
    return power * power;
}

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

template <typename Visit>
void HeightPyramid::forLevels(double radius, Visit&& visit) const
{
    const std::size_t last = _levels.size() - 1;
    const double x = radius * _cyclesPerMetre;
    double before = 0; // weight of the band before
    double scale = 1;  // of this level's posts to the finest
    for (std::size_t k = 0; k <= last; ++k, scale *= 0.5) {
        const double weight = k == last ? 1.0 : filterWeight(x * scale);
        if (weight > before)
            visit(_levels[k].grid, weight - before, scale);
        if (weight >= 1)
            return;
        before = weight;
    }
}

double HeightPyramid::height(double x, double y, double radius) const
{
    const Place place = placeOf(x, y);
    double sum = 0;
    forLevels(radius, [&](const PaddedGrid& level, double weight, double scale) {
        sum += weight * heightAt(level, place.u * scale, place.v * scale);
    });
    return sum;
}

HeightSlope HeightPyramid::slope(double x, double y, double radius) const
{
    const Place place = placeOf(x, y);
    HeightSlope sum;
    forLevels(radius, [&](const PaddedGrid& level, double weight, double scale) {
        const HeightSlope found = slopeAt(level, place.u * scale, place.v * scale);
        sum.height += weight * found.height;
        sum.alongX += weight * scale * found.alongX;
        sum.alongY += weight * scale * found.alongY;
    });
    sum.alongX *= _postsPerMetre.x;
    sum.alongY *= _postsPerMetre.y;
    return sum;
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

#include "FilterBands.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::volume::detail {

namespace {

/// exp(-u) for 0 <= u <= 1/15, the same on every machine.
double smallExponential(double u)
{
    double series = kExponentialSeries[0];
    for (std::size_t i = 1; i < kExponentialSeries.size(); ++i)
        series = series * u + kExponentialSeries[i];
    return series;
}

double stretched(double exponential)
{
    return std::clamp((exponential - kCut) * kStretch, 0.0, 1.0);
}

double toTheFourth(double value)
{
    const double square = value * value;
    return square * square;
}

/// A radius relative to the band for which it is just large enough to count.
struct ScaledRadius {
    int band = -1;          ///< the coarsest band that is damped, -1 if none is
    double exponential = 1; ///< exp(-(f r)^2) for that band; the next finer has its fourth power
};

/// @param radius  finite
ScaledRadius scaled(double radius)
{
    ScaledRadius result;
    if (!(radius > kPlainRadius))
        return result;
    while (radius > kPlainRadius) {
        radius *= 0.5;
        ++result.band;
    }
    const double x = kCyclesPerVoxel * (2.0 * radius);
    result.exponential = smallExponential(x * x);
    return result;
}

/// No c_k between the first and the last exceeds the greatest difference of a number and its
/// fourth power, stretched.
constexpr double kMostBetween = 0.49;

} // namespace

double topRadius(int top)
{
    return std::ldexp(16.0 * kPlainRadius, top);
}

int coarsestDamped(double radius)
{
    return scaled(radius).band;
}

double bandWeight(int band, double radius)
{
    if (radius >= topRadius(band + 1))
        return 0.0;
    const ScaledRadius relative = scaled(radius);
    if (band > relative.band)
        return 1.0;
    double exponential = relative.exponential;
    for (int k = relative.band; k > band; --k)
        exponential = toTheFourth(exponential);
    return stretched(exponential);
}

LevelWeights levelWeights(double radius, int top)
{
    LevelWeights result;
    if (!(radius > kPlainRadius) || top == 0)
        return result;
    if (radius >= topRadius(top)) {
        result.first = top;
        return result;
    }
    // From coarse to fine, as the exponentials come.
    std::array<double, LevelWeights::kMost> found{};
    std::size_t count = 0;
    ScaledRadius relative = scaled(radius);
    double coarser = 1.0;
    int band = relative.band;
    for (; band >= 0 && coarser > 0.0; --band) {
        if (band < top) {
            const double weight = stretched(relative.exponential);
            if (coarser > weight) {
                found[count++] = coarser - weight;
                result.first = band + 1;
            }
            coarser = weight;
        }
        relative.exponential = toTheFourth(relative.exponential);
    }
    if (coarser > 0.0) {
        found[count++] = coarser;
        result.first = 0;
    }
    result.count = static_cast<int>(count);
    std::reverse_copy(
        found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), result.weight.begin());
    return result;
}

LevelSpan levelSpan(core::Interval radius, int top)
{
    const LevelWeights finest = levelWeights(radius.low, top);
    const LevelWeights coarsest = levelWeights(radius.high, top);
    return {finest.first, coarsest.first + coarsest.count};
}

core::Interval
filteredBounds(core::Interval radius, int top, std::span<const core::Interval> levels)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const LevelSpan span = levelSpan(radius, top);
    struct Share {
        core::Interval values;
        double least; ///< of the weight
        double most;
    };
    std::array<Share, 33> shares{};
    double assigned = 0;
    double magnitude = 0;
    core::Interval hull{kInfinity, -kInfinity};
    double finerAtLow = span.first > 0 ? bandWeight(span.first - 1, radius.low) : 0.0;
    double finerAtHigh = span.first > 0 ? bandWeight(span.first - 1, radius.high) : 0.0;
    const auto count = static_cast<std::size_t>(span.end - span.first);
    for (std::size_t i = 0; i < count; ++i) {
        const int level = span.first + static_cast<int>(i);
        const double atLow = level < top ? bandWeight(level, radius.low) : 1.0;
        const double atHigh = level < top ? bandWeight(level, radius.high) : 1.0;
        const double most = atLow - finerAtHigh;
        shares[i] = {
            levels[i],
            std::max(0.0, atHigh - finerAtLow),
            level > 0 && level < top ? std::min(most, kMostBetween) : most};
        assigned += shares[i].least;
        hull.low = std::min(hull.low, levels[i].low);
        hull.high = std::max(hull.high, levels[i].high);
        finerAtLow = atLow;
        finerAtHigh = atHigh;
    }
    for (const double end : {hull.low, hull.high})
        if (std::isfinite(end))
            magnitude = std::max(magnitude, std::abs(end));
    // Sums and interpolations in double are rounded, and rounding to float keeps the order.
    const double slack = 1e-12 * magnitude;
    const auto widened = [&](double low, double high) {
        return core::Interval{
            static_cast<double>(static_cast<float>(low - slack)),
            static_cast<double>(static_cast<float>(high + slack))};
    };
    if (!std::isfinite(hull.low) || !std::isfinite(hull.high))
        return widened(hull.low, hull.high);

    // What is left goes to the levels with the greatest values, as far as they can take it.
    const std::span<Share> used(shares.data(), count);
    const auto extreme = [&](auto&& valueOf) {
        std::ranges::sort(
            used, [&](const Share& a, const Share& b) { return valueOf(a) > valueOf(b); });
        double left = 1.0 - assigned;
        double sum = 0;
        for (const Share& share : used) {
            const double more = std::clamp(share.most - share.least, 0.0, std::max(left, 0.0));
            sum += (share.least + more) * valueOf(share);
            left -= more;
        }
        return sum;
    };
    const double high = extreme([](const Share& share) { return share.values.high; });
    const double low = -extreme([](const Share& share) { return -share.values.low; });
    return widened(low, high);
}

} // namespace isofront::volume::detail

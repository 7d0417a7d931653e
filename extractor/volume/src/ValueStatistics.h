#pragma once

#include "isofront/volume/VolumeInfo.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace isofront::volume {

/// Summarises values in two passes over them.
///
/// @param forEach  called twice with a visitor `visit(double value, std::uint64_t times)`; must
/// visit
///                 the same values each time
template <typename ForEach>
ValueSummary summarised(const ForEach& forEach)
{
    ValueSummary summary;
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
    forEach([&](double value, std::uint64_t times) {
        if (!(std::abs(value) <= static_cast<double>(FLT_MAX))) {
            summary.nonFiniteCount += times;
            return;
        }
        summary.finiteCount += times;
        low = std::min(low, value);
        high = std::max(high, value);
    });
    if (summary.finiteCount == 0)
        return summary;
    summary.low = low;
    summary.high = high;

    constexpr std::size_t kLastBin = ValueSummary::kBins - 1;
    const double binsPerUnit = high > low ? double{ValueSummary::kBins} / (high - low) : 0.0;
    const bool isSpread = std::isfinite(binsPerUnit); // a range of a few denormals is not
    forEach([&](double value, std::uint64_t times) {
        if (!(std::abs(value) <= static_cast<double>(FLT_MAX)))
            return;
        const double position = isSpread ? (value - low) * binsPerUnit : 0.0;
        summary.histogram[std::min(static_cast<std::size_t>(position), kLastBin)] += times;
    });
    return summary;
}

/// The value that best separates a histogram into two classes, by the variance between them; the
/// middle of the best ones where several are equally good (an empty gap between the classes).
///
/// Source: Otsu, "A Threshold Selection Method from Gray-Level Histograms", 1979.
double otsuThreshold(const ValueSummary& summary);

} // namespace isofront::volume

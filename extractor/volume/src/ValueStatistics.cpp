#include "ValueStatistics.h"

namespace isofront::volume {

double otsuThreshold(const ValueSummary& summary)
{
    const auto bins = static_cast<double>(ValueSummary::kBins);
    double totalSum = 0;
    for (std::size_t bin = 0; bin < ValueSummary::kBins; ++bin)
        totalSum += static_cast<double>(bin) * static_cast<double>(summary.histogram[bin]);

    const auto total = static_cast<double>(summary.finiteCount);
    double below = 0;
    double belowSum = 0;
    double best = 0;
    double firstBest = bins / 2; // the middle of the range where nothing separates
    double lastBest = bins / 2;
    for (std::size_t bin = 0; bin + 1 < ValueSummary::kBins; ++bin) {
        below += static_cast<double>(summary.histogram[bin]);
        belowSum += static_cast<double>(bin) * static_cast<double>(summary.histogram[bin]);
        const double above = total - below;
        if (below == 0 || above == 0)
            continue;
        const double distance = belowSum / below - (totalSum - belowSum) / above;
        const double between = below * above * distance * distance;
        if (between < best)
            continue;
        lastBest = static_cast<double>(bin + 1);
        if (between > best) {
            firstBest = lastBest;
            best = between;
        }
    }
    return summary.low + (summary.high - summary.low) * (0.5 * (firstBest + lastBest) / bins);
}

} // namespace isofront::volume

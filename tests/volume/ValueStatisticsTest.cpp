#include "ValueStatistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace isofront::volume {
namespace {

ValueSummary summaryOf(const std::vector<double>& values)
{
    return summarised([&](auto&& visit) {
        for (const double value : values)
            visit(value, 1);
    });
}

TEST(ValueStatistics, countsEveryFiniteValueInOneBin)
{
    std::mt19937 random(1);
    std::normal_distribution<double> normal(5.0, 3.0);
    std::vector<double> values(10'000);
    for (double& value : values)
        value = normal(random);
    values[17] = NAN;
    values[18] = -INFINITY;
    values[19] = 1e300;
    const ValueSummary summary = summaryOf(values);
    EXPECT_EQ(summary.nonFiniteCount, 3U);
    EXPECT_EQ(summary.finiteCount, values.size() - 3);
    EXPECT_EQ(
        std::accumulate(summary.histogram.begin(), summary.histogram.end(), std::uint64_t{0}),
        summary.finiteCount);
    for (std::size_t bin = 0; bin < ValueSummary::kBins; ++bin) {
        const double width = (summary.high - summary.low) / double{ValueSummary::kBins};
        const double low = summary.low + width * static_cast<double>(bin);
        const auto inside = std::count_if(values.begin(), values.end(), [&](double value) {
            return value >= low + 1e-9 && value < low + width - 1e-9;
        });
        EXPECT_GE(summary.histogram[bin], static_cast<std::uint64_t>(inside));
    }
}

TEST(ValueStatistics, isDefinedForConstantEmptyAndExtremeValues)
{
    EXPECT_EQ(summaryOf({}).finiteCount, 0U);
    const ValueSummary constant = summaryOf({4, 4, 4});
    EXPECT_EQ(constant.histogram[0], 3U);
    EXPECT_EQ(otsuThreshold(constant), 4);
    const double denormal = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(summaryOf({0, denormal}).histogram[0], 2U);
    const double most = double{std::numeric_limits<float>::max()};
    const ValueSummary wide = summaryOf({-most, 0, most});
    EXPECT_EQ(wide.histogram.front(), 1U);
    EXPECT_EQ(wide.histogram.back(), 1U);
}

TEST(ValueStatistics, separatesTwoClassesInTheMiddleOfTheGapBetweenThem)
{
    std::vector<double> values(900, 0.0);
    values.insert(values.end(), 100, 256.0);
    EXPECT_NEAR(otsuThreshold(summaryOf(values)), 128, 1.0);
    values.insert(values.end(), 50, 250.0);
    values.insert(values.end(), 50, 10.0);
    const double threshold = otsuThreshold(summaryOf(values));
    EXPECT_GT(threshold, 10);
    EXPECT_LT(threshold, 250);
}

TEST(ValueStatistics, findsTheThresholdWithTheLeastVarianceWithinTheClasses)
{
    // The definition of Otsu's threshold by brute force: the variance within is least where the
    // variance between is greatest.
    std::mt19937 random(2);
    std::normal_distribution<double> air(40, 12);
    std::normal_distribution<double> bone(170, 25);
    std::vector<double> values;
    for (int i = 0; i < 3000; ++i)
        values.push_back(
            std::clamp(std::round(i % 3 == 0 ? bone(random) : air(random)), 0.0, 255.0));
    values.push_back(0);
    values.push_back(256); // so that a bin is one unit wide
    const auto within = [&](double threshold) {
        double sum = 0;
        for (const bool isAbove : {false, true}) {
            double mean = 0;
            double count = 0;
            for (const double value : values) {
                if ((value >= threshold) == isAbove) {
                    mean += std::min(value, 255.0);
                    count += 1;
                }
            }
            mean /= count;
            for (const double value : values)
                if ((value >= threshold) == isAbove)
                    sum += (std::min(value, 255.0) - mean) * (std::min(value, 255.0) - mean);
        }
        return sum;
    };
    const double found = otsuThreshold(summaryOf(values));
    double best = std::numeric_limits<double>::infinity();
    for (double threshold = 1; threshold < 255; ++threshold)
        best = std::min(best, within(threshold));
    EXPECT_LE(within(std::round(found)), best * (1 + 1e-9));
}

} // namespace
} // namespace isofront::volume

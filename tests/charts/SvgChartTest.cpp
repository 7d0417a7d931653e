#include "isofront/charts/SvgChart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>

namespace isofront::charts::test {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The points of every polyline of a class, as pixels.
std::vector<std::vector<std::pair<double, double>>>
strokes(const std::string& svg, const std::string& style)
{
    std::vector<std::vector<std::pair<double, double>>> result;
    const std::string start = "<polyline class=\"curve " + style + "\" points=\"";
    for (std::size_t at = svg.find(start); at != std::string::npos; at = svg.find(start, at + 1)) {
        std::istringstream points(
            svg.substr(at + start.size(), svg.find('"', at + start.size()) - at - start.size()));
        result.emplace_back();
        double x = 0;
        double y = 0;
        char comma = 0;
        while (points >> x >> comma >> y)
            result.back().emplace_back(x, y);
    }
    return result;
}

Chart chartOf(const std::vector<double>& values)
{
    Chart chart{"A chart", "x", "left", "", {}, {{"values", "a", values}}};
    for (std::size_t i = 0; i < values.size(); ++i)
        chart.x.push_back(static_cast<double>(i));
    return chart;
}

} // namespace

TEST(RoundTicks, areFewRoundAndWithinTheRange)
{
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-6, 12);
    for (int i = 0; i < 10'000; ++i) {
        const double low = i % 2 == 0 ? 0 : std::pow(10, exponent(random));
        const double high = low + std::pow(10, exponent(random));
        if ((high - low) < 1e-6 * high)
            continue;
        const Ticks ticks = roundTicks(low, high, 5);
        ASSERT_GE(ticks.values.size(), 2U) << low << " to " << high;
        ASSERT_LE(ticks.values.size(), 9U);
        const double digit = ticks.step / std::pow(10, std::floor(std::log10(ticks.step) + 1e-9));
        ASSERT_TRUE(
            std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 || std::abs(digit - 5) < 1e-6)
            << ticks.step;
        for (const double tick : ticks.values) {
            ASSERT_GE(tick, low - 1e-6 * ticks.step);
            ASSERT_LE(tick, high + 1e-6 * ticks.step);
            ASSERT_NEAR(tick / ticks.step, std::round(tick / ticks.step), 1e-6);
        }
    }
}

TEST(RoundTicks, giveOneForARangeThatIsNone)
{
    EXPECT_EQ(roundTicks(3, 3, 5).values, std::vector<double>{3});
    EXPECT_EQ(roundTicks(0, kNan, 5).values.size(), 1U);
}

TEST(TickLabel, hasAsManyDecimalsAsItsStepNeeds)
{
    EXPECT_EQ(tickLabel(0, 0.05), "0");
    EXPECT_EQ(tickLabel(0.05, 0.05), "0.05");
    EXPECT_EQ(tickLabel(0.5, 0.05), "0.50");
    EXPECT_EQ(tickLabel(12, 2), "12");
    EXPECT_EQ(tickLabel(2000, 500), "2000");
    EXPECT_EQ(tickLabel(20'000, 5000), "20 k");
    EXPECT_EQ(tickLabel(1'500'000, 500'000), "1.5 M");
    EXPECT_EQ(tickLabel(3e9, 1e9), "3 G");
}

TEST(SvgChart, putsEachValueWhereItsAxisSays)
{
    const std::string svg = svgOf(chartOf({0, 10, 5}), 400, 300);
    const auto lines = strokes(svg, "a");
    ASSERT_EQ(lines.size(), 1U);
    ASSERT_EQ(lines[0].size(), 3U);
    EXPECT_EQ(lines[0][0], (std::pair{52.0, 260.0})) << "zero, at the left, on the axis";
    EXPECT_EQ(lines[0][1].second, 26) << "the greatest is a round number and so the top";
    EXPECT_EQ(lines[0][2], (std::pair{386.0, 143.0}));
}

TEST(SvgChart, keepsTheOneSpikeAmongManyFrames)
{
    std::vector<double> values(100'000, 1.0);
    values[77'777] = 50;
    const std::string svg = svgOf(chartOf(values), 900, 300);
    const auto lines = strokes(svg, "a");
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_LT(lines[0].size(), 4000U);
    double top = 1e9;
    for (const auto& [x, y] : lines[0])
        top = std::min(top, y);
    EXPECT_EQ(top, 26);
}

TEST(SvgChart, interruptsACurveWhereNothingWasMeasured)
{
    const auto lines = strokes(svgOf(chartOf({1, 2, kNan, kNan, 3, kNan, 4}), 400, 300), "a");
    ASSERT_EQ(lines.size(), 3U);
    EXPECT_EQ(lines[1].size(), 2U) << "a lone point is drawn as a dot";
    EXPECT_TRUE(strokes(svgOf(chartOf({kNan, kNan}), 400, 300), "a").empty());
}

TEST(SvgChart, drawsWithoutDataOrSpread)
{
    for (const std::vector<double>& values :
         {std::vector<double>{}, std::vector<double>{7}, std::vector<double>(20, 0.0)}) {
        const std::string svg = svgOf(chartOf(values), 400, 300);
        EXPECT_EQ(svg.find("nan"), std::string::npos);
        EXPECT_EQ(svg.find("inf"), std::string::npos);
        EXPECT_TRUE(svg.ends_with("</svg>\n"));
    }
}

TEST(SvgChart, showsLargeAndSmallCountsOnALogarithmicAxis)
{
    Chart chart = chartOf({0, 9, 99, 999, 0, 5000});
    chart.isLogarithmic = true;
    const std::string svg = svgOf(chart, 400, 300);
    for (const char* tick : {">0<", ">1<", ">10<", ">100<", ">1000<", ">10 k<"})
        EXPECT_NE(svg.find(tick), std::string::npos) << tick;
    const auto line = strokes(svg, "a").at(0);
    EXPECT_EQ(line.at(0).second, 260);
    // 9, 99 and 999 lie evenly, one power of ten below the other, under a top of 10 k.
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_NEAR(line.at(i).second, 260 - 58.5 * static_cast<double>(i), 0.3);
}

TEST(SvgChart, labelsZeroWithoutASign)
{
    EXPECT_EQ(svgOf(chartOf({0, 1, 2}), 400, 300).find("-0"), std::string::npos);
    EXPECT_EQ(tickLabel(-0.0, 1), "0");
}

TEST(SvgChart, measuresTheRightAxisByItself)
{
    Chart chart = chartOf({1, 2});
    chart.rightLabel = "right";
    chart.series.push_back({"many", "b", {2e6, 1e6}, true});
    const std::string svg = svgOf(chart, 400, 300);
    EXPECT_EQ(strokes(svg, "b").at(0).at(0).second, 26);
    EXPECT_EQ(strokes(svg, "a").at(0).at(1).second, 26);
    EXPECT_NE(svg.find(">2.0 M<"), std::string::npos) << svg;
    EXPECT_LT(svg.find("curve b"), svg.find("curve a")) << "the left curves lie on top";
}

} // namespace isofront::charts::test

#include "isofront/charts/ScatterChart.h"

#include "isofront/charts/Page.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace isofront::charts::test {

namespace {

double attribute(const std::string& element, const std::string& name)
{
    const std::size_t at = element.find(" " + name + "=\"");
    EXPECT_NE(at, std::string::npos) << element;
    return std::stod(element.substr(at + name.size() + 3));
}

/// The centres of a series' marks, without that of the legend [px].
std::vector<std::pair<double, double>> marks(const std::string& svg, const std::string& style)
{
    std::vector<std::pair<double, double>> result;
    const std::string open = "<g class=\"" + style + "\"><polyline";
    const std::size_t begin = svg.find(open);
    const std::size_t end = svg.find("</g>", begin);
    for (std::size_t at = svg.find("<circle", begin); at < end; at = svg.find("<circle", at + 1)) {
        const std::string element = svg.substr(at, svg.find('>', at) - at);
        result.emplace_back(attribute(element, "cx"), attribute(element, "cy"));
    }
    return result;
}

std::size_t count(const std::string& text, const std::string& what)
{
    std::size_t result = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
        ++result;
    return result;
}

} // namespace

TEST(ScatterChart, showsAPowerLawAsAStraightLineAlongItsGuide)
{
    ScatterChart chart{"t", "x", "y", true, true, {{"law", "a", {}}}, {-2}};
    for (const double x : {1.0, 10.0, 100.0, 1000.0})
        chart.series[0].points.emplace_back(x, 5 / (x * x));
    const std::string svg = svgOf(chart, 700, 400);
    const auto points = marks(svg, "a");
    ASSERT_EQ(points.size(), 4U);
    const double slope =
        (points[1].second - points[0].second) / (points[1].first - points[0].first);
    EXPECT_GT(slope, 0) << "down the picture, y grows";
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_NEAR(
            points[i].second - points[i - 1].second,
            slope * (points[i].first - points[i - 1].first),
            0.3);
    const std::size_t at = svg.find("class=\"guide\"");
    const std::string guide = svg.substr(svg.rfind("<line", at), 200);
    EXPECT_NEAR(
        (attribute(guide, "y2") - attribute(guide, "y1")) /
            (attribute(guide, "x2") - attribute(guide, "x1")),
        slope,
        0.01 * std::abs(slope));
}

TEST(ScatterChart, keepsEveryMarkInsideItsPicture)
{
    const double infinity = std::numeric_limits<double>::infinity();
    for (const bool isLogarithmic : {false, true}) {
        ScatterChart chart{"t", "x", "y", isLogarithmic, isLogarithmic, {}, {}};
        for (unsigned i = 0; i < 12; ++i)
            chart.series.push_back(
                {"a series with a long name",
                 curveStyle(i),
                 {{1e-6, 3e9}, {7, 1e-3}, {-1, 4}, {infinity, 2}, {2, std::nan("")}, {2e5, 1}}});
        for (const int width : {360, 700}) {
            const std::string svg = svgOf(chart, width, 500);
            EXPECT_EQ(svg.find("nan"), std::string::npos);
            EXPECT_EQ(svg.find("inf"), std::string::npos);
            // eight styles for twelve series; what can't be shown is left out
            for (const auto& [x, y] : marks(svg, "a")) {
                EXPECT_GE(x, 50);
                EXPECT_LE(x, width);
                EXPECT_GE(y, 0);
                EXPECT_LE(y, 470);
            }
            EXPECT_EQ(marks(svg, "a").size(), isLogarithmic ? 3U : 4U);
        }
    }
}

TEST(ScatterChart, drawsWithoutPointsOrSpread)
{
    for (const bool isLogarithmic : {false, true}) {
        ScatterChart chart{"", "", "", isLogarithmic, isLogarithmic, {}, {-1}};
        EXPECT_EQ(svgOf(chart, 300, 200).find("nan"), std::string::npos);
        chart.series.push_back({"one", "a", {{3, 3}}});
        EXPECT_EQ(svgOf(chart, 300, 200).find("nan"), std::string::npos);
        EXPECT_EQ(marks(svgOf(chart, 300, 200), "a").size(), 1U);
    }
}

TEST(ScatterChart, isAFileOfItsOwnWithEscapedNames)
{
    const ScatterChart chart{"<t>", "a & b", "\"y\"", false, false, {{"<s>", "a", {{1, 1}}}}, {}};
    const std::string svg = svgFileOf(chart, 300, 200);
    EXPECT_TRUE(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
    EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
    EXPECT_EQ(svg.find("<t>"), std::string::npos);
    EXPECT_EQ(svg.find("<s>"), std::string::npos);
    EXPECT_EQ(count(svg, "<svg"), 1U);
    EXPECT_EQ(count(svg, "</svg>"), 1U);
    EXPECT_EQ(count(svg, "<g "), count(svg, "</g>"));
}

} // namespace isofront::charts::test

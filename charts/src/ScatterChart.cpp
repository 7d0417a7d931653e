#include "isofront/charts/ScatterChart.h"

#include "isofront/charts/Page.h"
#include "isofront/charts/SvgChart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>

namespace isofront::charts {

namespace {

std::string formatted(const char* format, double value)
{
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

/// To a tenth of a pixel.
std::string coordinate(double value)
{
    return formatted("%.1f", value);
}

struct Axis {
    bool isLogarithmic = false;
    double low = 0, high = 1;     // of the value or of its logarithm
    double atLow = 0, atHigh = 1; // [px]
    std::vector<std::pair<double, std::string>> ticks;

    [[nodiscard]] bool accepts(double value) const
    {
        return std::isfinite(value) && (!isLogarithmic || value > 0);
    }
    [[nodiscard]] double operator()(double value) const
    {
        const double at = isLogarithmic ? std::log10(value) : value;
        return atLow + (at - low) / (high - low) * (atHigh - atLow);
    }
};

/// 0.001, 0.02, 5, 3 k: a power of ten times 1, 2 or 5.
std::string decadeLabel(double value)
{
    return value >= 1e3 ? tickLabel(value, value) : formatted("%g", value);
}

Axis axisOf(
    const ScatterChart& chart, bool isVertical, double atLow, double atHigh, double pixelsPerTick)
{
    Axis axis;
    axis.isLogarithmic = isVertical ? chart.isLogarithmicY : chart.isLogarithmicX;
    axis.atLow = atLow;
    axis.atHigh = atHigh;
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (const ScatterSeries& series : chart.series)
        for (const auto& [x, y] : series.points) {
            const double value = isVertical ? y : x;
            if (axis.accepts(value)) {
                least = std::min(least, value);
                most = std::max(most, value);
            }
        }
    if (least > most)
        least = most = 1;
    const int wanted = std::max(2, static_cast<int>(std::abs(atHigh - atLow) / pixelsPerTick));
    if (axis.isLogarithmic) {
        const double margin = 0.04 * (std::log10(most) - std::log10(least)) + 0.02;
        axis.low = std::log10(least) - margin;
        axis.high = std::log10(most) + margin;
        const bool isNarrow = axis.high - axis.low < 0.4 * wanted;
        for (double power = std::floor(axis.low); power <= axis.high; ++power)
            for (const double digit : {1.0, 2.0, 5.0}) {
                const double value = digit * std::pow(10.0, power);
                const double at = std::log10(value);
                if (at >= axis.low && at <= axis.high && (digit == 1 || isNarrow))
                    axis.ticks.emplace_back(value, decadeLabel(value));
            }
        return axis;
    }
    axis.low = std::min(0.0, least);
    axis.high = most > axis.low ? most : axis.low + 1;
    const Ticks ticks = roundTicks(axis.low, axis.high, wanted);
    axis.high = std::max(axis.high, ticks.step * std::ceil(axis.high / ticks.step - 1e-9));
    for (const double value : roundTicks(axis.low, axis.high, wanted).values)
        axis.ticks.emplace_back(value, tickLabel(value, ticks.step));
    return axis;
}

std::string textAt(double x, double y, const char* anchor, const std::string& text)
{
    return "<text x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" text-anchor=\"" + anchor +
           "\">" + escaped(text) + "</text>\n";
}

std::string lineAt(double x1, double y1, double x2, double y2, const char* style)
{
    return "<line x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) + "\" x2=\"" +
           coordinate(x2) + "\" y2=\"" + coordinate(y2) + "\" class=\"" + style + "\"/>\n";
}

/// A line of a given slope, cut off where it leaves the frame.
std::string guideOf(const Axis& across, const Axis& up, double slope)
{
    const double midX = 0.5 * (across.low + across.high);
    const double midY = 0.5 * (up.low + up.high);
    double reach = 0.5 * (across.high - across.low);
    if (slope != 0)
        reach = std::min(reach, 0.5 * (up.high - up.low) / std::abs(slope));
    const auto at = [&](double side) {
        return std::pair{
            across(std::pow(10.0, midX + side * reach)),
            up(std::pow(10.0, midY + side * reach * slope))};
    };
    const auto [x1, y1] = at(-1);
    const auto [x2, y2] = at(1);
    return lineAt(x1, y1, x2, y2, "guide") +
           textAt(x2 - 4, y2 - 4, "end", "slope " + formatted("%g", slope));
}

/// How wide a name will be, about [px].
double widthOf(const std::string& name)
{
    return 7.0 * static_cast<double>(name.size()) + 30;
}

} // namespace

std::string svgOf(const ScatterChart& chart, int width, int height)
{
    // the legend's rows first: what they take is lost to the plot
    const double left = 58;
    const double right = width - 14.0;
    double legendX = left;
    double legendY = 34;
    std::string legend;
    for (const ScatterSeries& series : chart.series) {
        if (legendX > left && legendX + widthOf(series.name) > right) {
            legendX = left;
            legendY += 17;
        }
        legend += "<g class=\"" + escaped(series.style) + "\"><circle class=\"mark\" cx=\"" +
                  coordinate(legendX + 5) + "\" cy=\"" + coordinate(legendY - 4) +
                  "\" r=\"4.5\"/></g>" + textAt(legendX + 14, legendY, "start", series.name);
        legendX += widthOf(series.name);
    }
    const double top = (chart.series.empty() ? 26 : legendY) + 14;
    const double bottom = height - 40.0;
    const Axis across = axisOf(chart, false, left, right, 80);
    const Axis up = axisOf(chart, true, bottom, top, 40);

    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
                      std::to_string(width) + " " + std::to_string(height) + "\" width=\"" +
                      std::to_string(width) + "\" height=\"" + std::to_string(height) +
                      "\" role=\"img\" aria-label=\"" + escaped(chart.title) + "\">\n";
    for (const auto& [value, label] : up.ticks)
        svg += lineAt(left, up(value), right, up(value), "grid") +
               textAt(left - 7, up(value) + 4, "end", label);
    for (const auto& [value, label] : across.ticks)
        svg += lineAt(across(value), top, across(value), bottom, "grid") +
               textAt(across(value), bottom + 17, "middle", label);
    svg += lineAt(left, bottom, right, bottom, "axis") + lineAt(left, top, left, bottom, "axis") +
           textAt((left + right) / 2, height - 6.0, "middle", chart.xLabel) +
           textAt(8, 14, "start", chart.yLabel) + legend;
    if (chart.isLogarithmicX && chart.isLogarithmicY)
        for (const double slope : chart.guides)
            svg += guideOf(across, up, slope);
    for (const ScatterSeries& series : chart.series) {
        std::string line;
        std::string marks;
        for (const auto& [x, y] : series.points) {
            if (!across.accepts(x) || !up.accepts(y))
                continue;
            line += coordinate(across(x)) + "," + coordinate(up(y)) + " ";
            marks += "<circle class=\"mark\" cx=\"" + coordinate(across(x)) + "\" cy=\"" +
                     coordinate(up(y)) + "\" r=\"4\"/>";
        }
        svg += "<g class=\"" + escaped(series.style) + "\"><polyline class=\"curve\" points=\"" +
               line + "\"/>" + marks + "</g>\n";
    }
    return svg + "</svg>\n";
}

std::string svgFileOf(const ScatterChart& chart, int width, int height)
{
    std::string svg = svgOf(chart, width, height);
    const std::size_t begin = svg.find('\n') + 1;
    svg.insert(
        begin,
        "<style>" + chartStyle() +
            "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"var(--card)\"/>\n");
    return svg;
}

} // namespace isofront::charts

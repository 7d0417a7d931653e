#include "isofront/charts/SvgChart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

namespace isofront::charts {

namespace {

/// A number as SVG coordinates take it, to a tenth of a pixel.
std::string coordinate(double value)
{
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), "%.1f", value);
    return text.data();
}

struct Scale {
    double low = 0, high = 1;     // data
    double atLow = 0, atHigh = 1; // [px]
    bool isLogarithmic = false;

    [[nodiscard]] double operator()(double value) const
    {
        const double share = isLogarithmic ? std::log10(1 + value) / std::log10(1 + high)
                                           : (value - low) / (high - low);
        return atLow + share * (atHigh - atLow);
    }
};

struct Axis {
    Ticks ticks;
    Scale scale;
};

/// From zero to the round number above the greatest value.
Axis valueAxis(const Chart& chart, bool onRight, double bottom, double top, int wanted)
{
    double greatest = 0;
    for (const ChartSeries& series : chart.series)
        if (series.onRight == onRight)
            for (const double value : series.values)
                if (std::isfinite(value))
                    greatest = std::max(greatest, value);
    if (greatest <= 0)
        greatest = 1;
    if (chart.isLogarithmic && !onRight) {
        Ticks powers{1, {0}};
        for (double power = 1; powers.values.back() < greatest; power *= 10)
            powers.values.push_back(power);
        const double high = powers.values.back();
        return {std::move(powers), {0, high, bottom, top, true}};
    }
    const double step = roundTicks(0, greatest, wanted).step;
    const double high = step * std::ceil(greatest / step - 1e-9);
    return {roundTicks(0, high, wanted), {0, high, bottom, top, false}};
}

using Point = std::pair<double, double>; // [px]

/// The unbroken parts of a curve, thinned to the least and the greatest value of each column.
std::vector<std::vector<Point>>
strokesOf(const Chart& chart, const ChartSeries& series, const Scale& across, const Scale& up)
{
    std::vector<std::vector<Point>> strokes;
    const std::size_t count = std::min(chart.x.size(), series.values.size());
    const double columns = 2 * std::abs(across.atHigh - across.atLow);
    const std::size_t bucket = std::max<std::size_t>(
        1, static_cast<std::size_t>(std::ceil(2 * static_cast<double>(count) / columns)));
    bool isBroken = true;
    const auto add = [&](std::size_t i) {
        if (isBroken)
            strokes.emplace_back();
        isBroken = false;
        strokes.back().emplace_back(across(chart.x[i]), up(series.values[i]));
    };
    for (std::size_t first = 0; first < count; first += bucket) {
        const std::size_t end = std::min(count, first + bucket);
        std::size_t least = end;
        std::size_t greatest = end;
        for (std::size_t i = first; i < end; ++i) {
            if (!std::isfinite(series.values[i]) || !std::isfinite(chart.x[i]))
                continue;
            if (least == end || series.values[i] < series.values[least])
                least = i;
            if (greatest == end || series.values[i] > series.values[greatest])
                greatest = i;
        }
        if (least == end) {
            isBroken = true;
            continue;
        }
        add(std::min(least, greatest));
        if (least != greatest)
            add(std::max(least, greatest));
    }
    return strokes;
}

std::string
textAt(double x, double y, const char* anchor, const char* style, const std::string& text)
{
    return "<text x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" text-anchor=\"" + anchor +
           "\" class=\"" + style + "\">" + escaped(text) + "</text>";
}

std::string lineAt(double x1, double y1, double x2, double y2, const char* style)
{
    return "<line x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) + "\" x2=\"" +
           coordinate(x2) + "\" y2=\"" + coordinate(y2) + "\" class=\"" + style + "\"/>";
}

} // namespace

Ticks roundTicks(double low, double high, int wanted)
{
    Ticks ticks;
    if (!(std::isfinite(low) && std::isfinite(high) && low < high))
        return {1, {low}};
    const double rough = (high - low) / std::max(1, wanted);
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double ratio = rough / power;
    ticks.step = power * (ratio < 1.5 ? 1 : ratio < 3.5 ? 2 : ratio < 7.5 ? 5 : 10);
    // Counted in whole steps, so that no tick is off by what sums of steps lose; a tick that misses
    // an end by rounding alone belongs to it.
    const double slack = 1e-9;
    for (double i = std::ceil(low / ticks.step - slack); i <= high / ticks.step + slack; ++i)
        ticks.values.push_back(i * ticks.step + 0.0); // no negative zero
    return ticks;
}

std::string tickLabel(double value, double step)
{
    const double size = std::max(std::abs(value), step);
    double unit = 1;
    const char* suffix = "";
    for (const auto& [threshold, name] :
         {std::pair{1e9, " G"}, std::pair{1e6, " M"}, std::pair{1e3, " k"}})
        if (size >= 10 * threshold || (size >= threshold && threshold >= 1e6)) {
            unit = threshold;
            suffix = name;
            break;
        }
    if (value == 0)
        suffix = "";
    const int decimals =
        std::clamp(static_cast<int>(std::ceil(-std::log10(step / unit) - 1e-9)), 0, 9);
    std::array<char, 64> text{};
    (void)std::snprintf(
        text.data(), text.size(), "%.*f%s", value == 0 ? 0 : decimals, value / unit + 0.0, suffix);
    return text.data();
}

std::string escaped(const std::string& text)
{
    std::string result;
    result.reserve(text.size());
    for (const char c : text)
        switch (c) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '"':
            result += "&quot;";
            break;
        case '\'':
            result += "&#39;";
            break;
        default:
            result += c;
        }
    return result;
}

std::string svgOf(const Chart& chart, int width, int height)
{
    const bool hasRight =
        std::any_of(chart.series.begin(), chart.series.end(), [](const auto& series) {
            return series.onRight;
        });
    const double left = 52;
    const double right = width - (hasRight ? 56.0 : 14.0);
    const double top = 26;
    const double bottom = height - 40.0;
    const int wantedRows = std::max(2, static_cast<int>((bottom - top) / 44));
    const Axis leftAxis = valueAxis(chart, false, bottom, top, wantedRows);
    const Axis rightAxis = valueAxis(chart, true, bottom, top, wantedRows);
    const double first = chart.x.empty() ? 0 : chart.x.front();
    const double last = chart.x.empty() || chart.x.back() <= first ? first + 1 : chart.x.back();
    const Scale across{first, last, left, right, false};

    std::string svg = "<svg viewBox=\"0 0 " + std::to_string(width) + " " + std::to_string(height) +
                      "\" width=\"" + std::to_string(width) + "\" height=\"" +
                      std::to_string(height) + "\" role=\"img\" aria-label=\"" +
                      escaped(chart.title) + "\">\n";
    for (const double tick : leftAxis.ticks.values) {
        const double y = leftAxis.scale(tick);
        svg += lineAt(left, y, right, y, tick == 0 ? "axis" : "grid") +
               textAt(
                   left - 7,
                   y + 4,
                   "end",
                   "tick",
                   tickLabel(tick, leftAxis.scale.isLogarithmic ? tick : leftAxis.ticks.step)) +
               "\n";
    }
    if (hasRight)
        for (const double tick : rightAxis.ticks.values) {
            const double y = rightAxis.scale(tick);
            svg +=
                lineAt(right, y, right + 4, y, "axis") +
                textAt(right + 7, y + 4, "start", "tick", tickLabel(tick, rightAxis.ticks.step)) +
                "\n";
        }
    const Ticks columns =
        roundTicks(first, last, std::max(2, static_cast<int>((right - left) / 90)));
    for (const double tick : columns.values)
        svg += lineAt(across(tick), bottom, across(tick), bottom + 4, "axis") +
               textAt(across(tick), bottom + 17, "middle", "tick", tickLabel(tick, columns.step)) +
               "\n";
    svg += textAt((left + right) / 2, height - 6.0, "middle", "label", chart.xLabel) +
           textAt(left - 44, 13, "start", "label", chart.leftLabel);
    if (hasRight)
        svg += textAt(width - 2.0, 13, "end", "label", chart.rightLabel);
    svg += "\n";

    // What is on the right axis is the background that the left curves are read against.
    for (const bool onRight : {true, false})
        for (const ChartSeries& series : chart.series) {
            if (series.onRight != onRight)
                continue;
            const Scale& up = onRight ? rightAxis.scale : leftAxis.scale;
            for (const auto& stroke : strokesOf(chart, series, across, up)) {
                svg += "<polyline class=\"curve " + escaped(series.style) + "\" points=\"";
                for (const auto& [x, y] : stroke)
                    svg += coordinate(x) + "," + coordinate(y) + " ";
                // A lone point would be invisible.
                if (stroke.size() == 1)
                    svg += coordinate(stroke[0].first + 1) + "," + coordinate(stroke[0].second);
                svg += "\"/>\n";
            }
        }
    return svg + "</svg>\n";
}

} // namespace isofront::charts

#pragma once

#include <span>
#include <string>
#include <vector>

namespace isofront::charts {

/// One curve of a chart.
struct ChartSeries {
    std::string name;
    std::string style; ///< CSS class that gives it its colour
    std::vector<double> values;
    bool onRight = false; ///< measured on the right axis
};

/// Curves over a common x axis; both y axes start at zero.
struct Chart {
    std::string title;
    std::string xLabel;
    std::string leftLabel;
    std::string rightLabel; ///< empty if no series is on the right
    std::vector<double> x;  ///< ascending
    /// Each as long as `x`. What is not finite interrupts the curve.
    std::vector<ChartSeries> series;
    /// The left axis shows log10(1 + value): for counts of which a few are very large.
    bool isLogarithmic = false;
};

/// Where the marks of an axis lie.
struct Ticks {
    double step = 1; ///< 1, 2 or 5 times a power of ten
    std::vector<double> values;
};

/// Round numbers from the first at or above `low` to the last at or below `high`, about `wanted` of
/// them and at least two where `high` is above `low`.
Ticks roundTicks(double low, double high, int wanted);

/// A number with as many decimals as its ticks need, or with k, M, G: "0.05", "12", "1.5 M".
std::string tickLabel(double value, double step);

/// Text as it may stand in HTML and in attributes.
std::string escaped(const std::string& text);

/// The chart as an SVG element of its own coordinate size [px], without legend. Where there are
/// more points than columns, each column keeps its least and greatest, so that no spike is lost.
std::string svgOf(const Chart& chart, int width, int height);

} // namespace isofront::charts

#pragma once

#include <string>
#include <utility>
#include <vector>

namespace isofront::charts {

/// Measured points that belong together, joined by a line in the order given.
struct ScatterSeries {
    std::string name;
    std::string style; ///< see `curveStyle`
    /// What is not finite, or not above zero on a logarithmic axis, is left out.
    std::vector<std::pair<double, double>> points;
};

/// Marks in a plane: how one measured quantity depends on another, with its legend in the picture.
struct ScatterChart {
    std::string title;
    std::string xLabel;
    std::string yLabel;
    bool isLogarithmicX = false;
    bool isLogarithmicY = false;
    std::vector<ScatterSeries> series;
    /// Dashed lines of these slopes through the middle of the marks, where both axes are
    /// logarithmic: what a law of that power looks like.
    std::vector<double> guides;
};

/// The chart as an SVG element of its own coordinate size [px]; its colours are those of the page.
std::string svgOf(const ScatterChart& chart, int width, int height);

/// The same as a whole SVG file with its own colours, light and dark.
std::string svgFileOf(const ScatterChart& chart, int width, int height);

} // namespace isofront::charts

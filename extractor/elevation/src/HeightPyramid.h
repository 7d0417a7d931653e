#pragma once

#include "HeightRange.h"
#include "isofront/elevation/HeightGrid.h"

#include <isofront/core/Box.h>

#include <glm/vec2.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::elevation {

/// A height and how it changes.
struct HeightSlope {
    double height = 0; ///< [m]
    double alongX = 0; ///< [m / m]
    double alongY = 0; ///< [m / m]
};

/// exp(-x^2) for x >= 0, the same bits everywhere: 1 below 1/64, 0 from 3 on and for NaN, never
/// increasing; within 3e-4 of the exponential.
double filterWeight(double x);

/// The Gaussian levels of a grid of heights; see ElevationField for what they are for.
class HeightPyramid {
public:
    /// @param grid  at least 2 x 2; its heights are moved from
    explicit HeightPyramid(HeightGrid grid);

    [[nodiscard]] double height(double x, double y, double radius) const;
    [[nodiscard]] HeightSlope slope(double x, double y, double radius) const;
    /// What holds every height over the box, seen from above, with a radius in the interval.
    /// @param box  not empty
    [[nodiscard]] core::Interval heights(const core::Box& box, core::Interval radius) const;
    /// What holds every unfiltered height.
    [[nodiscard]] core::Interval allHeights() const;
    /// Between posts: the geometric mean of both axes [m].
    [[nodiscard]] double spacing() const { return _spacing; }
    [[nodiscard]] std::size_t levelCount() const { return _levels.size(); }
    [[nodiscard]] const PaddedGrid& level(std::size_t k) const { return _levels[k].grid; }
    [[nodiscard]] std::uint64_t memoryBytes() const;

private:
    struct Level {
        PaddedGrid grid;
        HeightRangeTree ranges;
    };
    /// A point in posts of the finest level, within the grid.
    struct Place {
        double u = 0;
        double v = 0;
    };

    [[nodiscard]] Place placeOf(double x, double y) const;
    /// Calls visit(grid of level k, c_k, 2^-k) for the levels that matter at this radius.
    template <typename Visit>
    void forLevels(double radius, Visit&& visit) const;

    glm::dvec2 _origin{0.0};
    glm::dvec2 _postsPerMetre{1.0};
    glm::dvec2 _lastPost{1.0};
    double _spacing = 1;
    double _cyclesPerMetre = 0.3; ///< of the finest level
    std::vector<Level> _levels;   ///< finest first
};

} // namespace isofront::elevation

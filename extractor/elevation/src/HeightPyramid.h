#pragma once

#include "HeightKernel.h"
#include "HeightRange.h"
#include "isofront/elevation/HeightGrid.h"

#include <isofront/core/Box.h>

#include <glm/vec2.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::elevation {

/// The Gaussian levels of a grid of heights; see ElevationField for what they are for.
class HeightPyramid {
public:
    /// @param grid  at least 2 x 2; its heights are moved from
    explicit HeightPyramid(HeightGrid grid);

    HeightPyramid(const HeightPyramid&) = delete;
    HeightPyramid& operator=(const HeightPyramid&) = delete;

    /// Heights at points of any coordinates and radii.
    void heights(const HeightPoints& points, HeightSlopes& out) const;
    /// The same, and how they change.
    void slopes(const HeightPoints& points, HeightSlopes& out) const;
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
    [[nodiscard]] HeightLevels levels() const;

    glm::dvec2 _origin{0.0};
    glm::dvec2 _postsPerMetre{1.0};
    glm::dvec2 _lastPost{1.0};
    double _spacing = 1;
    double _cyclesPerMetre = 0.3;          ///< of the finest level
    std::vector<Level> _levels;            ///< finest first
    std::vector<const PaddedGrid*> _grids; ///< theirs
};

} // namespace isofront::elevation

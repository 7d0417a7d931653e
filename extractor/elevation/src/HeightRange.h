#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::elevation {

/// Least and greatest of some heights, as floats that were rounded outward.
struct HeightRange {
    float low = 0;
    float high = 0;

    void include(const HeightRange& other)
    {
        low = other.low < low ? other.low : low;
        high = other.high > high ? other.high : high;
    }
};

/// A grid of heights with one more post on all sides, so that splines need no special case at the
/// border. Rows from south to north.
struct PaddedGrid {
    int columns = 0; ///< without the padding
    int rows = 0;
    std::vector<float> posts;

    [[nodiscard]] std::size_t stride() const { return static_cast<std::size_t>(columns) + 2; }
    /// The post one column west and one row south of (column, row).
    [[nodiscard]] const float* cornerOf(int column, int row) const
    {
        return posts.data() + static_cast<std::size_t>(row) * stride() +
               static_cast<std::size_t>(column);
    }
};

/// Bounds of the Catmull-Rom surface over a grid, for boxes of it: level 0 has bricks of 8 x 8
/// patches, every further level those of 2 x 2 bricks. The range of a patch is that of its
/// Bernstein coefficients, whose convex hull holds it.
///
/// Thread: any number of readers.
class HeightRangeTree {
public:
    explicit HeightRangeTree(const PaddedGrid& grid);

    /// What holds the surface over [lowX, highX] x [lowY, highY], in posts, each within the grid.
    [[nodiscard]] HeightRange range(double lowX, double highX, double lowY, double highY) const;
    [[nodiscard]] HeightRange all() const { return _levels.back().bricks.front(); }
    [[nodiscard]] std::uint64_t memoryBytes() const;

private:
    struct Level {
        int columns = 0;
        int rows = 0;
        std::vector<HeightRange> bricks;

        [[nodiscard]] const HeightRange& at(int column, int row) const
        {
            return bricks
                [static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
        }
    };

    int _patchColumns = 1;
    int _patchRows = 1;
    std::vector<Level> _levels; ///< finest first
};

} // namespace isofront::elevation

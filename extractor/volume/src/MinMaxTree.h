#pragma once

#include <isofront/core/Box.h>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

namespace isofront::volume::detail {

/// True where a voxel can stand in arithmetic that ends in float.
template <typename T>
constexpr bool isUsable(T value)
{
    if constexpr (std::is_floating_point_v<T>)
        return value >= T(-FLT_MAX) && value <= T(FLT_MAX); // false for NaN
    else
        return true;
}

/// Least and greatest of what interpolation can make of some voxels.
template <typename T>
struct Extremes {
    T low = std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity()
                                                 : std::numeric_limits<T>::max();
    T high = std::numeric_limits<T>::has_infinity ? -std::numeric_limits<T>::infinity()
                                                  : std::numeric_limits<T>::lowest();

    void include(T value)
    {
        if (isUsable(value)) {
            low = std::min(low, value);
            high = std::max(high, value);
        } else if constexpr (std::is_floating_point_v<T>) {
            // Interpolating between an infinity and anything else can give NaN, which counts as
            // outside; only +infinity can give more than the finite voxels do.
            low = -std::numeric_limits<T>::infinity();
            if (value > 0)
                high = std::numeric_limits<T>::infinity();
        }
    }
    void include(const Extremes& other)
    {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
    /// The same as an interval of samples, which are floats: where voxels don't fit float exactly,
    /// interpolation rounds, and the neighbouring float is included.
    [[nodiscard]] core::Interval samples() const
    {
        if constexpr (sizeof(T) <= 2 || std::is_same_v<T, float>) {
            return {static_cast<double>(low), static_cast<double>(high)};
        } else {
            constexpr float kInfinity = std::numeric_limits<float>::infinity();
            return {
                static_cast<double>(std::nextafter(static_cast<float>(low), -kInfinity)),
                static_cast<double>(std::nextafter(static_cast<float>(high), kInfinity))};
        }
    }
};

/// Extremes of the nodes of a grid over boxes of its cells, of which it has one less than nodes
/// along each axis. Level 0 has those of bricks of 8^3 cells, that is 9^3 nodes with the last ones
/// shared, and every further level those of 2^3 bricks.
///
/// A Grid has the nodes and answers
///     `using Value`, the type of the nodes;
///     `glm::ivec3 size() const`, how many there are, at least 1 along each axis;
///     `const Value* row(int y, int z, std::vector<Value>& scratch) const`, the nodes along x;
///     `Value at(int x, int y, int z) const`.
/// The tree keeps no copy of it: the same grid is passed again with each question.
///
/// Thread: any number of readers.
template <typename Grid>
class MinMaxTree {
public:
    using Value = typename Grid::Value;
    static constexpr int kBrickBits = 3;

    explicit MinMaxTree(const Grid& grid)
    {
        Level finest;
        finest.size = glm::max((grid.size() - 1 + 7) / 8, glm::ivec3(1));
        finest.bricks.resize(countOf(finest.size));
        fillBricks(grid, finest);
        _levels.push_back(std::move(finest));
        while (countOf(_levels.back().size) > 1)
            _levels.push_back(coarsened(_levels.back()));
    }

    [[nodiscard]] const Extremes<Value>& all() const { return _levels.back().bricks.front(); }

    /// Extremes of the nodes of the cells from `first` to `last`, both included and between 0 and
    /// size - 1: the last has the last nodes alone. Of a few more around them where they are many.
    [[nodiscard]] Extremes<Value>
    extremes(const Grid& grid, const glm::ivec3& first, const glm::ivec3& last) const
    {
        const glm::ivec3 cells = last - first + 1;
        if (cells.x <= kMostScanned && cells.y <= kMostScanned && cells.z <= kMostScanned &&
            cells.x * cells.y * cells.z <= kMostScanned)
            return scanned(grid, first, last);

        const glm::ivec3 lastBrick = _levels.front().size - 1;
        glm::ivec3 low = glm::min(first >> kBrickBits, lastBrick);
        glm::ivec3 high = glm::min(last >> kBrickBits, lastBrick);
        std::size_t level = 0;
        const auto isWide = [&](std::size_t axis) { return high[axis] - low[axis] >= kMostBricks; };
        for (; isWide(0) || isWide(1) || isWide(2); ++level) {
            low >>= 1;
            high >>= 1;
        }
        const Level& bricks = _levels[level];
        Extremes<Value> found;
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x)
                    found.include(bricks.at({x, y, z}));
        return found;
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += level.bricks.size() * sizeof(Extremes<Value>);
        return bytes;
    }

private:
    /// A query looks at no more bricks than this along an axis; a larger box uses a coarser level.
    static constexpr int kMostBricks = 4;
    /// So few cells are looked at themselves, which is exact: the parts of a brick that are no
    /// bricks, as halves and quarters of cubes of cells.
    static constexpr int kMostScanned = 256;

    struct Level {
        glm::ivec3 size{0};
        std::vector<Extremes<Value>> bricks; ///< x fastest, then y

        [[nodiscard]] const Extremes<Value>& at(glm::ivec3 brick) const
        {
            return bricks
                [(static_cast<std::size_t>(brick.z) * static_cast<std::size_t>(size.y) +
                  static_cast<std::size_t>(brick.y)) *
                     static_cast<std::size_t>(size.x) +
                 static_cast<std::size_t>(brick.x)];
        }
    };

    static std::size_t countOf(glm::ivec3 size)
    {
        return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
               static_cast<std::size_t>(size.z);
    }

    static Extremes<Value>
    scanned(const Grid& grid, const glm::ivec3& first, const glm::ivec3& last)
    {
        const glm::ivec3 high = glm::min(last + 1, grid.size() - 1);
        Extremes<Value> found;
        for (int z = first.z; z <= high.z; ++z)
            for (int y = first.y; y <= high.y; ++y)
                for (int x = first.x; x <= high.x; ++x)
                    found.include(grid.at(x, y, z));
        return found;
    }

    /// Row after row, so that each is fetched once for all bricks along it.
    static void fillBricks(const Grid& grid, Level& finest)
    {
        const glm::ivec3 size = grid.size();
        std::vector<Value> scratch;
        Extremes<Value>* bricks = finest.bricks.data();
        for (int bz = 0; bz < finest.size.z; ++bz) {
            for (int by = 0; by < finest.size.y; ++by, bricks += finest.size.x) {
                for (int z = 8 * bz; z <= std::min(8 * bz + 8, size.z - 1); ++z) {
                    for (int y = 8 * by; y <= std::min(8 * by + 8, size.y - 1); ++y) {
                        const Value* const row = grid.row(y, z, scratch);
                        for (int bx = 0; bx < finest.size.x; ++bx)
                            for (int x = 8 * bx; x <= std::min(8 * bx + 8, size.x - 1); ++x)
                                bricks[bx].include(row[x]);
                    }
                }
            }
        }
    }

    static Level coarsened(const Level& fine)
    {
        Level coarse;
        coarse.size = (fine.size + 1) / 2;
        coarse.bricks.reserve(countOf(coarse.size));
        for (int z = 0; z < coarse.size.z; ++z) {
            for (int y = 0; y < coarse.size.y; ++y) {
                for (int x = 0; x < coarse.size.x; ++x) {
                    const glm::ivec3 low(2 * x, 2 * y, 2 * z);
                    const glm::ivec3 high = glm::min(low + 1, fine.size - 1);
                    Extremes<Value> found;
                    for (int fz = low.z; fz <= high.z; ++fz)
                        for (int fy = low.y; fy <= high.y; ++fy)
                            for (int fx = low.x; fx <= high.x; ++fx)
                                found.include(fine.at({fx, fy, fz}));
                    coarse.bricks.push_back(found);
                }
            }
        }
        return coarse;
    }

    std::vector<Level> _levels; ///< finest first
};

} // namespace isofront::volume::detail

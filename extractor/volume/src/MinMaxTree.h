#pragma once

#include <isofront/core/Box.h>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
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

/// Bounds of a dense volume: level 0 has the extremes of bricks of 8^3 interpolation cells, that is
/// 9^3 voxels with the last ones shared, and every further level those of 2^3 bricks.
///
/// Thread: any number of readers.
template <typename T>
class MinMaxTree {
public:
    static constexpr int kBrickBits = 3;

    /// @param voxels  x fastest, then y
    MinMaxTree(glm::ivec3 dimensions, const T* voxels) : _dimensions(dimensions)
    {
        Level finest;
        finest.size = glm::max((dimensions - 1 + 7) / 8, glm::ivec3(1));
        finest.bricks.resize(countOf(finest.size));
        std::size_t next = 0;
        for (int z = 0; z < finest.size.z; ++z)
            for (int y = 0; y < finest.size.y; ++y)
                for (int x = 0; x < finest.size.x; ++x)
                    finest.bricks[next++] = extremesOf(glm::ivec3(x, y, z) * 8, voxels);
        _levels.push_back(std::move(finest));
        while (countOf(_levels.back().size) > 1)
            _levels.push_back(coarsened(_levels.back()));
    }

    /// What holds every sample at the points of the box, clamped to the volume.
    [[nodiscard]] core::Interval bounds(const core::Box& box) const
    {
        if (box.isEmpty())
            return _levels.back().bricks.front().samples();
        std::array<int, 3> first{};
        std::array<int, 3> last{};
        std::size_t level = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double limit = _dimensions[axis] - 1;
            const double low = std::clamp(box.low[axis], 0.0, limit);
            const double high = std::clamp(box.high[axis], 0.0, limit);
            // A point on a voxel plane needs that plane only, and so belongs to either cell.
            const int firstCell = static_cast<int>(low);
            const int lastCell = std::max(firstCell, static_cast<int>(std::ceil(high)) - 1);
            const int lastBrick = _levels.front().size[axis] - 1;
            first[axis] = std::min(firstCell >> kBrickBits, lastBrick);
            last[axis] = std::min(lastCell >> kBrickBits, lastBrick);
            while ((last[axis] >> level) - (first[axis] >> level) >= kMostBricks)
                ++level;
        }
        const Level& bricks = _levels[level];
        Extremes<T> found;
        for (int z = first[2] >> level; z <= last[2] >> level; ++z)
            for (int y = first[1] >> level; y <= last[1] >> level; ++y)
                for (int x = first[0] >> level; x <= last[0] >> level; ++x)
                    found.include(bricks.at({x, y, z}));
        return found.samples();
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += level.bricks.size() * sizeof(Extremes<T>);
        return bytes;
    }

private:
    /// A query looks at no more bricks than this along an axis; a larger box uses a coarser level.
    static constexpr int kMostBricks = 4;

    struct Level {
        glm::ivec3 size{0};
        std::vector<Extremes<T>> bricks; ///< x fastest, then y

        [[nodiscard]] const Extremes<T>& at(glm::ivec3 brick) const
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

    [[nodiscard]] Extremes<T> extremesOf(glm::ivec3 low, const T* voxels) const
    {
        const glm::ivec3 high = glm::min(low + 8, _dimensions - 1);
        Extremes<T> found;
        for (int z = low.z; z <= high.z; ++z) {
            for (int y = low.y; y <= high.y; ++y) {
                const T* row = voxels + (std::int64_t{z} * _dimensions.y + y) * _dimensions.x;
                for (int x = low.x; x <= high.x; ++x)
                    found.include(row[x]);
            }
        }
        return found;
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
                    Extremes<T> found;
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

    glm::ivec3 _dimensions;
    std::vector<Level> _levels; ///< finest first
};

} // namespace isofront::volume::detail

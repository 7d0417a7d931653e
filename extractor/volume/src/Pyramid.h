#pragma once

#include "FilterBands.h"
#include "LevelAxis.h"
#include "LevelGrid.h"
#include "MinMaxTree.h"
#include "VoxelGrid.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace isofront::volume::detail {

/// The coarsest level of a volume's pyramid: the first that has no nodes but the volume's corners.
inline int topLevel(const glm::ivec3& voxels)
{
    int top = 0;
    while ((std::int64_t{1} << top) < std::max({voxels.x, voxels.y, voxels.z}) - 1)
        ++top;
    return top;
}

/// Makes a level from the next finer one.
///
/// Rows are filtered along y, then along x, and slices of the result along z, in double; a level is
/// rounded once, when it is stored. Non-finite values are left out along each axis in turn, and the
/// weights of the others scaled up; where none is left the result is NaN.
class LevelFilter {
public:
    /// @param voxels   size of the volume
    /// @param level    to be made, at least 1
    /// @param hasGaps  some values of the finer level may not be finite
    LevelFilter(const glm::ivec3& voxels, int level, bool hasGaps);

    /// @param rowInto  `rowInto(int y, int z, double* out)`, a row of the finer level
    /// @param take     `take(int y, int z, const double* row)`, a row of the level
    template <typename RowInto, typename Take>
    void run(const RowInto& rowInto, const Take& take)
    {
        const auto width = static_cast<std::size_t>(_coarse.x);
        const auto height = static_cast<std::size_t>(_coarse.y);
        std::array<std::vector<double>, 5> slices; // filtered along x and y, by index modulo 5
        std::vector<double> row(width);
        int next = 0;
        for (int z = 0; z < _coarse.z; ++z) {
            const FilterTaps& taps = _taps[2][static_cast<std::size_t>(z)];
            for (; next <= std::min(taps.centre + 2, _fine.z - 1); ++next) {
                std::vector<double>& slice = slices[static_cast<std::size_t>(next % 5)];
                slice.resize(width * height);
                filterSlice([&](int y, double* out) { rowInto(y, next, out); }, slice.data());
            }
            for (std::size_t y = 0; y < height; ++y) {
                mix(
                    taps,
                    _fine.z,
                    [&](int fineZ) {
                        return slices[static_cast<std::size_t>(fineZ % 5)].data() + y * width;
                    },
                    width,
                    row.data());
                take(static_cast<int>(y), z, row.data());
            }
        }
    }

private:
    template <typename RowInto>
    void filterSlice(const RowInto& rowInto, double* out)
    {
        const auto width = static_cast<std::size_t>(_fine.x);
        int next = 0;
        for (int y = 0; y < _coarse.y; ++y) {
            const FilterTaps& taps = _taps[1][static_cast<std::size_t>(y)];
            for (; next <= std::min(taps.centre + 2, _fine.y - 1); ++next)
                rowInto(next, _rows[static_cast<std::size_t>(next % 5)].data());
            mix(
                taps,
                _fine.y,
                [&](int fineY) { return _rows[static_cast<std::size_t>(fineY % 5)].data(); },
                width,
                _mixedRow.data());
            filterRow(_mixedRow.data(), out + y * _coarse.x);
        }
    }

    /// The weighted sum of up to five rows.
    /// @param rowAt  `rowAt(int fine)`, the row of a finer node
    template <typename RowAt>
    void
    mix(const FilterTaps& taps, int fineCount, const RowAt& rowAt, std::size_t width, double* out)
        const
    {
        std::array<const double*, 5> rows{};
        for (int i = 0; i < 5; ++i) // a node that is not there has no weight, any other stands in
            rows[static_cast<std::size_t>(i)] =
                rowAt(std::clamp(taps.centre + i - 2, 0, fineCount - 1));
        mixRows(taps.weight, rows, width, out);
    }

    void mixRows(
        const std::array<double, 5>& weights,
        const std::array<const double*, 5>& rows,
        std::size_t width,
        double* out) const;
    void filterRow(const double* fine, double* out) const;

    glm::ivec3 _fine{0};
    glm::ivec3 _coarse{0};
    bool _hasGaps;
    std::array<std::vector<FilterTaps>, 3> _taps;
    std::array<std::vector<double>, 5> _rows; ///< of the finer level, by index modulo 5
    std::vector<double> _mixedRow;
};

/// The Gaussian levels of a volume from g_1 on.
///
/// Thread: any number of readers.
template <typename T>
class Pyramid {
public:
    using Level = LevelGrid<CodesOf<T>>;

    /// @param extremes  of the voxels; says whether some are not finite
    Pyramid(const VoxelGrid<T>& voxels, const Extremes<T>& extremes)
    {
        const int top = topLevel(voxels.size());
        _levels.reserve(static_cast<std::size_t>(top));
        CodeScale scale;
        bool hasGaps = false;
        if constexpr (std::is_floating_point_v<T>)
            hasGaps = !isUsable(extremes.low) || !isUsable(extremes.high);
        else if constexpr (!Level::kIsPlain)
            scale = CodeScale::over(
                static_cast<double>(extremes.low),
                static_cast<double>(extremes.high),
                CodesOf<T>::kMostCode);
        for (int level = 1; level <= top; ++level) {
            Level made(voxels.size(), level, scale);
            const auto take = [&](int y, int z, const double* row) { made.setRow(y, z, row); };
            LevelFilter filter(voxels.size(), level, hasGaps);
            if (level == 1)
                filter.run([&](int y, int z, double* out) { voxelsInto(voxels, y, z, out); }, take);
            else
                filter.run(
                    [&](int y, int z, double* out) { _levels.back().valuesInto(y, z, out); }, take);
            made.finish();
            _levels.push_back(std::move(made));
        }
    }

    [[nodiscard]] int top() const { return static_cast<int>(_levels.size()); }
    /// @param k  at least 1
    [[nodiscard]] const Level& level(int k) const
    {
        return _levels[static_cast<std::size_t>(k - 1)];
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += level.memoryBytes();
        return bytes;
    }

private:
    static void voxelsInto(const VoxelGrid<T>& voxels, int y, int z, double* out)
    {
        std::vector<T> unused;
        const T* const row = voxels.row(y, z, unused);
        for (int x = 0; x < voxels.size().x; ++x) {
            if constexpr (std::is_floating_point_v<T>)
                out[x] = isUsable(row[x]) ? static_cast<double>(row[x])
                                          : std::numeric_limits<double>::quiet_NaN();
            else
                out[x] = static_cast<double>(row[x]);
        }
    }

    std::vector<Level> _levels;
};

} // namespace isofront::volume::detail

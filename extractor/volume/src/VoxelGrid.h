#pragma once

#include "TrilinearKernel.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace isofront::volume::detail {

/// The voxels of a dense volume, which someone else owns.
template <typename T>
class VoxelGrid {
public:
    using Value = T;
    /// A voxel of weight zero must have no influence; integers need no care for that.
    static constexpr bool kGuarded = std::is_floating_point_v<T>;

    /// @param size    voxels along each axis, at least 1
    /// @param voxels  x fastest, then y
    VoxelGrid(const glm::ivec3& size, const T* voxels) : _size(size), _voxels(voxels)
    {
        for (std::size_t axis = 0; axis < 3; ++axis)
            _axes[axis] = {
                .limit = static_cast<double>(size[axis] - 1), .lastCell = size[axis] - 1};
    }

    [[nodiscard]] const glm::ivec3& size() const { return _size; }

    [[nodiscard]] T at(int x, int y, int z) const { return _voxels[rowIndex(y, z) + x]; }

    const T* row(int y, int z, std::vector<T>& /*scratch*/) const
    {
        return _voxels + rowIndex(y, z);
    }

    /// The last voxel has a cell of its own, of which points only see the low side.
    [[nodiscard]] const std::array<AxisCells, 3>& axes() const { return _axes; }

    void corners(
        const CellPlaces& px,
        const CellPlaces& py,
        const CellPlaces& pz,
        std::size_t count,
        CellCorners& out) const
    {
        const glm::ivec3 last = _size - 1;
        const std::int64_t rowStride = _size.x;
        const std::int64_t sliceStride = rowStride * _size.y;
        for (std::size_t i = 0; i < count; ++i) {
            const int x = px.cell[i];
            const int y = py.cell[i];
            const int z = pz.cell[i];
            // On the last plane of an axis the weight is zero: the step must only stay inside.
            const std::int64_t stepX = x < last.x ? 1 : 0;
            const std::int64_t stepY = y < last.y ? rowStride : 0;
            const std::int64_t stepZ = z < last.z ? sliceStride : 0;
            const T* const near = _voxels + z * sliceStride + y * rowStride + x;
            const T* const far = near + stepZ;
            out[0][i] = static_cast<double>(near[0]);
            out[1][i] = static_cast<double>(near[stepX]);
            out[2][i] = static_cast<double>(near[stepY]);
            out[3][i] = static_cast<double>(near[stepY + stepX]);
            out[4][i] = static_cast<double>(far[0]);
            out[5][i] = static_cast<double>(far[stepX]);
            out[6][i] = static_cast<double>(far[stepY]);
            out[7][i] = static_cast<double>(far[stepY + stepX]);
        }
    }

    /// Interpolated voxels are values.
    static void decode(std::size_t /*count*/, BlockOf<double>& /*values*/) {}

private:
    [[nodiscard]] std::int64_t rowIndex(int y, int z) const
    {
        return (std::int64_t{z} * _size.y + y) * _size.x;
    }

    glm::ivec3 _size;
    const T* _voxels;
    std::array<AxisCells, 3> _axes;
};

} // namespace isofront::volume::detail

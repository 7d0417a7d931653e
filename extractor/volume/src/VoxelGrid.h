#pragma once

#include "Interpolation.h"
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

    /// Trilinear interpolation at points of any coordinates, clamped to the voxels.
    /// @param count  at most kBlock
    /// @param out    float or double, to which each sample is rounded once
    template <typename Out>
    void
    sample(const double* px, const double* py, const double* pz, std::size_t count, Out* out) const
    {
        // First all look-ups, which wait for memory, then the arithmetic, which vectorises.
        std::array<std::array<double, kBlock>, 8> corner; // all that is read is written before
        std::array<double, kBlock> tx;
        std::array<double, kBlock> ty;
        std::array<double, kBlock> tz;

        const glm::dvec3 limit(_size - 1);
        const glm::ivec3 lastIndex = _size - 1;
        const std::int64_t rowStride = _size.x;
        const std::int64_t sliceStride = rowStride * _size.y;

        for (std::size_t i = 0; i < count; ++i) {
            const double x = clampedTo(0.0, limit.x, px[i]);
            const double y = clampedTo(0.0, limit.y, py[i]);
            const double z = clampedTo(0.0, limit.z, pz[i]);
            const int ix = static_cast<int>(x);
            const int iy = static_cast<int>(y);
            const int iz = static_cast<int>(z);
            tx[i] = x - ix;
            ty[i] = y - iy;
            tz[i] = z - iz;
            // On the last plane of an axis the weight is zero: the step must only stay inside.
            const std::int64_t stepX = ix < lastIndex.x ? 1 : 0;
            const std::int64_t stepY = iy < lastIndex.y ? rowStride : 0;
            const std::int64_t stepZ = iz < lastIndex.z ? sliceStride : 0;
            const T* const near = _voxels + iz * sliceStride + iy * rowStride + ix;
            const T* const far = near + stepZ;
            corner[0][i] = static_cast<double>(near[0]);
            corner[1][i] = static_cast<double>(near[stepX]);
            corner[2][i] = static_cast<double>(near[stepY]);
            corner[3][i] = static_cast<double>(near[stepY + stepX]);
            corner[4][i] = static_cast<double>(far[0]);
            corner[5][i] = static_cast<double>(far[stepX]);
            corner[6][i] = static_cast<double>(far[stepY]);
            corner[7][i] = static_cast<double>(far[stepY + stepX]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            const double low = mixed<T>(
                mixed<T>(corner[0][i], corner[1][i], tx[i]),
                mixed<T>(corner[2][i], corner[3][i], tx[i]),
                ty[i]);
            const double high = mixed<T>(
                mixed<T>(corner[4][i], corner[5][i], tx[i]),
                mixed<T>(corner[6][i], corner[7][i], tx[i]),
                ty[i]);
            out[i] = static_cast<Out>(mixed<T>(low, high, tz[i]));
        }
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

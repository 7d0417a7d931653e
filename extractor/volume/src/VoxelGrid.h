#pragma once

#include "TrilinearKernel.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::volume::detail {

/// The voxels of a dense volume, which someone else owns.
template <typename T>
class VoxelGrid {
public:
    using Value = T;

    /// @param size    voxels along each axis, at least 1
    /// @param voxels  x fastest, then y
    VoxelGrid(const glm::ivec3& size, const T* voxels)
        : _size(size), _slice(std::int64_t{size.x} * size.y), _voxels(voxels)
    {
    }

    [[nodiscard]] const glm::ivec3& size() const { return _size; }

    [[nodiscard]] T at(int x, int y, int z) const { return _voxels[rowIndex(y, z) + x]; }

    const T* row(int y, int z, std::vector<T>& /*scratch*/) const
    {
        return _voxels + rowIndex(y, z);
    }

    /// As the kernel sees it. The last voxel has a cell of its own, of which points only see the
    /// low side.
    [[nodiscard]] NodeGrid nodes() const
    {
        NodeGrid nodes;
        nodes.nodes = _voxels;
        nodes.type = nodeTypeOf<T>();
        nodes.size = _size;
        nodes.row = _size.x;
        nodes.slice = _slice;
        for (std::size_t axis = 0; axis < 3; ++axis)
            nodes.axes[axis] = {
                .limit = static_cast<double>(_size[axis] - 1), .lastCell = _size[axis] - 1};
        return nodes;
    }

private:
    [[nodiscard]] std::int64_t rowIndex(int y, int z) const
    {
        return z * _slice + std::int64_t{y} * _size.x;
    }

    glm::ivec3 _size;
    std::int64_t _slice;
    const T* _voxels;
};

} // namespace isofront::volume::detail

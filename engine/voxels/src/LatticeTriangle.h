#pragma once

#include <isofront/voxels/Voxelization.h>

#include <array>
#include <cstdint>

namespace isofront::voxels {

/// Steps of the lattice that corners are rounded to, along a voxel's edge: so fine that it can't be
/// seen, so coarse that all that decides which voxels there are fits into integers.
inline constexpr std::int64_t kSteps = 4096;

/// A point in steps from the lattice's origin: at most 2^28 for kMaxResolution.
using LatticePoint = std::array<std::int64_t, 3>;
using LatticeTriangle = std::array<LatticePoint, 3>;

/// For products of an area and a length.
__extension__ using Wide = __int128;

/// A range of voxels, by their places; `high` is not one of them.
struct VoxelRange {
    std::array<std::int64_t, 3> low{};
    std::array<std::int64_t, 3> high{};
};

/// The rounded quotient toward minus infinity. `divisor` above zero.
template <typename Integer>
constexpr Integer floorDivide(Integer number, Integer divisor)
{
    const Integer quotient = number / divisor;
    return number % divisor < 0 ? quotient - 1 : quotient;
}

/// The voxels that a triangle's box meets, those included that it only touches.
constexpr VoxelRange voxelsOf(const LatticeTriangle& triangle)
{
    VoxelRange range;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t a = triangle[0][axis];
        const std::int64_t b = triangle[1][axis];
        const std::int64_t c = triangle[2][axis];
        const std::int64_t least = a < b ? (a < c ? a : c) : (b < c ? b : c);
        const std::int64_t most = a > b ? (a > c ? a : c) : (b > c ? b : c);
        range.low[axis] = floorDivide(least - 1, kSteps);
        range.high[axis] = floorDivide(most, kSteps) + 1;
    }
    return range;
}

constexpr VoxelRange intersection(const VoxelRange& a, const VoxelRange& b)
{
    VoxelRange both;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        both.low[axis] = a.low[axis] > b.low[axis] ? a.low[axis] : b.low[axis];
        both.high[axis] = a.high[axis] < b.high[axis] ? a.high[axis] : b.high[axis];
    }
    return both;
}

constexpr bool isEmpty(const VoxelRange& range)
{
    return range.low[0] >= range.high[0] || range.low[1] >= range.high[1] ||
           range.low[2] >= range.high[2];
}

/// Twice the vector area; components stay below 2^59 [steps^2].
constexpr std::array<std::int64_t, 3> doubleArea(const LatticeTriangle& t)
{
    const auto difference = [](const LatticePoint& to, const LatticePoint& from) {
        return LatticePoint{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    const LatticePoint u = difference(t[1], t[0]);
    const LatticePoint v = difference(t[2], t[0]);
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

} // namespace isofront::voxels

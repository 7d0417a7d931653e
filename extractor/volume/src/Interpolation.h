#pragma once

#include <type_traits>

namespace isofront::volume::detail {

/// Between a and b, in an order of operations that is part of the contract of samples. A voxel of
/// weight zero has no influence, even if it is not finite; integers need no care for that.
/// @param t  in [0, 1)
/// @tparam T the type of the voxels
template <typename T>
double mixed(double a, double b, double t)
{
    const double between = a + t * (b - a);
    if constexpr (std::is_floating_point_v<T>)
        return t == 0 ? a : between;
    else
        return between;
}

/// Into [low, high]; NaN becomes `low`.
inline double clampedTo(double low, double high, double coordinate)
{
    return coordinate > low ? (coordinate < high ? coordinate : high) : low;
}

} // namespace isofront::volume::detail

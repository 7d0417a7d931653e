#pragma once

#include "LatticeRay.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace isofront::voxels {

__extension__ using Wide = __int128;
using Cube = std::array<std::int64_t, 3>;

/// A ray in whole numbers, moved by so little that it meets no edge and no corner: multiplied by
/// 2^60 and moved by 2^40, 2^20 and 1. For starts and directions of a few bits that is as little as
/// nothing; for long ones, that meet no edges, `kAsItIs`.
struct MovedRay {
    static constexpr Wide kMoved = Wide{1} << 60;
    static constexpr Wide kAsItIs = 1;

    std::array<Wide, 3> start;
    Cube direction;
    Wide unit;

    MovedRay(const Cube& from, const Cube& along, Wide scale) : direction(along), unit(scale)
    {
        for (std::size_t i = 0; i < 3; ++i)
            start[i] = from[i] * scale + (scale > 1 ? Wide{1} << (40 - 20 * i) : 0);
    }
};

/// A moment on a ray: numerator and positive denominator.
struct Moment {
    Wide rise;
    std::int64_t size;

    friend bool operator<(const Moment& a, const Moment& b)
    {
        return a.rise * b.size < b.rise * a.size;
    }
};

struct Crossing {
    Moment enter;
    Moment exit;
    std::size_t axis; ///< of the face that it enters by
};

/// By the definition: where the ray is in a cube, from the start of time on.
inline std::optional<Crossing> crossing(const MovedRay& ray, const Cube& low, std::int64_t edge)
{
    Crossing result{{-(Wide{1} << 90), 1}, {Wide{1} << 90, 1}, LatticeRay::kNoAxis};
    for (std::size_t i = 0; i < 3; ++i) {
        const Wide below = low[i] * ray.unit - ray.start[i];
        const Wide above = (low[i] + edge) * ray.unit - ray.start[i];
        if (ray.direction[i] == 0) {
            if (below > 0 || above <= 0)
                return std::nullopt;
            continue;
        }
        const bool up = ray.direction[i] > 0;
        const std::int64_t size = std::abs(ray.direction[i]);
        const Moment enter{up ? below : -above, size};
        const Moment exit{up ? above : -below, size};
        if (result.enter < enter) {
            result.enter = enter;
            result.axis = i;
        }
        if (exit < result.exit)
            result.exit = exit;
    }
    if (!(result.enter < result.exit) || result.exit.rise <= 0)
        return std::nullopt;
    if (result.enter.rise <= 0) { // it starts inside
        result.enter = {0, 1};
        result.axis = LatticeRay::kNoAxis;
    }
    return result;
}

} // namespace isofront::voxels

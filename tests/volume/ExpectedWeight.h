#pragma once

#include <algorithm>
#include <cmath>

namespace isofront::volume {

/// exp(-(f_k r)^2), stretched, by the C library: the weight of a band at a filter radius.
inline double expectedWeight(int band, double radius)
{
    const double x = 0.3 * std::exp2(-band) * radius;
    return std::clamp((std::exp(-x * x) - 1.0 / 64.0) / (62.0 / 64.0), 0.0, 1.0);
}

} // namespace isofront::volume

#include "LevelAxis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isofront::volume::detail {

LevelAxis::LevelAxis(int voxels, int level) : scale(std::ldexp(1.0, -level))
{
    const std::int64_t last = voxels - 1;
    const std::int64_t step = std::int64_t{1} << level;
    const std::int64_t intervals = (last + step - 1) / step;
    nodes = static_cast<int>(intervals) + 1;
    if (intervals > 0)
        lastRatio = static_cast<double>(step) / static_cast<double>(last - (intervals - 1) * step);
}

std::int64_t voxelOfNode(int voxels, int level, int node)
{
    return std::min(std::int64_t{node} << level, std::int64_t{voxels} - 1);
}

FilterTaps filterTaps(int voxels, int level, int node)
{
    constexpr std::array<double, 5> kBinomial = {
        1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0};
    const std::int64_t last = voxels - 1;
    const std::int64_t step = std::int64_t{1} << (level - 1);
    const std::int64_t position = voxelOfNode(voxels, level, node);
    const int lastFiner = LevelAxis(voxels, level - 1).nodes - 1;

    FilterTaps taps;
    taps.centre = position == last ? lastFiner : 2 * node;
    const auto weightOf = [&](int finer) -> double& {
        return taps.weight[static_cast<std::size_t>(finer - taps.centre + 2)];
    };
    if (position == 0 || position == last) {
        weightOf(taps.centre) = 1.0;
        return taps;
    }
    for (int i = 0; i < 5; ++i) {
        const double weight = kBinomial[static_cast<std::size_t>(i)];
        const std::int64_t tap = position + (i - 2) * step;
        if (tap <= last) {
            weightOf(taps.centre + i - 2) += weight;
            continue;
        }
        // f(last + d) = 2 f(last) - f(last - d), the latter between two nodes
        weightOf(lastFiner) += 2.0 * weight;
        const std::int64_t mirrored = 2 * last - tap;
        const int below = static_cast<int>(mirrored / step);
        const std::int64_t low = voxelOfNode(voxels, level - 1, below);
        if (mirrored == low) {
            weightOf(below) -= weight;
            continue;
        }
        const std::int64_t high = voxelOfNode(voxels, level - 1, below + 1);
        const double t = static_cast<double>(mirrored - low) / static_cast<double>(high - low);
        weightOf(below) -= weight * (1.0 - t);
        weightOf(below + 1) -= weight * t;
    }
    return taps;
}

} // namespace isofront::volume::detail

#pragma once

#include <array>
#include <cstdint>

namespace isofront::volume::detail {

/// The nodes of one level of a pyramid along one axis of a volume: every 2^level-th voxel, and the
/// last one. So the nodes of a level are among those of the next finer one, no node lies outside
/// the data, and only the last interval may be shorter than the others.
struct LevelAxis {
    int nodes = 1;        ///< at least 1
    double scale = 1;     ///< levels per voxel: 2^-level
    double lastRatio = 1; ///< length of a whole interval by that of the last

    LevelAxis() = default;
    /// @param voxels  along the axis, at least 1
    /// @param level   at most 31
    LevelAxis(int voxels, int level);
};

/// The voxel on which a node of a level lies.
std::int64_t voxelOfNode(int voxels, int level, int node);

/// What a node takes from the nodes `centre - 2` to `centre + 2` of the next finer level. Weights
/// are never below zero and add up to 1; a node that is not there has the weight 0.
struct FilterTaps {
    int centre = 0;
    std::array<double, 5> weight{};
};

/// The binomial filter [1 4 6 4 1] / 16, continued beyond the last voxel by odd reflection: a
/// linear function stays as it is up to the border, and a node on the border keeps its value.
/// @param level  of the node, at least 1
FilterTaps filterTaps(int voxels, int level, int node);

} // namespace isofront::volume::detail

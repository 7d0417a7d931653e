#pragma once

#include <isofront/voxels/Voxel.h>

#include <array>
#include <cstdint>

namespace isofront::voxels {

/// A voxel while it is made: with the weights that its attributes are averaged by, which the stored
/// one doesn't have.
struct WeightedVoxel {
    std::uint32_t place = 0;       ///< as in Voxel
    std::array<float, 3> normal{}; ///< sum of unit normals times areas
    float area = 0;                ///< of surface [voxels of level 0, squared]
    std::array<float, 4> colour{}; ///< sum of colours times areas: linear red, green, blue;
                                   ///< opacity. Red, green and blue are weighted by opacity
    [[nodiscard]] std::uint32_t order() const { return place & 0xffffffU; }
};

} // namespace isofront::voxels

#pragma once

#include <isofront/voxels/Voxel.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// A voxel while it is made: with the weights that its attributes are averaged by, which the stored
/// one doesn't have.
struct WeightedVoxel {
    std::uint32_t place = 0;       ///< as in Voxel; kWall may be set
    std::array<float, 3> normal{}; ///< sum of unit normals times areas
    float area = 0;                ///< of surface [voxels of level 0, squared]

    [[nodiscard]] std::uint32_t order() const { return place & 0xffffffU; }
};

/// The weights of a voxel while surface is added to it.
struct alignas(16) WeightedSurface {
    std::array<float, 3> normal{}; ///< sum of unit normals times areas
    float area = 0;                ///< [voxels of level 0, squared]
};

/// Sum of colours times areas: linear red, green, blue; opacity. Red, green and blue are weighted
/// by opacity.
using WeightedColour = std::array<float, 4>;

/// Marks, in a bit of `place` that the stored form doesn't use, a voxel that only closes a solid
/// where the data end: it keeps what is inside from being outside, and is not stored.
inline constexpr std::uint32_t kWall = 1U << 31U;

/// How a voxel looks from across one of its faces, as sums like a voxel's own.
struct WeightedFace {
    std::array<float, 3> normal{};
    float area = 0;
    WeightedColour colour{};
};

/// The same of a part of the surface.
inline WeightedFace scaled(WeightedFace face, float share)
{
    face.area *= share;
    for (float& component : face.normal)
        component *= share;
    for (float& component : face.colour)
        component *= share;
    return face;
}

/// The faces of a voxel whose surfaces are turned to different sides.
struct WeightedFaces {
    std::uint32_t voxel = 0; ///< index in the list
    std::array<WeightedFace, kFaces> faces{};
};

/// The voxels of a chunk while they are made.
struct VoxelList {
    std::vector<WeightedVoxel> voxels;   ///< in their order
    std::vector<WeightedColour> colours; ///< of each voxel; none where models have none
    std::vector<WeightedFaces> faces;    ///< by voxel; of those that need them

    void clear()
    {
        voxels.clear();
        colours.clear();
        faces.clear();
    }
};

/// Whether a voxel's surfaces are turned so differently that their mean says little: it has less
/// than half the length that it would have if they agreed. That of two sides of a cube has 0.7.
inline bool isMixed(const WeightedVoxel& voxel)
{
    const std::array<float, 3>& n = voxel.normal;
    const float squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    return squared < 0.25F * voxel.area * voxel.area;
}

inline void addColour(WeightedColour& sum, const WeightedColour& part)
{
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] += part[i];
}

/// Adds the normal and area of one to those of another: of surfaces, voxels and faces.
template <typename Sum, typename Part>
void addSurface(Sum& sum, const Part& part)
{
    for (std::size_t i = 0; i < sum.normal.size(); ++i)
        sum.normal[i] += part.normal[i];
    sum.area += part.area;
}

/// Adds all attributes of a face.
inline void addAttributes(WeightedFace& sum, const WeightedFace& part)
{
    addSurface(sum, part);
    addColour(sum.colour, part.colour);
}

} // namespace isofront::voxels

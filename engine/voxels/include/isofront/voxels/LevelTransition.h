#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/Chunk.h>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

// A level of detail changes into the next finer one, and back, without a jump: a weight w goes from
// 0, where a chunk looks like its parent, to 1, where it looks like itself. A parent voxel is eight
// cubes that look like it. Those of its children that there are keep their place, and take on their
// own attributes; the others are redundant: they shrink, towards a sibling that stays.
//
// Source: S. Jablonski and T. Martyn, "Real-time rendering of continuous levels of detail for
// sparse voxel octrees", section 7. Differs: the direction follows from which children there are,
// so nothing is stored in models, and no neighbour is asked.

/// Where a redundant node shrinks to: -1, 0 or 1 along each axis, in 5 bits:
/// `(x + 1) + 3 (y + 1) + 9 (z + 1)`.
using FadeDirection = std::uint8_t;
/// None, of those that stay.
inline constexpr FadeDirection kNoFade = 13;

/// -1, 0 or 1 along each axis.
constexpr std::array<int, 3> fadeStep(FadeDirection direction)
{
    return {direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1};
}

/// The directions of the eight children of a voxel.
/// @param children  a bit for each child that there is, in the order of ChunkKey::child; not 0
/// @return kNoFade for those that there are; for the others where the nearest one is: across a
/// face before across an edge before across the middle, and of several the one that comes first
constexpr std::array<FadeDirection, 8> fadeDirections(std::uint8_t children)
{
    const unsigned present = children;
    std::array<FadeDirection, 8> directions{};
    for (unsigned child = 0; child < 8; ++child) {
        unsigned best = child;
        int bestAway = 4;
        for (unsigned other = 0; other < 8; ++other) {
            const unsigned apart = child ^ other;
            const int away =
                static_cast<int>((apart & 1U) + (apart >> 1U & 1U) + (apart >> 2U & 1U));
            if ((present >> other & 1U) != 0 && away < bestAway) {
                best = other;
                bestAway = away;
            }
        }
        int code = kNoFade;
        int unit = 1;
        for (unsigned axis = 0; axis < 3; ++axis, unit *= 3)
            code +=
                unit * (static_cast<int>(best >> axis & 1U) - static_cast<int>(child >> axis & 1U));
        directions[child] = static_cast<FadeDirection>(code);
    }
    return directions;
}

/// A piece of a voxel on its way between two levels.
struct TransitionBox {
    glm::dvec3 low{0.0};  ///< [child voxels]
    glm::dvec3 high{0.0}; ///< [child voxels]
    std::uint32_t child = 0;
    bool isRedundant = false; ///< looks like the parent; otherwise `blended`
};

/// What is left of a redundant node, from 0 to 1 within its cube along an axis. The side towards
/// which it fades doesn't move.
/// @param step    of its direction along the axis
/// @param weight  0 to 1
constexpr std::array<double, 2> fadeExtent(int step, double weight)
{
    if (step < 0)
        return {0, 1 - weight};
    if (step > 0)
        return {weight, 1};
    return {0.5 * weight, 1 - 0.5 * weight};
}

/// The pieces of a voxel: at weight 0 together the whole cube, at weight 1 the children. What
/// shaders draw is checked against it.
/// @param parent    place of the voxel [parent voxels]
/// @param children  as in fadeDirections
/// @param weight    0 to 1
std::vector<TransitionBox>
transitionBoxes(const std::array<std::uint32_t, 3>& parent, std::uint8_t children, double weight);

/// How a piece looks.
struct BlendedLook {
    glm::dvec3 normal{0, 0, 1}; ///< unit length
    glm::dvec4 colour{0.0};     ///< red, green and blue, linear; opacity
};
/// How a child looks on the way: between its parent's attributes and its own. Opposite normals,
/// half way, give the child's.
BlendedLook blended(const FaceAttributes& parent, const FaceAttributes& child, double weight);

/// What drawing a chunk on its way from its parent needs beside the two.
struct TransitionNodes {
    /// For each voxel of the chunk, and then for each redundant node, the index of its parent among
    /// the voxels of the parent chunk.
    std::vector<std::uint32_t> parents;
    /// By parent, then by child: x, y and z in the chunk, 8 bits each, x lowest; then the
    /// direction, 5 bits. Shows all faces.
    std::vector<std::uint32_t> redundant;

    [[nodiscard]] std::size_t bytes() const
    {
        return (parents.size() + redundant.size()) * sizeof(std::uint32_t);
    }
    friend bool operator==(const TransitionNodes&, const TransitionNodes&) = default;
};

/// @param parent  the chunk of `chunk.key.parent()`
/// @return `badData` if a voxel has no parent there
/// Cost: linear; a millisecond for a large chunk. Thread: any.
core::Result<TransitionNodes> transitionNodes(const Chunk& chunk, const Chunk& parent);

/// The weight of a chunk that is drawn where voxels may be as large as `mostPixels`: 0 when its
/// parent has just become too coarse, 1 when it will soon be too coarse itself. So a chunk is
/// replaced while it looks like what replaces it.
/// @param pixels  edge of the chunk's voxels on screen, at the place that is nearest to the eye
/// @param span    how much of the range from `mostPixels / 2` to `mostPixels` a transition takes,
///                more than 0 to 1
double transitionWeight(double pixels, double mostPixels, double span = 1);

} // namespace isofront::voxels

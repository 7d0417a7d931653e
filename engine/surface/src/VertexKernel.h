#pragma once

#include <isofront/hierarchy/Domain.h>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::surface {

/// Vertices on their way from cells into the world, as structure of arrays, so that many are moved
/// at once. What lies beyond those in use may be anything.
struct VertexBlock {
    static constexpr std::size_t kSize = 64;

    /// Where they are, by axis [grid units].
    std::array<std::array<double, kSize>, 3> grid{};
    /// Their normals as cells store them, the first number in the lower half.
    std::array<std::uint32_t, kSize> normal{};
};

/// Moves vertices into the world, with the best instruction set that the machine has; the same bits
/// with each: `domain.worldFromGrid` of positions, and the unit vector along `normalMatrix` times
/// `fromOctahedral` of normals.
/// @param positions  receives `count` [world]
/// @param normals    receives `count`
void placeInWorld(
    const VertexBlock& block,
    std::size_t count,
    const hierarchy::Domain& domain,
    const glm::dmat3& normalMatrix,
    glm::dvec3* positions,
    glm::vec3* normals);

} // namespace isofront::surface

#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/LargeVector.h>

#include <glm/vec3.hpp>

#include <cstdint>

namespace isofront::surface {

/// One indexed mesh in world space, as it is exported: vertices on the borders of cells are shared.
struct TriangleMesh {
    core::LargeVector<glm::dvec3> positions; ///< [world]
    core::LargeVector<glm::vec3> normals;    ///< unit, pointing outside, one a position
    /// What the field says of each position, a colour or a material; empty unless asked for.
    core::LargeVector<std::uint32_t> attributes;
    /// Three a triangle, counter-clockwise seen from outside.
    core::LargeVector<std::uint32_t> indices;
    core::Box bounds; ///< of the positions [world]; empty if there are none
};

} // namespace isofront::surface

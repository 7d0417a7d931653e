#pragma once

#include "isofront/render/Scene.h"

#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>

#include <glm/vec3.hpp>

#include <array>

namespace isofront::render {

struct GridView;

/// The surroundings of the eye onto which the sun casts shadows: a square along its rays, seen in
/// parallel projection.
struct SunBox {
    bool casts = false;     ///< false: no shadows in this scene
    double halfWidth = 1.0; ///< of the square [world]
    double halfDepth = 1.0; ///< as far towards the sun and away from it things count [world]
    /// Right and down in the shadow map, and towards the sun [world, unit].
    std::array<glm::dvec3, 3> axes{};
    /// The box's centre along the axes, from the eye [world].
    std::array<double, 3> centre{};
    hierarchy::GridPoint eye{0}; ///< the eye that it counts from

    /// The same place in the world, counted from another eye.
    [[nodiscard]] SunBox
    seenFrom(const hierarchy::Domain& domain, const hierarchy::GridPoint& otherEye) const;
    /// True if the other is of the same size and along the same axes, wherever it is.
    [[nodiscard]] bool isAlike(const SunBox& other) const;
    /// True if the box is alike, and covers nearly what the other does.
    [[nodiscard]] bool isNear(const SunBox& other) const;
};

/// The box moves in whole texels, so that shadows stand still while the eye flies.
/// @param texels  along a side of the shadow map
SunBox sunBox(
    const hierarchy::Domain& domain, const hierarchy::View& view, const Scene& scene, int texels);

/// The box as something to cull cells against. Open towards the sun and away from it.
GridView gridView(const hierarchy::Domain& domain, const hierarchy::View& view, const SunBox& box);

} // namespace isofront::render

#pragma once

#include "isofront/render/Scene.h"
#include "shared/frame.h"

#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <array>

namespace isofront::render {

/// A view as the domain's grid sees it.
struct GridView {
    hierarchy::GridPoint eye{0}; ///< nearest grid point
    glm::dmat3 worldFromGrid{1.0};
    /// The sides of the view pyramid, through the eye: a point at difference d from the eye is
    /// inside of all where dot(side, d) >= 0.
    std::array<glm::dvec3, 4> sides{};
};

GridView gridView(const hierarchy::Domain& domain, const hierarchy::View& view);

/// The near plane of a scene that doesn't name one [world].
double defaultNearPlane(const hierarchy::Domain& domain);

/// What the shaders get.
shared::Frame
frameData(const hierarchy::Domain& domain, const hierarchy::View& view, const Scene& scene);

} // namespace isofront::render

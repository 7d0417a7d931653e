#pragma once

#include "SunBox.h"
#include "isofront/render/HandOver.h"
#include "isofront/render/Scene.h"
#include "shared/frame.h"

#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <array>

namespace isofront::render {

/// The directions of a view.
struct Camera {
    glm::dvec3 forward{0.0}, right{0.0}, up{0.0}; ///< orthonormal [world]
    double tangentX = 1, tangentY = 1;            ///< of half the angles of view
};
Camera cameraOf(const hierarchy::View& view);

/// A view as the domain's grid sees it.
struct GridView {
    hierarchy::GridPoint eye{0}; ///< nearest grid point
    glm::dmat3 worldFromGrid{1.0};
    /// The sides of what is seen: a point at difference d from the eye is inside where
    /// dot(side, d) + offset >= 0 for all.
    std::array<glm::dvec3, 4> sides{};
    std::array<double, 4> offsets{};
};

/// The view pyramid.
GridView gridView(const hierarchy::Domain& domain, const hierarchy::View& view);

/// The near plane of a scene that doesn't name one [world].
double defaultNearPlane(const hierarchy::Domain& domain);

/// `Scene::transition`, whatever it is, as a weight in [0, 1].
float shownWeight(const Scene& scene);

/// What the shaders get.
/// @param shadowTexels  along a side of the shadow map
/// @param samples       of a pixel: 1, 4 or 8
/// @param handOver      null where voxels have no place of their own
shared::Frame frameData(
    const hierarchy::Domain& domain,
    const hierarchy::View& view,
    const Scene& scene,
    const SunBox& sunBox,
    int shadowTexels,
    int samples,
    const HandOver* handOver = nullptr);

/// Adds where the former picture's shadow map lies.
/// @param box  alike that of the present one, and seen from the same eye; null for none
void setFormerShadows(shared::Frame& frame, const SunBox* box);

} // namespace isofront::render

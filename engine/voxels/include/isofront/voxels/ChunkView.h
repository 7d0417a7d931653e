#pragma once

#include <isofront/core/Box.h>

#include <glm/vec3.hpp>

#include <array>

namespace isofront::voxels {

/// What chunks are chosen for: an eye, and the space that it sees. Any pinhole camera.
struct ChunkView {
    /// Half of space: where `dot(normal, p - eye) + offset >= 0`. The default is all of it.
    struct Plane {
        glm::dvec3 normal{0.0}; ///< into the view, any length
        double offset = 0;

        friend bool operator==(const Plane&, const Plane&) = default;
    };

    glm::dvec3 eye{0.0}; ///< [world]
    /// What is seen lies on the inner side of all of them.
    std::array<Plane, 6> planes{};
    /// Pixels that a length of 1 covers at distance 1, at the centre of the image. Off the centre
    /// a pinhole camera stretches: multiply by what the corners stretch, 1 / cos^2 of their angle,
    /// if the bound on voxels is to hold there too.
    double pixelsPerUnit = 1;
    /// Smaller distances count as this one, as the near plane's [world], > 0.
    double nearest = 1e-3;

    /// False if a number is NaN, infinite or out of range.
    [[nodiscard]] bool isValid() const;
    /// False only if nothing of the box can be seen, as far as the planes say.
    [[nodiscard]] bool mayShow(const core::Box& box) const;
    /// From the eye to the box's nearest point, at least `nearest` [world].
    [[nodiscard]] double distanceTo(const core::Box& box) const;

    friend bool operator==(const ChunkView&, const ChunkView&) = default;
};

/// The view of a camera, with four sides and a near plane.
/// @param forward  looking direction, any length but zero
/// @param up       not along `forward`
/// @param verticalFieldOfView  whole angle [radians], in (0, pi)
/// @param width, height  of the image [px]
/// @param nearest  distance of the near plane [world]
ChunkView perspectiveView(
    const glm::dvec3& eye,
    const glm::dvec3& forward,
    const glm::dvec3& up,
    double verticalFieldOfView,
    int width,
    int height,
    double nearest);

} // namespace isofront::voxels

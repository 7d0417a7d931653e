#pragma once

#include <glm/vec3.hpp>

namespace isofront::hierarchy {

/// Where somebody looks from, in world space. A pinhole camera.
struct View {
    glm::dvec3 eye{0.0};                             ///< [world]
    glm::dvec3 forward{0.0, 1.0, 0.0};               ///< looking direction, any length but zero
    glm::dvec3 up{0.0, 0.0, 1.0};                    ///< not along `forward`
    double verticalFieldOfView = 1.0471975511965976; ///< whole angle [radians], in (0, pi)
    int width = 1280;                                ///< [px]
    int height = 720;                                ///< [px]

    /// Pixels that a length of 1 covers at distance 1, at the centre of the image.
    [[nodiscard]] double pixelsPerUnit() const;
    /// False if an entry is NaN, infinite or out of range; such a view must be rejected.
    [[nodiscard]] bool isValid() const;
};

} // namespace isofront::hierarchy

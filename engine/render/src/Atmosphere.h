#pragma once

#include <glm/vec3.hpp>

namespace isofront::render {

/// The light of a clear day, and what makes it: the part of the atmosphere that is the same for all
/// pixels. The shaders do the rest (shaders/include/atmosphere.glsl).
struct Daylight {
    glm::dvec3 sunLight{0.0};       ///< from the sun, on a surface that faces it [irradiance]
    glm::dvec3 skyLight{0.0};       ///< from the whole sky, on level ground [irradiance / pi]
    glm::dvec3 groundLight{0.0};    ///< that level ground sends back up [irradiance / pi]
    glm::dvec3 airScattering{0.0};  ///< [1 / m]
    glm::dvec3 hazeScattering{0.0}; ///< [1 / m]
};

/// @param sunSine  of the sun's elevation, in [-1, 1]
/// @param haze     >= 0, 1 for a fine day
///
/// Based on: Hoffman, Preetham, "Rendering Outdoor Light Scattering in Real Time", 2002.
Daylight daylight(double sunSine, double haze);

} // namespace isofront::render

#include "Atmosphere.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isofront::render {

namespace {

using std::numbers::pi;

// As in shaders/include/atmosphere.glsl.
constexpr double kAirThickness = 8400.0;
constexpr double kHazeThickness = 1250.0;
constexpr double kSunIrradiance = 9.0;
constexpr double kGroundAlbedo = 0.22;
// What a clear night leaves, so that a picture without sun is dark but not black.
constexpr double kNightLight = 0.004;

double airMass(double sine)
{
    const double clamped = std::clamp(sine, 0.0, 1.0);
    const double degrees = std::asin(clamped) * 180.0 / pi;
    return 1.0 / (clamped + 0.50572 * std::pow(degrees + 6.07995, -1.6364));
}

/// The sky in one direction, scattered once.
glm::dvec3 skyRadiance(const Daylight& day, double sine, double cosineToSun)
{
    const double airPhase = 3.0 / (16.0 * pi) * (1.0 + cosineToSun * cosineToSun);
    const double g = 0.76;
    const double base = 1.0 + g * g - 2.0 * g * cosineToSun;
    const double hazePhase = (1.0 - g * g) / (4.0 * pi * std::pow(base, 1.5));
    const glm::dvec3 depth =
        (day.airScattering * kAirThickness + day.hazeScattering * kHazeThickness) * airMass(sine);
    return day.sunLight * (day.airScattering * airPhase + day.hazeScattering * hazePhase) /
           (day.airScattering + day.hazeScattering) * (1.0 - glm::exp(-depth));
}

/// Mean over the hemisphere above level ground, weighted by the cosine: irradiance / pi.
glm::dvec3 skyLightOnGround(const Daylight& day, const glm::dvec3& sun)
{
    constexpr int kRings = 8;
    constexpr int kSectors = 16;
    glm::dvec3 sum(0.0);
    for (int ring = 0; ring < kRings; ++ring) {
        // Rings of equal weight: the squared sine is uniform.
        const double sine = std::sqrt((ring + 0.5) / kRings);
        const double cosine = std::sqrt(1.0 - sine * sine);
        for (int sector = 0; sector < kSectors; ++sector) {
            const double angle = 2.0 * pi * (sector + 0.5) / kSectors;
            const glm::dvec3 direction(cosine * std::cos(angle), cosine * std::sin(angle), sine);
            sum += skyRadiance(day, sine, glm::dot(direction, sun));
        }
    }
    return sum / static_cast<double>(kRings * kSectors);
}

} // namespace

Daylight daylight(double sunSine, double haze)
{
    Daylight day;
    // Rayleigh's coefficients of air at sea level for red, green and blue (680, 550, 440 nm).
    day.airScattering = {5.8e-6, 13.5e-6, 33.1e-6};
    day.hazeScattering = glm::dvec3(1.0, 1.0, 1.05) * (1.2e-5 * haze + 1e-8);
    // Most of what haze takes from the sun's rays it scatters onwards, so that mist is bright.
    const double lostToHaze = 1.0 / (1.0 + 0.4 * haze);
    const glm::dvec3 depth =
        (day.airScattering * kAirThickness + day.hazeScattering * (kHazeThickness * lostToHaze)) *
        airMass(sunSine);
    // The sun sets within the six degrees below the horizon in which the sky still glows.
    const double set = glm::smoothstep(-0.10, 0.03, sunSine);
    day.sunLight = kSunIrradiance * set * glm::exp(-depth);

    const double sine = std::clamp(sunSine, -1.0, 1.0);
    const glm::dvec3 sun(std::sqrt(1.0 - sine * sine), 0.0, sine);
    // What is scattered again adds about half, and evens out the colours.
    const glm::dvec3 once = skyLightOnGround(day, sun);
    const double grey = (once.x + once.y + once.z) / 3.0;
    day.skyLight = once * 1.35 + glm::dvec3(0.15 * grey + kNightLight);
    const glm::dvec3 onGround = day.skyLight + day.sunLight * (std::max(sine, 0.0) / pi);
    day.groundLight = kGroundAlbedo * onGround * glm::dvec3(1.05, 1.0, 0.9);
    return day;
}

} // namespace isofront::render

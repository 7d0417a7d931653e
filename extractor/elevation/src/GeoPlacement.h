#pragma once

#include "isofront/elevation/LoadElevation.h"

#include <isofront/core/Result.h>
#include <isofront/raster/TiffFile.h>

#include <glm/vec2.hpp>

#include <optional>
#include <string>
#include <vector>

namespace isofront::elevation {

/// A degree of latitude on the sphere that stands for the earth [m].
inline constexpr double kMetresPerDegree = 111'320;

/// The cosine of an angle in degrees, within [-90, 90], the same bits everywhere.
double cosineOfDegrees(double degrees);

/// Where posts stand and how far from each other.
struct Placement {
    glm::dvec2 spacing{1.0};           ///< [m]
    std::optional<GeoPosition> centre; ///< of the raster
    std::vector<std::string> notes;
};

/// Of a raster whose posts are so many degrees apart, around a place on the earth.
Placement placedByDegrees(glm::dvec2 degrees, GeoPosition centre);

/// What GeoTIFF tags say of a page; nothing if it has none. Fails with badData if they say what
/// can't be followed.
core::Result<std::optional<Placement>> placementOf(const raster::TiffPage& page);

/// "N44W072" at the beginning of a name: latitude and longitude of the south-western corner.
std::optional<GeoPosition> cornerFromName(const std::string& name);

} // namespace isofront::elevation

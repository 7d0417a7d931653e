#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/sources/Source.h>

#include <glm/vec3.hpp>

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

namespace isofront::server {

/// From a point on, without end.
struct WorldRay {
    glm::dvec3 origin{0.0};          ///< [world]
    glm::dvec3 direction{0, 0, 1.0}; ///< of any length above zero [world]
};

struct WorldHit {
    glm::dvec3 point{0.0}; ///< [world]
    double distance = 0;   ///< from the ray's origin [world]
    /// Of length 1, to the empty side; nothing where the field has no gradient.
    std::optional<glm::dvec3> normal;
};

/// Where rays first cross the surface of a source: that of the field itself, unfiltered, within the
/// domain and the data. Ends of the data are no surface.
/// @param isovalue  of the source's own values
/// Errors: interrupted. Thread: any.
core::Result<std::vector<std::optional<WorldHit>>> castRays(
    const sources::Source& source,
    double isovalue,
    std::span<const WorldRay> rays,
    core::Jobs& jobs,
    const std::stop_token& stop);

/// The ray that comes down on a place from above all there is.
WorldRay rayFromAbove(const sources::Source& source, const glm::dvec3& place);

} // namespace isofront::server

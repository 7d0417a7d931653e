#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <optional>
#include <stop_token>

namespace isofront::fields {

/// Points `origin + t * direction` with t in [from, to].
struct FieldRay {
    glm::dvec3 origin{0.0};            ///< [field]
    glm::dvec3 direction{0.0, 0, 1.0}; ///< of any length above zero [field]
    double from = 0;
    double to = 1;

    [[nodiscard]] glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// The part of a ray that lies in a box; nothing if there is none.
std::optional<FieldRay> clipped(const FieldRay& ray, const core::Box& box);

struct FieldRaySettings {
    double isovalue = 0;
    double radius = 0; ///< filter radius of all samples [field]
    /// How closely the field is sampled where its bounds leave open whether there is a surface
    /// [field], > 0. Where the ray crosses the surface twice within one step, both may be missed.
    double step = 1e-3;
    std::stop_token stop = {};
};

/// Where a ray crosses the surface.
struct FieldRayHit {
    double t = 0;
    glm::dvec3 gradient{0.0}; ///< of the field there [field units / field]
};

/// The first place at which a ray changes between solid and empty; NaN counts as empty. It is found
/// as exactly as doubles and the field's values, which are floats, can tell.
///
/// Intervals of the ray that the field's bounds exclude are never sampled; others are halved until
/// they are 16 steps long, and sampled.
/// Source: D. P. Mitchell, "Robust Ray Intersection with Interval Arithmetic", Graphics Interface
/// 1990, section 3. Differs: the field says bounds of values only, not of derivatives, so an
/// interval that can't be excluded is sampled in steps.
///
/// Errors: interrupted. Thread: any.
core::Result<std::optional<FieldRayHit>>
castRay(const Field& field, const FieldRay& ray, const FieldRaySettings& settings);

} // namespace isofront::fields

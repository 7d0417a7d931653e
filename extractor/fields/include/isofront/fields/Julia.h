#pragma once

#include <isofront/fields/Field.h>

#include <glm/vec4.hpp>

#include <memory>

namespace isofront::fields {

struct JuliaSettings {
    /// The constant of q -> q^2 + c, as (real, i, j, k); of length at most 2 (asserted).
    glm::dvec4 c{-0.2, 0.68, 0.0, 0.0};
    /// The slice: the points (x, y, z, slice) of the quaternions (real, i, j, k).
    double slice = 0;
    /// Steps, 1 to 40: more shows finer branches, costs in proportion, and thins the set.
    int iterations = 12;
};

/// A slice through the filled Julia set of q -> q^2 + c in the quaternions.
///
/// Solid are the points of the slice that stay within 2 of the origin for all the steps. The value
/// estimates the distance to that solid's surface from below, by its potential
/// G = log |q_n| / 2^n: (G0 - G) / (2 |G'|), with G0 the potential of |q| = 2 at the last step. It
/// is the same for every n once |q_n| is large, up to |c| / |q_n|^2; with a bailout at 1e8 that is
/// below float, so the value is continuous although each point stops at its own step. It is clamped
/// to [-4, 1/4]. Inside it grows away from the surface, and comes back to zero, never below, at
/// points whose orbit runs into the origin.
///
/// Bounds: the box lies in a ball; squaring takes a ball about q of radius r into one about q^2 of
/// radius 2 |q| r + r^2. Length and derivative are bounded from the balls of all steps. The filter
/// radius is ignored, but sets the step of the gradient (central differences).
///
/// Source: Hart, Sandin, Kauffman, "Ray tracing deterministic 3-D fractals" (1989), for the
/// distance estimate. Differs: the potential is taken relative to G0, which gives the inside a
/// value.
std::shared_ptr<const Field> julia(const JuliaSettings& settings);

} // namespace isofront::fields

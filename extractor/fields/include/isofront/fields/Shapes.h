#pragma once

#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <memory>

namespace isofront::fields {

// Analytic shapes, exact in double until the value is rounded to float. Solid is where the value is
// at or above 0; gradients are analytic, bounds hold the exact hull up to rounding unless said
// otherwise. Shapes are sharp and not filtered: the filter radius is ignored.

/// A ball. The value is the distance to the sphere, positive inside [field].
std::shared_ptr<const Field> sphere(const glm::dvec3& centre, double radius);

/// A torus about an axis along z. The value is the distance, positive inside.
/// @param ring  radius of the circle in the middle of the tube [field]
/// @param tube  radius of the tube [field]
std::shared_ptr<const Field> torus(const glm::dvec3& centre, double ring, double tube);

/// A box. The value is the distance, positive inside.
std::shared_ptr<const Field> solidBox(const core::Box& box);

/// A half space. The value is the distance to the plane, positive on the side that `outside` turns
/// away from.
/// @param outside  normal of the plane, of any length above zero
std::shared_ptr<const Field> plane(const glm::dvec3& point, const glm::dvec3& outside);

/// Schoen's gyroid, one half of space. The value is sin X cos Y + sin Y cos Z + sin Z cos X, with
/// X, Y, Z once around in one period, scaled to a gradient near 1 at the surface. Bounds are Taylor
/// bounds about the box's centre.
/// @param period  [field]
std::shared_ptr<const Field> gyroid(double period);

} // namespace isofront::fields

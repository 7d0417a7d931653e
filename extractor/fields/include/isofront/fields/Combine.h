#pragma once

#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <memory>

namespace isofront::fields {

// Solids made of solids. A gradient is that of the field which decides the value. The default
// gradient step is the finer of the two.

/// Solid where either is: the larger value.
std::shared_ptr<const Field>
unionOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second);

/// Solid where both are: the smaller value.
std::shared_ptr<const Field>
intersectionOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second);

/// Solid where the first is and the second is not: the smaller of the first and the negated second.
std::shared_ptr<const Field>
differenceOf(std::shared_ptr<const Field> first, std::shared_ptr<const Field> second);

/// The field made `scale` times as large about the origin, then moved by `translation`. Values and
/// filter radii are scaled along, so that distances stay distances.
/// @param scale  above 0 (asserted)
std::shared_ptr<const Field>
placed(std::shared_ptr<const Field> field, const glm::dvec3& translation, double scale = 1.0);

/// The field with a colour for every place, as its attribute: 0xBBGGRR, each a coordinate across
/// the box from 0 to 255, clamped outside. Everything else is the field's own.
/// @param box  of positive size along every axis (asserted)
std::shared_ptr<const Field>
colouredByPlace(std::shared_ptr<const Field> field, const core::Box& box);

} // namespace isofront::fields

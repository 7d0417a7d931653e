#pragma once

#include <isofront/core/Affine.h>
#include <isofront/fields/Field.h>

#include <memory>

namespace isofront::fields {

/// How a field lies in another space.
struct Embedding {
    core::Affine place;   ///< from the field's own space; invertible (asserted)
    double isovalue = 0;  ///< of the field, becomes 0
    double sharpness = 0; ///< slope of the border's own value [field units / own unit], >= 0
};

/// The field in another space, as part of what is there: solid is where it is at or above 0, and it
/// has a value everywhere.
///
/// Values are those of the field less the isovalue. Where the field has a data box, the value is
/// the lesser of that and `sharpness` times the distance to the box's nearest side [own units],
/// negative outside: so the border is a wall, in about the place where the data ends. A filter
/// radius is divided by the cube root of the factor by which the map enlarges volumes. Gradients go
/// along with the map; bounds are those of the box around the mapped box, so they are wider where
/// it turns.
std::shared_ptr<const Field>
embedded(std::shared_ptr<const Field> field, const Embedding& embedding);

} // namespace isofront::fields

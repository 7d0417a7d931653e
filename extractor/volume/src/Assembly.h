#pragma once

#include "isofront/volume/LoadVolume.h"

namespace isofront::volume {

/// Sets what follows from the map and the data box: spacing, direction, origin, dimensions, domain.
/// Fails with badData if the map is not finite and invertible.
/// @param dataBox  [index] whole numbers
core::Result<void>
placeVolume(LoadedVolume& volume, const core::Affine& worldFromIndex, const core::Box& dataBox);

/// The error for a volume without any finite value, if it is one.
core::Result<void> checkFinite(const ValueSummary& values);

/// The error for a stop that was asked for, if it was.
core::Result<void> checkStop(const LoadOptions& options);

} // namespace isofront::volume

#pragma once

#include "isofront/elevation/LoadElevation.h"

#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isofront::elevation {

/// What is added to a raster where its posts say nothing: between them. All lengths are in
/// distances of posts, so that a preset suits a raster of any resolution.
struct LandscapePreset {
    std::string name;
    std::string description;
    double relief = 0.02; ///< height of the longest waves of fine relief; each octave has half
    double crags = 0;     ///< strength of crags; from 0.3 on they overhang
    double caves = 0;     ///< radius of tunnels; 0 for none
};

/// "natural" (fine relief alone) and "rugged" (crags, overhangs and caves as well).
const std::vector<LandscapePreset>& landscapePresets();

struct LandscapeSettings {
    std::string preset = "natural";
    std::uint64_t seed = 1;
    double filterStrength = 1; ///< kappa of the added waves, see fields::NoiseSettings
};

/// The raster with procedural detail: as a node graph with the raster as its source. It is filtered
/// wave by wave, so that far away the raster's own pyramid is left. The data box is the raster's.
/// Errors: usage for an unknown preset.
core::Result<std::shared_ptr<const fields::Field>>
landscape(const LoadedElevation& elevation, const LandscapeSettings& settings = {});

} // namespace isofront::elevation

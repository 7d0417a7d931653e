#pragma once

#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>
#include <isofront/fields/GraphJson.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isofront::fields {

/// A kind of terrain. Metres, z up; solid is where the value is at or above 0, and the value is
/// roughly the distance to the surface.
using TerrainPreset = graph::Preset;

/// Those that come with the library: the files in extractor/fields/presets/.
const std::vector<TerrainPreset>& terrainPresets();

struct TerrainSettings {
    /// One of those by name, or the path of one's own, that ends with .json.
    std::string preset = "alpine";
    std::uint64_t seed = 1;
    double filterStrength = 1; ///< kappa, see NoiseSettings
};

/// A preset by name or path. An unknown name is a usage error that lists those there are; see
/// graph::readPreset for files.
core::Result<TerrainPreset>
terrainPreset(const std::string& nameOrPath, const graph::FileLoader& load = {});

/// A terrain by the name or path of its preset.
core::Result<std::shared_ptr<const Field>> makeTerrain(const TerrainSettings& settings);

/// The terrain of a preset.
std::shared_ptr<const Field>
terrain(const TerrainPreset& preset, std::uint64_t seed, double filterStrength);

/// A terrain by the name of a preset that exists (asserted; without assertions null otherwise). For
/// names that a user gives, see makeTerrain.
std::shared_ptr<const Field> terrain(const TerrainSettings& settings);

/// The height of the highest solid point over (x, y), to a fortieth of `step`; the box's floor if
/// there is none. What is thinner than `step` [m] may be missed.
double
surfaceHeight(const Field& field, const core::Box& box, double x, double y, double step = 4.0);

} // namespace isofront::fields

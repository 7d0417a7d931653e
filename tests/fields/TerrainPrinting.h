#pragma once

#include <isofront/fields/Terrain.h>

#include <ostream>

namespace isofront::fields {

/// Presets appear in the names of tests; without this as bytes that change from run to run.
inline void PrintTo(const TerrainPreset& preset, std::ostream* stream)
{
    *stream << preset.name;
}

} // namespace isofront::fields

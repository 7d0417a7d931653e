#pragma once

#include <isofront/fields/GraphJson.h>

#include <ostream>

namespace isofront::fields::graph {

/// Presets appear in the names of tests; without this as bytes that change from run to run.
inline void PrintTo(const Preset& preset, std::ostream* stream)
{
    *stream << preset.name;
}

} // namespace isofront::fields::graph

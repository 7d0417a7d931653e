#pragma once

#include <isofront/fields/GraphJson.h>

#include <cstdint>
#include <stop_token>

namespace isofront::sources {

/// Loads the volumes and elevation rasters that presets name.
/// @param memoryLimit  of all of them together [bytes]
/// Thread: the loader is for one preset, and one thread at a time.
fields::graph::FileLoader graphFileLoader(std::uint64_t memoryLimit, std::stop_token stop);

} // namespace isofront::sources

#pragma once

#include "VdbHeader.h"
#include "isofront/volume/LoadVolume.h"

namespace isofront::volume {

/// Reads one grid of a VDB file through OpenVDB. May throw what OpenVDB throws.
/// @param grids  the index of the file
core::Result<LoadedVolume> readThroughOpenVdb(
    const std::filesystem::path& path,
    const std::vector<VdbGridEntry>& grids,
    const LoadOptions& options);

} // namespace isofront::volume

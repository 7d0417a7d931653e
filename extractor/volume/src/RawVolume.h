#pragma once

#include "DenseVoxels.h"

#include <isofront/core/Result.h>

#include <filesystem>

namespace isofront::volume {

/// Reads a file of bare numbers, whose header is `options.rawLayout`, or else a JSON file beside
/// it: NAME.json or, if that isn't there, the name without its last extension and with .json.
core::Result<DenseVoxels>
readRawVolume(const std::filesystem::path& path, const LoadOptions& options);

} // namespace isofront::volume

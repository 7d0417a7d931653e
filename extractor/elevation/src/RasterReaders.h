#pragma once

#include "GeoPlacement.h"

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace isofront::elevation {

/// A raster as its file has it, before voids are filled.
struct RawElevation {
    int columns = 0;
    int rows = 0;
    raster::SampleType type = raster::SampleType::int16;
    std::vector<float> values; ///< rows from north to south; NaN where the file has no data
    std::optional<Placement> placement;
    std::vector<std::string> notes;
};

// Each reads one format; errors don't name the file.

core::Result<RawElevation>
readHgt(const std::filesystem::path& path, const ElevationOptions& options);
core::Result<RawElevation>
readGeoTiff(const std::filesystem::path& path, const ElevationOptions& options);
core::Result<RawElevation>
readPngHeights(const std::filesystem::path& path, const ElevationOptions& options);

} // namespace isofront::elevation

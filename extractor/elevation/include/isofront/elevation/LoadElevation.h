#pragma once

#include "isofront/elevation/ElevationField.h"

#include <isofront/core/Result.h>
#include <isofront/raster/SampleType.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace isofront::elevation {

enum class ElevationFormat { hgt, geoTiff, png };

/// "SRTM", "GeoTIFF" or "PNG".
std::string_view nameOf(ElevationFormat format);

struct ElevationOptions {
    /// [bytes] A raster whose heights take more is refused before they are read.
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U;
    /// Distance of posts along x and y, instead of what the file says [m].
    std::optional<glm::dvec2> pixelSize = {};
    /// Metres that one unit of the file's values stands for.
    std::optional<double> heightScale = {};
    /// The file's value that means "no data", instead of what the file says.
    std::optional<double> noData = {};
    std::stop_token stop = {}; ///< looked at between the steps of loading
};

/// Where on the earth.
struct GeoPosition {
    double latitude = 0;  ///< north of the equator [degrees]
    double longitude = 0; ///< east of Greenwich [degrees]
};

/// What a raster's file says about itself, and what was made of it.
struct ElevationInfo {
    ElevationFormat format = ElevationFormat::hgt;
    int columns = 0; ///< posts from west to east
    int rows = 0;    ///< posts from north to south
    raster::SampleType sampleType = raster::SampleType::int16;
    glm::dvec2 spacing{1.0};           ///< of posts [m]
    std::optional<GeoPosition> centre; ///< of the raster, if the file says
    double lowest = 0;                 ///< measured height [m]
    double highest = 0;                ///< [m]
    glm::dvec2 summit{0.0};            ///< where the highest post stands, x east, y north [m]
    std::uint64_t voids = 0;           ///< posts without data, filled from those around them
    std::uint64_t memoryBytes = 0;     ///< that the field takes
    std::string orientation;           ///< one sentence: what is solid
    std::vector<std::string> notes;    ///< sentences about choices made for the user
};

/// A raster from a file, as a field in metres: x east, y north, z up from the file's own zero, the
/// middle of the raster at x = y = 0.
struct LoadedElevation {
    std::shared_ptr<const ElevationField> field;
    core::Box dataBox; ///< [m]
    ElevationInfo info;
};

/// True if loadElevation reads files of this name: .hgt, .hgt.gz, .tif, .tiff and .png, in upper or
/// lower case.
bool isElevationName(const std::filesystem::path& path);

/// Reads an elevation raster:
/// - .hgt, plain or gzipped: SRTM tiles of 1201 x 1201 or 3601 x 3601 posts, placed by their name
///   (N44W072); -32768 is a void;
/// - .tif .tiff: the first page of a TIFF with one band of integers or floats, placed by its
/// GeoTIFF
///   tags; GDAL_NODATA and values that are not finite are voids;
/// - .png: grey values; they mean metres unless `heightScale` says otherwise.
///
/// Degrees become metres on a sphere, at the raster's middle latitude: a degree is 111 320 m from
/// south to north and cos(latitude) times that from west to east.
///
/// Voids are filled with the smoothest heights between their borders (the harmonic function), the
/// same on every machine, and counted.
///
/// Errors name the file: inputOutput for what can't be read; usage for an unknown extension, a
/// spacing that is neither in the file nor in the options, and options that make no sense; badData
/// for what is damaged, cut short, in a projection without metres, smaller than 2 x 2 posts, or has
/// no post with data; resourceLimit beyond the memory limit; interrupted after a stop was
/// requested.
///
/// Thread: any.
core::Result<LoadedElevation>
loadElevation(const std::filesystem::path& path, const ElevationOptions& options = {});

} // namespace isofront::elevation

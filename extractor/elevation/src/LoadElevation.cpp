#include "isofront/elevation/LoadElevation.h"

#include "RasterReaders.h"
#include "Voids.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <utility>

namespace isofront::elevation {

namespace {

using core::ErrorCode;
using core::failure;

std::string loweredName(const std::filesystem::path& path)
{
    std::string name = path.filename().string();
    for (char& c : name)
        if (c >= 'A' && c <= 'Z')
            c = static_cast<char>(c - 'A' + 'a');
    return name;
}

std::optional<ElevationFormat> formatOf(const std::filesystem::path& path)
{
    const std::string name = loweredName(path);
    if (name.ends_with(".hgt") || name.ends_with(".hgt.gz"))
        return ElevationFormat::hgt;
    if (name.ends_with(".tif") || name.ends_with(".tiff"))
        return ElevationFormat::geoTiff;
    if (name.ends_with(".png"))
        return ElevationFormat::png;
    return std::nullopt;
}

core::Result<void> checkOptions(const ElevationOptions& options)
{
    const auto isGood = [](double number) { return number > 1e-6 && number < 1e7; };
    if (options.pixelSize && !(isGood(options.pixelSize->x) && isGood(options.pixelSize->y)))
        return failure(
            ErrorCode::usage, "--pixel-size must be between 1e-6 and 1e7 metres on both axes");
    if (options.heightScale &&
        !(std::abs(*options.heightScale) > 1e-9 && std::abs(*options.heightScale) < 1e9))
        return failure(
            ErrorCode::usage,
            "--height-scale must be a number of metres between 1e-9 and 1e9, or its negative");
    return {};
}

core::Result<void> checkStop(const ElevationOptions& options)
{
    if (options.stop.stop_requested())
        return failure(ErrorCode::interrupted, "loading was stopped");
    return {};
}

core::Result<RawElevation>
readRaw(const std::filesystem::path& path, ElevationFormat format, const ElevationOptions& options)
{
    switch (format) {
    case ElevationFormat::hgt:
        return readHgt(path, options);
    case ElevationFormat::geoTiff:
        return readGeoTiff(path, options);
    case ElevationFormat::png:
        break;
    }
    return readPngHeights(path, options);
}

/// How far the ground may reach beyond the posts, with room for splines between them and for
/// detail that is added later [m].
double reachOf(const ElevationInfo& info)
{
    return std::max(
        0.25 * (info.highest - info.lowest), 4 * std::max(info.spacing.x, info.spacing.y));
}

core::Result<LoadedElevation>
load(const std::filesystem::path& path, const ElevationOptions& options)
{
    const auto format = formatOf(path);
    if (!format)
        return failure(
            ErrorCode::usage,
            "the extension is not one of an elevation raster; supported are .hgt, .hgt.gz, .tif, "
            ".tiff and .png");
    if (const auto checked = checkOptions(options); !checked)
        return tl::unexpected(checked.error());
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());
    auto raw = readRaw(path, *format, options);
    if (!raw)
        return tl::unexpected(raw.error());
    if (raw->columns < 2 || raw->rows < 2)
        return failure(
            ErrorCode::badData,
            "it has " + std::to_string(raw->columns) + " x " + std::to_string(raw->rows) +
                " heights; a landscape needs at least 2 x 2");
    if (!raw->placement && !options.pixelSize)
        return failure(
            ErrorCode::usage,
            "the file doesn't say how far apart its heights are; give --pixel-size METRES or "
            "--pixel-size X,Y");

    LoadedElevation loaded;
    ElevationInfo& info = loaded.info;
    info.format = *format;
    info.columns = raw->columns;
    info.rows = raw->rows;
    info.sampleType = raw->type;
    info.notes = std::move(raw->notes);
    if (raw->placement) {
        info.spacing = raw->placement->spacing;
        info.centre = raw->placement->centre;
        info.notes.insert(
            info.notes.end(), raw->placement->notes.begin(), raw->placement->notes.end());
    }
    if (options.pixelSize)
        info.spacing = *options.pixelSize;

    HeightGrid grid;
    grid.columns = info.columns;
    grid.rows = info.rows;
    grid.spacing = info.spacing;
    grid.origin = -0.5 * grid.extent();
    grid.heights.resize(raw->values.size());
    const auto scale = static_cast<float>(options.heightScale.value_or(1.0));
    info.lowest = std::numeric_limits<double>::infinity();
    info.highest = -info.lowest;
    for (int row = 0; row < grid.rows; ++row) {
        for (int column = 0; column < grid.columns; ++column) {
            // the file's first row is the northernmost
            const float height = scale * raw->values[grid.index(column, grid.rows - 1 - row)];
            grid.heights[grid.index(column, row)] = height;
            if (!std::isnan(height)) {
                info.lowest = std::min(info.lowest, double(height));
                if (double(height) > info.highest) {
                    info.highest = double(height);
                    info.summit = grid.origin + grid.spacing * glm::dvec2(column, row);
                }
            }
        }
    }
    raw->values = {};
    if (info.lowest > info.highest)
        return failure(
            ErrorCode::badData, "none of its posts has a height, so there is no landscape");
    constexpr double kFarthest = 1e9; // [m] beyond it splines would lose their digits
    if (info.lowest < -kFarthest || info.highest > kFarthest)
        return failure(
            ErrorCode::badData,
            "its heights reach from " + std::to_string(info.lowest) + " to " +
                std::to_string(info.highest) +
                " m; name the value that means no data with --no-data, or the unit with "
                "--height-scale");
    info.voids = fillVoids(grid);
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());

    loaded.field = std::make_shared<const ElevationField>(std::move(grid), reachOf(info));
    loaded.dataBox = *loaded.field->dataBox();
    info.memoryBytes = loaded.field->memoryBytes();
    info.orientation = "The value is the ground's height minus z: solid is what lies below the "
                       "ground, at or above the isovalue 0.";
    if (info.voids > 0)
        info.notes.push_back(
            std::to_string(info.voids) + " of " +
            std::to_string(std::uint64_t(info.columns) * std::uint64_t(info.rows)) +
            " posts had no data; they were filled smoothly from the posts around them.");
    return loaded;
}

} // namespace

std::string_view nameOf(ElevationFormat format)
{
    switch (format) {
    case ElevationFormat::hgt:
        return "SRTM";
    case ElevationFormat::geoTiff:
        return "GeoTIFF";
    case ElevationFormat::png:
        break;
    }
    return "PNG";
}

bool isElevationName(const std::filesystem::path& path)
{
    return formatOf(path).has_value();
}

core::Result<LoadedElevation>
loadElevation(const std::filesystem::path& path, const ElevationOptions& options)
{
    try {
        return load(path, options).map_error([&](const core::Error& error) {
            return error.within(path.string());
        });
    } catch (const std::bad_alloc&) {
        return failure(
            ErrorCode::resourceLimit,
            path.string() + ": the raster doesn't fit in memory; reduce it");
    } catch (const std::exception& exception) {
        return failure(
            ErrorCode::badData, path.string() + ": the file can't be read: " + exception.what());
    }
}

} // namespace isofront::elevation

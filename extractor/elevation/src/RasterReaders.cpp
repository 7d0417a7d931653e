// Based on: the SRTM user guide (USGS/NASA) for .hgt; GDAL's GDAL_NODATA tag.

#include "RasterReaders.h"

#include <isofront/raster/FileBytes.h>
#include <isofront/raster/PngFile.h>
#include <isofront/raster/TiffFile.h>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>

namespace isofront::elevation {

namespace {

using core::ErrorCode;
using core::failure;

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();
constexpr std::int16_t kSrtmVoid = -32768;

core::Result<void> checkMemory(int columns, int rows, std::uint64_t limit)
{
    const double bytes = double(sizeof(float)) * columns * rows;
    if (bytes > double(limit))
        return failure(
            ErrorCode::resourceLimit,
            std::to_string(columns) + " x " + std::to_string(rows) +
                " heights take more than the memory limit of " + std::to_string(limit) +
                " bytes; raise the limit or reduce the raster");
    return {};
}

/// The file's own "no data" value.
core::Result<std::optional<double>> noDataOf(const raster::TiffPage& page)
{
    const std::string& text = page.geo.noData;
    std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string::npos)
        return std::optional<double>();
    if (text[begin] == '+')
        ++begin;
    const std::size_t end = text.find_last_not_of(' ') + 1;
    double value = 0;
    const auto [stopped, error] = std::from_chars(text.data() + begin, text.data() + end, value);
    if (error != std::errc() || stopped != text.data() + end)
        return failure(
            ErrorCode::badData,
            "its GDAL_NODATA tag holds '" + text + "', which is no number; give --no-data");
    return std::optional(value);
}

template <typename T>
void convertInto(
    const std::vector<std::byte>& bytes, std::optional<double> noData, std::vector<float>& values)
{
    for (std::size_t i = 0; i < values.size(); ++i) {
        T value{};
        std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
        const auto height = static_cast<float>(value);
        // Writers round the tag's number to the samples' type, or don't.
        const bool isVoid =
            noData && (double(value) == *noData || height == static_cast<float>(*noData));
        values[i] = isVoid || !std::isfinite(height) ? kVoid : height;
    }
}

} // namespace

core::Result<RawElevation>
readHgt(const std::filesystem::path& path, const ElevationOptions& options)
{
    constexpr std::uint64_t kMostBytes = std::uint64_t{2} * 3601 * 3601;
    const bool isLimited = options.memoryLimit < kMostBytes;
    const auto bytes = raster::readFileBytes(
        path,
        isLimited ? options.memoryLimit : kMostBytes,
        isLimited ? ErrorCode::resourceLimit : ErrorCode::badData);
    if (!bytes)
        return tl::unexpected(bytes.error());
    RawElevation raw;
    for (const int side : {1201, 3601})
        if (bytes->size() == std::size_t{2} * static_cast<std::size_t>(side * side))
            raw.columns = raw.rows = side;
    if (raw.columns == 0)
        return failure(
            ErrorCode::badData,
            "it holds " + std::to_string(bytes->size()) +
                " bytes; an SRTM tile has 2884802 (1201 x 1201 posts) or 25934402 (3601 x 3601)");
    if (const auto checked = checkMemory(raw.columns, raw.rows, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());

    raw.values.resize(bytes->size() / 2);
    for (std::size_t i = 0; i < raw.values.size(); ++i) {
        const auto high = static_cast<std::uint16_t>((*bytes)[2 * i]);
        const auto low = static_cast<std::uint16_t>((*bytes)[2 * i + 1]);
        const auto value = static_cast<std::int16_t>(high << 8U | low);
        raw.values[i] = value == kSrtmVoid || double(value) == options.noData.value_or(kSrtmVoid)
                            ? kVoid
                            : static_cast<float>(value);
    }
    const double degrees = 1.0 / (raw.columns - 1);
    const std::string name = path.filename().string();
    if (const auto corner = cornerFromName(name)) {
        raw.placement =
            placedByDegrees(glm::dvec2(degrees), {corner->latitude + 0.5, corner->longitude + 0.5});
    } else {
        raw.placement = Placement{glm::dvec2(degrees * kMetresPerDegree), std::nullopt, {}};
        raw.notes.push_back(
            "The name doesn't begin with the tile's corner, as in N44W072.hgt, so the tile is "
            "placed at the equator: from west to east it is too wide.");
    }
    return raw;
}

core::Result<RawElevation>
readGeoTiff(const std::filesystem::path& path, const ElevationOptions& options)
{
    const auto file = raster::TiffFile::open(path, options.memoryLimit);
    if (!file)
        return tl::unexpected(file.error());
    const raster::TiffPage& page = file->pages().front();
    RawElevation raw;
    raw.columns = page.width;
    raw.rows = page.height;
    raw.type = page.type;
    if (const auto checked = checkMemory(raw.columns, raw.rows, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    auto placement = placementOf(page);
    if (!placement && !options.pixelSize)
        return tl::unexpected(placement.error());
    if (placement)
        raw.placement = *placement;
    if (file->pages().size() > 1)
        raw.notes.push_back(
            "The file has " + std::to_string(file->pages().size()) +
            " pages; the first one is the elevation.");

    std::optional<double> noData = options.noData;
    if (!noData) {
        const auto found = noDataOf(page);
        if (!found)
            return tl::unexpected(found.error());
        noData = *found;
    }
    if (!noData && page.type == raster::SampleType::int16) {
        noData = kSrtmVoid;
        raw.notes.push_back("The file doesn't say which value means no data; -32768 is taken.");
    }
    std::vector<std::byte> bytes(page.bytes());
    if (const auto read = file->read(0, bytes); !read)
        return tl::unexpected(read.error());
    raw.values.resize(bytes.size() / raster::bytesOf(page.type));
    raster::dispatched(
        page.type, [&](auto zero) { convertInto<decltype(zero)>(bytes, noData, raw.values); });
    return raw;
}

core::Result<RawElevation>
readPngHeights(const std::filesystem::path& path, const ElevationOptions& options)
{
    auto picture = raster::readGreyPng(path, options.memoryLimit);
    if (!picture)
        return tl::unexpected(picture.error());
    RawElevation raw;
    raw.columns = picture->width;
    raw.rows = picture->height;
    raw.type = picture->bits == 16 ? raster::SampleType::uint16 : raster::SampleType::uint8;
    if (const auto checked = checkMemory(raw.columns, raw.rows, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    raw.values.reserve(picture->values.size());
    for (const std::uint16_t value : picture->values)
        raw.values.push_back(
            options.noData && double(value) == *options.noData ? kVoid : float(value));
    if (!options.heightScale)
        raw.notes.push_back(
            "A PNG doesn't say what its values mean; one is taken for a metre (--height-scale "
            "tells otherwise).");
    if (picture->bits < 16)
        raw.notes.push_back(
            "The picture has only " + std::to_string(picture->bits) +
            " bits a pixel, so slopes have steps.");
    return raw;
}

} // namespace isofront::elevation

// Based on: OGC GeoTIFF 1.1 (19-008r4); the SRTM user guide for names of tiles.

#include "GeoPlacement.h"

#include <cctype>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace isofront::elevation {

namespace {

using core::ErrorCode;
using core::failure;

constexpr std::uint16_t kModelType = 1024;  // 1 projected, 2 geographic
constexpr std::uint16_t kRasterType = 1025; // 1 pixels are areas, 2 they are points
constexpr std::uint16_t kLinearUnits = 3076;
constexpr std::uint16_t kAngularUnits = 2054;
constexpr std::uint16_t kUserDefined = 32767;

/// Metres in the unit of an EPSG code; nothing for units that are not known here.
std::optional<double> metresOfUnit(std::uint16_t code)
{
    switch (code) {
    case 9001:
        return 1.0;
    case 9002: // international foot
        return 0.3048;
    case 9003: // US survey foot
        return 1200.0 / 3937.0;
    case 9036: // kilometre
        return 1000.0;
    default:
        return std::nullopt;
    }
}

std::optional<int> digits(const std::string& text, std::size_t begin, std::size_t count)
{
    int value = 0;
    for (std::size_t i = begin; i < begin + count; ++i) {
        if (i >= text.size() || std::isdigit(static_cast<unsigned char>(text[i])) == 0)
            return std::nullopt;
        value = 10 * value + (text[i] - '0');
    }
    return value;
}

} // namespace

double cosineOfDegrees(double degrees)
{
    // Taylor's series around 0; the last term is below 1e-16 for a quarter of a turn.
    const double angle = degrees * (std::numbers::pi / 180);
    const double square = angle * angle;
    double series = 1;
    for (int k = 22; k >= 2; k -= 2)
        series = 1 - square / (k * (k - 1)) * series;
    return series;
}

Placement placedByDegrees(glm::dvec2 degrees, GeoPosition centre)
{
    Placement placement;
    placement.spacing = {
        degrees.x * kMetresPerDegree * cosineOfDegrees(centre.latitude),
        degrees.y * kMetresPerDegree};
    placement.centre = centre;
    return placement;
}

core::Result<std::optional<Placement>> placementOf(const raster::TiffPage& page)
{
    const raster::GeoTags& tags = page.geo;
    glm::dvec2 scale(0.0);
    glm::dvec2 first(0.0); // where column 0, row 0 lies
    if (tags.pixelScale.size() >= 2 && tags.tiepoints.size() >= 6) {
        scale = {tags.pixelScale[0], tags.pixelScale[1]};
        first = {
            tags.tiepoints[3] - tags.tiepoints[0] * scale.x,
            tags.tiepoints[4] + tags.tiepoints[1] * scale.y};
    } else if (tags.transformation.size() == 16) {
        if (tags.transformation[1] != 0 || tags.transformation[4] != 0)
            return failure(
                ErrorCode::badData,
                "its rows don't run from west to east; warp it to north up (gdalwarp)");
        scale = {tags.transformation[0], -tags.transformation[5]};
        first = {tags.transformation[3], tags.transformation[7]};
    } else {
        return std::optional<Placement>();
    }
    const auto isGood = [](double number, double most) {
        return number > 0 && number <= most; // false for NaN
    };
    if (!isGood(scale.x, 1e7) || !isGood(scale.y, 1e7) || !(std::abs(first.x) < 1e12) ||
        !(std::abs(first.y) < 1e12))
        return failure(
            ErrorCode::badData,
            "its GeoTIFF tags place the pixels " + std::to_string(scale.x) + " x " +
                std::to_string(scale.y) +
                " apart; they must be above 0 with north up: correct the file or give "
                "--pixel-size");

    const auto model = tags.key(kModelType);
    // The tie point names a pixel's outer corner, or its own place.
    const double corner = tags.key(kRasterType).value_or(1) == 2 ? 1.0 : 0.0;
    const glm::dvec2 middle =
        first + scale * glm::dvec2(0.5, -0.5) * (glm::dvec2(page.width, page.height) - corner);
    if (model.value_or(0) == 2) {
        const auto unit = tags.key(kAngularUnits).value_or(9102);
        if (unit != 9102)
            return failure(
                ErrorCode::badData,
                "its angles are in the unit with EPSG code " + std::to_string(unit) +
                    "; convert it to degrees");
        if (!(std::abs(middle.y) < 89.9))
            return failure(
                ErrorCode::badData,
                "its middle lies at a latitude of " + std::to_string(middle.y) +
                    " degrees, where metres from west to east vanish; warp it to a projection in "
                    "metres");
        return std::optional(placedByDegrees(scale, {middle.y, middle.x}));
    }
    Placement placement;
    placement.spacing = scale;
    if (const auto unit = tags.key(kLinearUnits); unit && *unit != 9001) {
        const auto metres = metresOfUnit(*unit);
        if (!metres && *unit != kUserDefined)
            return failure(
                ErrorCode::badData,
                "its lengths are in the unit with EPSG code " + std::to_string(*unit) +
                    "; convert it to metres or give --pixel-size");
        if (metres) {
            placement.spacing *= *metres;
            placement.notes.push_back(
                "Lengths of the projection were turned into metres, one unit being " +
                std::to_string(*metres) + " m.");
        } else {
            placement.notes.push_back(
                "The unit of the projection is defined by its maker; it is taken for a metre.");
        }
    }
    if (!model)
        placement.notes.push_back(
            "The file doesn't name its coordinates; they are taken for metres.");
    return std::optional(placement);
}

std::optional<GeoPosition> cornerFromName(const std::string& name)
{
    if (name.size() < 7)
        return std::nullopt;
    const char vertical = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    const char horizontal = static_cast<char>(std::toupper(static_cast<unsigned char>(name[3])));
    const auto latitude = digits(name, 1, 2);
    const auto longitude = digits(name, 4, 3);
    if ((vertical != 'N' && vertical != 'S') || (horizontal != 'E' && horizontal != 'W') ||
        !latitude || !longitude || *latitude > 89 || *longitude > 180)
        return std::nullopt;
    return GeoPosition{
        vertical == 'N' ? double(*latitude) : -double(*latitude),
        horizontal == 'E' ? double(*longitude) : -double(*longitude)};
}

} // namespace isofront::elevation

#include "DetailOptions.h"

#include "Arguments.h"
#include "Console.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

namespace isofront::cli {

namespace {

using core::ErrorCode;

constexpr std::size_t kMostCounted = 1'000'000'000'000;

/// "X,Y,Z,R,E": a ball and the error to allow in it.
core::Result<hierarchy::Focus> parseFocus(const std::string& text)
{
    const auto numbers = parseNumbers(text, 5);
    if (numbers && (*numbers)[3] >= 0 && (*numbers)[4] > 0) {
        const std::vector<double>& n = *numbers;
        hierarchy::Focus focus;
        focus.box.low = focus.box.high = {n[0], n[1], n[2]};
        focus.radius = n[3];
        focus.error = n[4];
        return focus;
    }
    return core::failure(
        ErrorCode::usage,
        "--focus '" + text +
            "': give X,Y,Z,R,E in world units, a centre, a radius of at least 0 and an error above "
            "0, as in 10,-2.5,300,50,0.1");
}

/// "512MiB", "2G", "1500000".
core::Result<std::size_t> parseBytes(const std::string& text, const char* option)
{
    const auto failed = [&] {
        return core::failure(
            ErrorCode::usage,
            std::string(option) + " '" + text +
                "': give a size from 1 MiB to 1024 TiB, as in 512MiB, 2GiB or 1500000");
    };
    double number = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc())
        return failed();
    const std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
    int power = -1;
    constexpr std::string_view kPrefixes = "KMGT";
    if (unit.empty() || unit == "B")
        power = 0;
    else if (unit.size() == 1 || unit.substr(1) == "iB")
        if (const std::size_t at = kPrefixes.find(unit[0]); at != std::string_view::npos)
            power = static_cast<int>(at) + 1;
    const double bytes = std::ldexp(number, 10 * power);
    if (power < 0 || !(bytes >= std::ldexp(1.0, 20)) || bytes > std::ldexp(1.0, 50))
        return failed();
    return static_cast<std::size_t>(bytes);
}

nlohmann::ordered_json ceilingJson(std::size_t most)
{
    if (most == std::numeric_limits<std::size_t>::max())
        return nullptr;
    return most;
}

} // namespace

void DetailOptions::addDetailTo(CLI::App& command)
{
    command
        .add_option(
            "--focus",
            focus,
            "X,Y,Z,R,E: within R of a place, allow an expected error of E at most, from wherever "
            "it is seen [world]; may be given again")
        ->allow_extra_args(false)
        ->type_name("X,Y,Z,R,E");
    command.add_option(
        "--world-error", worldError, "expected error to allow everywhere at most [world]");
}

void DetailOptions::addCeilingsTo(CLI::App& command)
{
    const std::string coarser = "; over it everything is shown coarser";
    command.add_option("--max-cells", maxCells, "cells at once, empty ones included" + coarser)
        ->check(CLI::Range(std::size_t{6}, kMostCounted));
    command.add_option("--max-triangles", maxTriangles, "triangles at once" + coarser)
        ->check(CLI::Range(std::size_t{1}, kMostCounted));
    command
        .add_option(
            "--max-memory",
            maxMemory,
            "of the surface, as in 512MiB: meshes, hierarchy and cache" + coarser)
        ->type_name("SIZE");
}

core::Result<DetailRequest> DetailOptions::request() const
{
    DetailRequest request;
    for (const std::string& text : focus) {
        auto place = parseFocus(text);
        if (!place)
            return tl::unexpected<core::Error>(place.error());
        request.settings.focus.push_back(*place);
    }
    if (!(worldError >= 0) || !std::isfinite(worldError))
        return core::failure(
            ErrorCode::usage,
            "--world-error " + brief(worldError) +
                ": it must be a positive number of world units, or 0 for any error");
    request.settings.worldError = worldError;
    if (maxCells > 0)
        request.maxCells = maxCells;
    if (maxTriangles > 0)
        request.maxTriangles = maxTriangles;
    if (!maxMemory.empty()) {
        const auto bytes = parseBytes(maxMemory, "--max-memory");
        if (!bytes)
            return tl::unexpected<core::Error>(bytes.error());
        request.maxBytes = *bytes;
    }
    return request;
}

void DetailRequest::applyTo(surface::SurfaceOptions& options) const
{
    options.detail = settings;
    options.maxCells = maxCells;
    options.maxTriangles = maxTriangles;
    options.maxBytes = maxBytes;
}

void DetailRequest::describeDetail(nlohmann::ordered_json& json) const
{
    json["focus"] = nlohmann::ordered_json::array();
    for (const hierarchy::Focus& place : settings.focus) {
        const glm::dvec3& centre = place.box.low;
        json["focus"].push_back(
            {{"centre", {centre.x, centre.y, centre.z}},
             {"radius", place.radius},
             {"error", place.error}});
    }
    json["world_error"] = settings.worldError;
}

void DetailRequest::describeCeilings(nlohmann::ordered_json& json) const
{
    json["max_cells"] = ceilingJson(maxCells);
    json["max_triangles"] = ceilingJson(maxTriangles);
    json["max_memory_bytes"] = ceilingJson(maxBytes);
}

std::string coarserNote(double asked, double effective)
{
    if (!(effective > asked))
        return {};
    return "note: the ceilings allowed an error of " + brief(effective) + " px in place of " +
           brief(asked) + " px, and " + brief(effective / asked) +
           " times the other errors that were asked for";
}

} // namespace isofront::cli

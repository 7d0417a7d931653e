#include "SourceArguments.h"

#include "Arguments.h"
#include "Console.h"

#include <isofront/volume/MeshLevelSet.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

namespace isofront::cli {

namespace {

/// "30" or "66.2,92.8": one distance for both axes, or one for each [m].
core::Result<glm::dvec2> parsePixelSize(const std::string& text)
{
    glm::dvec2 size(0.0);
    const std::string_view view = text;
    const std::size_t comma = view.find(',');
    const auto number = [](std::string_view part, double& value) {
        const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
        return error == std::errc() && end == part.data() + part.size() && std::isfinite(value) &&
               value > 0;
    };
    bool good = number(view.substr(0, comma), size.x);
    size.y = size.x;
    if (comma != std::string_view::npos)
        good = number(view.substr(comma + 1), size.y) && good;
    if (!good)
        return core::failure(
            core::ErrorCode::usage,
            "--pixel-size '" + text +
                "': give the distance of two heights in metres, as in 30 or 66.2,92.8");
    return size;
}

} // namespace

CLI::Option* addSource(CLI::App& command, std::string& text)
{
    return command.add_option(
        "SOURCE",
        text,
        "a volume: .nrrd .nhdr .nii .nii.gz .mha .mhd .vdb, .tif of several pages, .raw .raw.gz "
        ".bin (see --raw),\n"
        "or a folder of DICOM or TIFF slices; an elevation raster: .hgt .hgt.gz .tif .png;\n"
        "a mesh: .glb .gltf .ply .obj .stl;\n"
        "or a field by formula, proc:NAME[?key=value&...], as 'isofront info proc:' lists them");
}

void addSourceArguments(CLI::App& command, SourceArguments& arguments)
{
    const double most = std::numeric_limits<float>::max();
    command.add_option("--grid", arguments.grid, "which grid of a VDB file");
    command.add_option("--memory-limit", arguments.memoryLimitGib, "of the source [GiB]")
        ->check(within(0.001, 1e6))
        ->capture_default_str();
    command.add_option(
        "--series",
        arguments.series,
        "of a DICOM folder: part of the identifier or the description of a series");
    command.add_option(
        "--raw",
        arguments.rawLayout,
        "what a raw file holds: SIZE,TYPE,ORDER[,OFFSET], as in 256x256x128,uint16,little,0");
    command.add_option(
        "--voxel-size",
        arguments.voxelSize,
        "of a volume, instead of what the file says: X,Y,Z [world]");
    command
        .add_option(
            "--mesh-resolution",
            arguments.meshResolution,
            "of a mesh as distances: voxels along its longest edge")
        ->check(CLI::Range(
            volume::LevelSetOptions::kLeastResolution, volume::LevelSetOptions::kMostResolution))
        ->capture_default_str();
    command
        .add_option(
            "--mesh-reach",
            arguments.meshReach,
            "of a mesh as distances: how far from it they are known; default: a sixteenth of its "
            "longest edge [world]")
        ->check(within(0.0, most));
    command.add_option(
        "--pixel-size",
        arguments.pixelSize,
        "of an elevation raster: distance of two heights, X or X,Y [m]");
    command
        .add_option(
            "--height-scale",
            arguments.heightScale,
            "of an elevation raster: what one unit of its values means [m]")
        ->check(within(-most, most));
    command
        .add_option(
            "--detail",
            arguments.detail,
            "added to an elevation raster between its heights: natural, rugged (crags, overhangs "
            "and "
            "caves) or none")
        ->capture_default_str();
    command
        .add_option(
            "--no-data", arguments.noData, "of an elevation raster: the value of a missing height")
        ->check(within(-most, most));
}

std::uint64_t memoryLimit(const SourceArguments& arguments)
{
    return static_cast<std::uint64_t>(arguments.memoryLimitGib * double(1ULL << 30U));
}

core::Result<SourceOptions> sourceOptions(const SourceArguments& arguments, std::stop_token stop)
{
    SourceOptions options;
    options.memoryLimit = memoryLimit(arguments);
    options.grid = arguments.grid;
    options.series = arguments.series;
    options.rawLayout = arguments.rawLayout;
    options.heightScale = arguments.heightScale;
    options.noData = arguments.noData;
    options.detail = arguments.detail;
    options.meshResolution = arguments.meshResolution;
    options.meshReach = arguments.meshReach;
    options.stop = std::move(stop);
    if (!arguments.pixelSize.empty()) {
        const auto size = parsePixelSize(arguments.pixelSize);
        if (!size)
            return tl::unexpected<core::Error>(size.error());
        options.pixelSize = *size;
    }
    if (!arguments.voxelSize.empty()) {
        const auto size = parsePoint(arguments.voxelSize, "--voxel-size");
        if (!size)
            return tl::unexpected<core::Error>(size.error());
        options.voxelSize = *size;
    }
    return options;
}

core::Error withMemoryLimit(const core::Error& error, const SourceArguments& arguments)
{
    return withOption(error, "--memory-limit", brief(arguments.memoryLimitGib) + " GiB");
}

std::string isovalueNote(double isovalue)
{
    return "note: no --isovalue given; " + brief(isovalue) + " separates best";
}

core::Result<Source>
openSource(const std::string& text, const SourceArguments& arguments, std::stop_token stop)
{
    const auto options = sourceOptions(arguments, std::move(stop));
    if (!options)
        return tl::unexpected<core::Error>(options.error());
    auto opened = openSource(text, *options);
    if (!opened)
        return tl::unexpected(withMemoryLimit(opened.error(), arguments));
    return opened;
}

} // namespace isofront::cli

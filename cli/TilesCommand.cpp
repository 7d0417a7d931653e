#include "Arguments.h"
#include "Console.h"
#include "MeshOptions.h"
#include "SourceArguments.h"

#include <isofront/core/Process.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/tiles/Tileset.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

/// Where there are no voxels to go by.
constexpr int kLevelsOfFormulas = 4;

struct TilesArguments {
    std::string source;
    SourceArguments input;
    std::string output;
    std::optional<double> isovalue;
    std::optional<int> levels;
    std::string spacing;
    double error = 0;
    std::size_t maxTriangles = 0; ///< 0 for any number
    int tileSteps = 64;
    int lattice = 4;
    double filter = 0;
    double coarseFilter = 0.5;
    bool closed = false;
    MeshOptions mesh;
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
};

/// What doesn't need the source to be refused.
core::Result<void> check(const TilesArguments& arguments)
{
    namespace fs = std::filesystem;
    if (!extractor::VolumeMesh::isValidSize(arguments.lattice) || arguments.lattice < 4)
        return core::failure(
            ErrorCode::usage,
            "--lattice " + std::to_string(arguments.lattice) + ": it must be 4, 8 or 16");
    const int steps = arguments.tileSteps;
    if (steps < 2 * arguments.lattice || (steps & (steps - 1)) != 0)
        return core::failure(
            ErrorCode::usage,
            "--tile-steps " + std::to_string(steps) + ": it must be a power of two from " +
                std::to_string(2 * arguments.lattice) + ", two lattice sizes, to 1024");
    if (arguments.levels && !arguments.spacing.empty())
        return core::failure(
            ErrorCode::usage, "--levels and --spacing exclude each other: give one");
    const fs::path output(arguments.output);
    const fs::path folder = output.has_filename() ? output : output.parent_path();
    std::error_code error;
    if (fs::exists(fs::symlink_status(folder, error)) &&
        (!fs::is_directory(folder, error) || fs::is_symlink(fs::symlink_status(folder, error)) ||
         !fs::is_empty(folder, error) || error))
        return core::failure(
            ErrorCode::inputOutput,
            arguments.output + " is there: name a new folder, or an empty one");
    return checkFolderOf(folder.string());
}

/// How many levels it takes to come down to a step.
core::Result<int> levelsOf(const TilesArguments& arguments, const Source& source)
{
    if (arguments.levels)
        return *arguments.levels;
    const double stretch = source.domain.worldFromField.stretch();
    const bool isNative = arguments.spacing == "native";
    double step = source.voxel.value_or(0) * stretch;
    if (isNative && !source.voxel)
        return core::failure(
            ErrorCode::usage,
            source.name +
                " has no voxels of its own: give --spacing S in world units, or --levels");
    if (arguments.spacing.empty() && !source.voxel)
        return kLevelsOfFormulas;
    if (!isNative && !arguments.spacing.empty()) {
        char* end = nullptr;
        step = std::strtod(arguments.spacing.c_str(), &end);
        if (*end != '\0' || !(step > 0) || !std::isfinite(step))
            return core::failure(
                ErrorCode::usage,
                "--spacing '" + arguments.spacing +
                    "': give 'native' or a positive number of world units");
    }
    double rootStep = source.domain.edge * stretch / arguments.tileSteps;
    int levels = 1;
    for (; rootStep > step * (1 + 1e-9) && levels <= tiles::kMostLevels; rootStep /= 2)
        ++levels;
    if (levels > tiles::kMostLevels)
        return core::failure(
            ErrorCode::usage,
            "a step of " + brief(step) + " takes more than " + std::to_string(tiles::kMostLevels) +
                " levels: give a larger --spacing, or larger tiles with --tile-steps");
    return levels;
}

nlohmann::ordered_json
settingsOf(const TilesArguments& arguments, const MeshOptions& mesh, double isovalue, int levels)
{
    nlohmann::ordered_json json;
    json["isovalue"] = isovalue;
    json["levels"] = levels;
    json["error"] = arguments.error;
    if (arguments.maxTriangles > 0)
        json["max_triangles"] = arguments.maxTriangles;
    else
        json["max_triangles"] = nullptr;
    json["tile_steps"] = arguments.tileSteps;
    json["lattice"] = arguments.lattice;
    json["filter"] = arguments.filter;
    json["coarse_filter"] = arguments.coarseFilter;
    json["closed"] = arguments.closed;
    mesh.describe(json);
    return json;
}

int writeTiles(const TilesArguments& arguments)
{
    const auto start = Clock::now();
    const auto secondsSince = [](Clock::time_point from) {
        return std::chrono::duration<double>(Clock::now() - from).count();
    };
    const std::stop_token stop = interruptions();
    Progress progress(arguments.quiet);
    if (const auto checked = check(arguments); !checked)
        return report(checked.error());

    progress.show("loading " + arguments.source, -1);
    const auto source = openSource(arguments.source, arguments.input, stop);
    if (!source)
        return report(source.error());
    const double loadSeconds = secondsSince(start);
    for (const std::string& note : source->notes)
        progress.say("note: " + note);
    const auto levels = levelsOf(arguments, *source);
    if (!levels)
        return report(levels.error());
    const double isovalue = arguments.isovalue.value_or(source->defaultIsovalue);
    if (!arguments.isovalue && source->volume)
        progress.say(isovalueNote(isovalue));

    extractor::ExtractionSettings settings;
    settings.latticeSize = arguments.lattice;
    settings.isovalue = source->fieldIsovalue(isovalue);
    settings.filterStrength = arguments.filter;
    settings.closed = arguments.closed;
    MeshOptions mesh = arguments.mesh;
    // as for 'extract': measured voxels gain little
    if (!mesh.quality)
        mesh.quality = source->volume && !source->negated ? "plain" : "good";
    mesh.applyTo(settings);
    const auto settingsJson = settingsOf(arguments, mesh, isovalue, *levels);
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);

    tiles::TilesetOptions options;
    options.levels = *levels;
    options.tileSteps = arguments.tileSteps;
    options.coarseFilter = arguments.coarseFilter;
    options.maxError = arguments.error;
    options.maxTriangles = arguments.maxTriangles;
    options.memoryLimit = memoryLimit(arguments.input);
    options.name = source->name;
    options.settings = {{"source", source->name}, {"settings", settingsJson.dump()}};
    options.progress = [&](const std::string& what, double share) { progress.show(what, share); };
    options.stop = stop;
    const auto made = tiles::writeTileset(
        source->field, source->domain, settings, *jobs, options, arguments.output);
    if (!made)
        return report(made.error().within(source->name));
    progress.finish();

    const auto& written = made->levels;
    if (written.size() < static_cast<std::size_t>(*levels) && written.front().tiles > 0)
        progress.say(
            "note: " + std::to_string(written.size()) + " levels in place of " +
            std::to_string(*levels) + ": finer ones " +
            (arguments.error > 0
                 ? "aren't needed for --error " + brief(arguments.error)
                 : "have more than " + grouped(arguments.maxTriangles) + " triangles"));
    for (const std::string& warning : made->warnings)
        progress.say("warning: " + warning);
    if (made->sanitisedSamples > 0)
        progress.say(
            "warning: " + grouped(made->sanitisedSamples) +
            " samples were not finite or huge; they were clamped, and NaN counts as outside");
    const double total = secondsSince(start);
    std::uint64_t triangles = 0;
    for (const tiles::TilesetLevel& level : written)
        triangles += level.triangles;
    if (!arguments.json) {
        progress.say(
            arguments.output + ": " + std::to_string(written.size()) + " levels, " +
            grouped(made->files) + " files, " + grouped(triangles) + " triangles, " +
            grouped(made->bytes) + " bytes; " + brief(total) + " s");
        return 0;
    }
    nlohmann::ordered_json json;
    json["output"] = arguments.output;
    json["files"] = made->files;
    json["bytes"] = made->bytes;
    json["triangles"] = triangles;
    json["levels"] = nlohmann::ordered_json::array();
    for (const tiles::TilesetLevel& level : written)
        json["levels"].push_back(
            {{"step", level.step},
             {"tiles", level.tiles},
             {"triangles", level.triangles},
             {"measured_error", level.measuredError},
             {"geometric_error", level.error}});
    if (made->bounds.isEmpty()) {
        json["bounds"] = nullptr;
    } else {
        const auto& [low, high] = made->bounds;
        json["bounds"] = {{"min", {low.x, low.y, low.z}}, {"max", {high.x, high.y, high.z}}};
    }
    json["sanitised_samples"] = made->sanitisedSamples;
    json["seconds"] = {{"total", total}, {"load", loadSeconds}};
    json["peak_rss_bytes"] = core::peakResidentBytes();
    json["threads"] = jobs->concurrency();
    json["settings"] = settingsJson;
    json["warnings"] = made->warnings;
    print(json);
    return 0;
}

} // namespace

Action addTiles(CLI::App& app)
{
    auto arguments = std::make_shared<TilesArguments>();
    CLI::App* command = app.add_subcommand(
        "tiles", "Write the isosurface of a source as 3D Tiles, for maps and web viewers");
    addSource(*command, arguments->source)->required();
    command
        ->add_option(
            "-o,--output",
            arguments->output,
            "folder for tileset.json and its .glb files, which must be new or empty")
        ->required();
    command
        ->add_option(
            "--isovalue",
            arguments->isovalue,
            "solid is where the value is at or above it; default: what separates the volume best")
        ->check(isovalues());
    command
        ->add_option(
            "--levels",
            arguments->levels,
            "of tiles, 1 to 12: the first is one tile, each other one is twice as fine; default: "
            "down to the voxels, or 4")
        ->check(CLI::Range(1, tiles::kMostLevels));
    command->add_option(
        "--spacing",
        arguments->spacing,
        "'native' (the default for volumes), or a step in world units that the finest level has "
        "at most");
    command
        ->add_option(
            "--error",
            arguments->error,
            "leave out what refines tiles whose measured error is at most this [world units]; 0 "
            "keeps all")
        ->check(within(0.0, 1e300))
        ->capture_default_str();
    command
        ->add_option(
            "--max-triangles",
            arguments->maxTriangles,
            "of the finest level; levels that have more are left out")
        ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 40U));
    command
        ->add_option(
            "--tile-steps",
            arguments->tileSteps,
            "lattice steps along the edge of a tile, a power of two up to 1024: more for fewer "
            "and larger files")
        ->check(CLI::Range(8, 1024))
        ->capture_default_str();
    command->add_option("--lattice", arguments->lattice, "lattice segments of a cell: 4, 8 or 16")
        ->capture_default_str();
    command
        ->add_option(
            "--filter",
            arguments->filter,
            "strength of the low-pass filter of the finest level: 0 none, 1 all that the lattice "
            "can't hold")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    command->add_option("--coarse-filter", arguments->coarseFilter, "the same of all other levels")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    arguments->mesh.addTo(*command);
    command->add_flag(
        "--closed",
        arguments->closed,
        "close the surface at the border of the data; otherwise it ends there");
    command->add_option("--threads", arguments->threads, "0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    addSourceArguments(*command, arguments->input);
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer(
        "Any client of 3D Tiles 1.1 shows them without preparation, and loads what a view needs: "
        "serve\n"
        "the folder over HTTP and give it tileset.json. World units are taken as metres, and z is "
        "up.\n\n"
        "Examples:\n"
        "  isofront tiles head.nrrd --isovalue 300 -o head-tiles\n"
        "  isofront tiles N44W072.hgt -o mountains --error 2\n"
        "  isofront tiles 'proc:terrain?preset=canyon' --levels 6 -o canyon --json");
    return [arguments] { return writeTiles(*arguments); };
}

} // namespace isofront::cli

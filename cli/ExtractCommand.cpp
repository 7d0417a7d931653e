#include "Arguments.h"
#include "Console.h"
#include "DetailOptions.h"
#include "MeshOptions.h"
#include "SourceArguments.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/MeshFile.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/surface/MeshExtraction.h>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

/// More than any mesh has.
constexpr std::size_t kMostTriangles = std::size_t{1} << 40U;

struct ExtractArguments {
    std::string source;
    SourceArguments input;
    std::string output;
    std::optional<double> isovalue;
    std::string spacing;
    std::optional<int> level;
    std::optional<double> maxError;
    std::string eye;
    std::optional<double> pixelError;
    double fov = 60;
    std::string size = "1280x720";
    int lattice = 4;
    std::optional<double> filter;
    bool closed = false;
    bool estimateError = false;
    MeshOptions mesh;
    DetailOptions detail;
    bool attributes = false;
    std::size_t maxTriangles = 0; ///< 0 for any number
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
};

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// How `--spacing`, `--level`, `--max-error` and `--eye` say how fine the mesh is to be.
core::Result<surface::Detail> detailOf(const ExtractArguments& arguments, const Source& source)
{
    using hierarchy::axisStep;
    const int n = arguments.lattice;
    // the axis step in field units is this share of the domain's edge
    const double edge = source.domain.edge;
    const double stretch = source.domain.worldFromField.stretch();
    const bool byView = !arguments.eye.empty() || arguments.pixelError;
    const int ways = (arguments.spacing.empty() ? 0 : 1) + (arguments.level ? 1 : 0) +
                     (arguments.maxError ? 1 : 0) + (byView ? 1 : 0);
    if (ways > 1)
        return core::failure(
            ErrorCode::usage,
            "--spacing, --level, --max-error and --eye/--pixel-error exclude each other: give one");

    const auto levelFor = [&](double step) { return levelForStep(step / edge, n); };
    const int native = source.voxel ? levelFor(*source.voxel) : 18;
    const int cap =
        std::min(native + (source.voxel ? source.levelsBelowVoxel : 18), hierarchy::kMaxLevel);

    const auto request = arguments.detail.request();
    if (!request)
        return tl::unexpected<core::Error>(request.error());
    if (!byView && (!arguments.detail.focus.empty() || arguments.detail.worldError > 0))
        return core::failure(
            ErrorCode::usage,
            "--focus and --world-error go with --eye X,Y,Z: give it too, or use --max-error for "
            "one error everywhere");

    surface::Detail detail;
    if (arguments.level) {
        if (*arguments.level < 0 || *arguments.level > hierarchy::kMaxLevel)
            return core::failure(
                ErrorCode::usage,
                "--level " + std::to_string(*arguments.level) + ": levels go from 0 to " +
                    std::to_string(hierarchy::kMaxLevel));
        detail.level = *arguments.level;
        return detail;
    }
    if (arguments.maxError) {
        if (!(*arguments.maxError > 0) || !std::isfinite(*arguments.maxError))
            return core::failure(
                ErrorCode::usage, "--max-error must be a positive number of world units");
        detail.kind = surface::Detail::Kind::error;
        detail.maxError = *arguments.maxError;
        detail.level = cap;
        return detail;
    }
    if (byView) {
        if (arguments.eye.empty())
            return core::failure(
                ErrorCode::usage,
                "--pixel-error needs --eye X,Y,Z, the place that it is seen from");
        const auto eye = parsePoint(arguments.eye, "--eye");
        if (!eye)
            return tl::unexpected<core::Error>(eye.error());
        const auto size = parseSize(arguments.size);
        if (!size)
            return tl::unexpected<core::Error>(size.error());
        detail.kind = surface::Detail::Kind::view;
        detail.settings = request->settings;
        detail.view.eye = *eye;
        detail.view.verticalFieldOfView = arguments.fov * 3.14159265358979323846 / 180;
        detail.view.width = size->width;
        detail.view.height = size->height;
        detail.pixelError = arguments.pixelError.value_or(1.0);
        if (const auto checked = checkPixelError(detail.pixelError); !checked)
            return tl::unexpected<core::Error>(checked.error());
        detail.level = cap;
        return detail;
    }
    if (arguments.spacing.empty() || arguments.spacing == "native") {
        if (!source.voxel && arguments.spacing == "native")
            return core::failure(
                ErrorCode::usage,
                source.name + " has no voxels of its own: give --spacing S in world units");
        // without a word a procedural source gets 128 steps along its domain's edge
        detail.level = source.voxel ? native : levelFor(edge / 128);
        return detail;
    }
    char* end = nullptr;
    const double spacing = std::strtod(arguments.spacing.c_str(), &end);
    if (*end != '\0' || !(spacing > 0) || !std::isfinite(spacing))
        return core::failure(
            ErrorCode::usage,
            "--spacing '" + arguments.spacing +
                "': give 'native' or a positive number of world units");
    detail.level = levelFor(spacing / stretch);
    if (axisStep(detail.level, n) * edge * stretch > spacing * (1 + 1e-9))
        return core::failure(
            ErrorCode::usage,
            "--spacing " + arguments.spacing +
                " is finer than the deepest level of this source: use at least " +
                brief(axisStep(90, n) * edge * stretch));
    return detail;
}

nlohmann::ordered_json settingsOf(
    const ExtractArguments& arguments,
    const surface::Detail& detail,
    const extractor::ExtractionSettings& settings,
    const MeshOptions& mesh,
    const Source& source,
    double isovalue)
{
    using Json = nlohmann::ordered_json;
    Json json;
    json["isovalue"] = isovalue;
    json["detail"] = detail.kind == surface::Detail::Kind::level   ? "level"
                     : detail.kind == surface::Detail::Kind::error ? "max-error"
                                                                   : "view";
    if (detail.kind == surface::Detail::Kind::level) {
        json["level"] = detail.level;
        json["axis_step"] = hierarchy::axisStep(detail.level, arguments.lattice) *
                            source.domain.edge * source.domain.worldFromField.stretch();
    } else if (detail.kind == surface::Detail::Kind::error) {
        json["max_error"] = detail.maxError;
    } else {
        json["pixel_error"] = detail.pixelError;
        json["eye"] = {detail.view.eye.x, detail.view.eye.y, detail.view.eye.z};
        DetailRequest{.settings = detail.settings}.describeDetail(json);
    }
    if (arguments.maxTriangles > 0)
        json["max_triangles"] = arguments.maxTriangles;
    else
        json["max_triangles"] = nullptr;
    json["lattice"] = arguments.lattice;
    json["filter"] = settings.filterStrength;
    json["closed"] = settings.closed;
    mesh.describe(json);
    json["attributes"] = settings.attributes;
    return json;
}

/// What a mesh was made with, if its ceiling left less than was asked for; else empty.
std::string ceilingNote(
    const surface::Detail& asked, const surface::ExtractedMesh& made, std::size_t maxTriangles)
{
    if (!(made.coarser > 1))
        return {};
    const std::string start = "note: at most " + grouped(maxTriangles) + " triangles: ";
    if (asked.kind == surface::Detail::Kind::level)
        return start + "level " + std::to_string(made.detail.level) + " in place of " +
               std::to_string(asked.level);
    if (asked.kind == surface::Detail::Kind::error)
        return start + "an error of " + brief(made.detail.maxError) + " in place of " +
               brief(asked.maxError);
    return start + "an error of " + brief(made.detail.pixelError) + " px in place of " +
           brief(asked.pixelError) + " px, and " + brief(made.coarser) +
           " times the other errors that were asked for";
}

int extract(const ExtractArguments& arguments)
{
    const auto start = Clock::now();
    const std::stop_token stop = interruptions();
    Progress progress(arguments.quiet);
    const auto limit = static_cast<std::uint64_t>(arguments.input.memoryLimitGib * (1ULL << 30U));

    // what can be refused is refused before any work
    if (const auto format = exchange::meshFormatOf(arguments.output); !format)
        return report(format.error());
    if (const auto folder = checkFolderOf(arguments.output); !folder)
        return report(folder.error());
    if (!extractor::VolumeMesh::isValidSize(arguments.lattice) || arguments.lattice < 4)
        return report(
            {ErrorCode::usage,
             "--lattice " + std::to_string(arguments.lattice) + ": it must be 4, 8 or 16"});

    progress.show("loading " + arguments.source, -1);
    auto opened = openSource(arguments.source, arguments.input, stop);
    if (!opened)
        return report(opened.error());
    const Source source = std::move(*opened);
    const double loadSeconds = secondsSince(start);
    for (const std::string& note : source.notes)
        progress.say("note: " + note);

    const auto detail = detailOf(arguments, source);
    if (!detail)
        return report(detail.error());
    const double isovalue = arguments.isovalue.value_or(source.defaultIsovalue);
    if (!arguments.isovalue && source.volume)
        progress.say(isovalueNote(isovalue));

    extractor::ExtractionSettings settings;
    settings.latticeSize = arguments.lattice;
    settings.isovalue = source.fieldIsovalue(isovalue);
    // what is measured or manufactured isn't filtered; a view is, by the strength of all views
    if (arguments.filter || detail->kind != surface::Detail::Kind::view)
        settings.filterStrength = arguments.filter.value_or(0.0);
    const int finest = source.voxel
                           ? levelForStep(*source.voxel / source.domain.edge, arguments.lattice)
                           : detail->level;
    settings.cornerRadius = 2 * hierarchy::axisStep(finest, arguments.lattice) * source.domain.edge;
    settings.closed = arguments.closed;
    MeshOptions mesh = arguments.mesh;
    // what is kept is worth some time; but measured voxels, unlike those of a level set, are not
    // smooth, and gain a fifth for more than twice the time
    if (!mesh.quality)
        mesh.quality = source.volume && !source.negated ? "plain" : "good";
    mesh.applyTo(settings);
    settings.attributes = arguments.attributes;
    settings.estimateError =
        arguments.estimateError || detail->kind == surface::Detail::Kind::error;
    if (settings.attributes && !source.field->hasAttributes())
        progress.say("note: " + source.name + " has no attributes; none are written");
    const auto extractor =
        std::make_shared<const extractor::CellExtractor>(source.field, source.domain, settings);
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);

    surface::MeshExtractionOptions options;
    options.detail = *detail;
    options.memoryLimit = limit;
    options.maxTriangles = arguments.maxTriangles;
    options.stop = stop;
    options.progress = [&](const char* what, double share) { progress.show(what, share); };
    auto result = surface::extractMesh(extractor, *jobs, options);
    if (!result)
        return report(result.error().within(source.name));
    progress.finish();

    if (stop.stop_requested())
        return report({ErrorCode::interrupted, "interrupted; nothing was written"});
    const auto writeStart = Clock::now();
    progress.show("writing " + arguments.output, -1);
    const auto settingsJson =
        settingsOf(arguments, result->detail, settings, mesh, source, isovalue);
    exchange::ExportOptions exportOptions;
    exportOptions.name = source.name;
    exportOptions.settings = {{"source", source.name}, {"settings", settingsJson.dump()}};
    const auto written = exchange::writeMesh(result->mesh, arguments.output, exportOptions);
    if (!written)
        return report(written.error());
    progress.finish();
    if (const std::string note = ceilingNote(*detail, *result, arguments.maxTriangles);
        !note.empty())
        progress.say(note);
    std::vector<std::string> warnings = written->warnings;
    if (detail->kind == surface::Detail::Kind::error && result->coarser == 1 &&
        result->errorMax > detail->maxError)
        warnings.push_back(
            "--max-error " + brief(detail->maxError) + " is not reached: the estimated error is " +
            brief(result->errorMax) + " somewhere, and cells are not refined beyond level " +
            std::to_string(detail->level));
    for (const std::string& warning : warnings)
        progress.say("warning: " + warning);
    if (result->sanitisedSamples > 0)
        progress.say(
            "warning: " + grouped(result->sanitisedSamples) +
            " samples were not finite or huge; they were clamped, and NaN counts as outside");

    const auto threads = jobs->concurrency();
    const double total = secondsSince(start);
    const std::uint64_t triangles = result->mesh.indices.size() / 3;
    if (!arguments.json) {
        progress.say(
            arguments.output + ": " + grouped(triangles) + " triangles, " +
            grouped(result->mesh.positions.size()) + " vertices, " + grouped(written->bytes) +
            " bytes; " + grouped(result->cells) + " cells, " + grouped(result->cellsSkipped) +
            " of them proved empty; " + brief(total) + " s");
        return 0;
    }
    nlohmann::ordered_json json;
    json["output"] = arguments.output;
    json["bytes"] = written->bytes;
    json["triangles"] = triangles;
    json["vertices"] = result->mesh.positions.size();
    json["cells"] = result->cells;
    json["cells_skipped"] = result->cellsSkipped;
    json["finest_level"] = result->finestLevel;
    json["coarser"] = result->coarser;
    json["samples"] = result->samples;
    json["sanitised_samples"] = result->sanitisedSamples;
    if (result->mesh.bounds.isEmpty()) {
        json["bounds"] = nullptr;
    } else {
        const auto& [low, high] = result->mesh.bounds;
        json["bounds"] = {{"min", {low.x, low.y, low.z}}, {"max", {high.x, high.y, high.z}}};
    }
    if (settings.estimateError)
        json["estimated_error"] = {{"rms", result->errorRms}, {"max", result->errorMax}};
    // what ran on several threads is told as wall time, so that the parts add up
    const double share = 1.0 / static_cast<double>(threads);
    json["seconds"] = {
        {"total", total},
        {"load", loadSeconds},
        {"front", result->frontSeconds},
        {"sample", result->sampleSeconds * share},
        {"contour", result->contourSeconds * share},
        {"smooth", result->smoothSeconds * share},
        {"simplify", result->simplifySeconds * share},
        {"normals", result->normalSeconds * share},
        {"join", result->joinSeconds * share},
        {"write", secondsSince(writeStart)}};
    json["peak_rss_bytes"] = core::peakResidentBytes();
    json["threads"] = threads;
    json["settings"] = settingsJson;
    json["warnings"] = warnings;
    print(json);
    return 0;
}

} // namespace

Action addExtract(CLI::App& app)
{
    auto arguments = std::make_shared<ExtractArguments>();
    CLI::App* command = app.add_subcommand(
        "extract", "Write the isosurface of a source as a mesh, watertight inside the data");
    addSource(*command, arguments->source)->required();
    command->add_option("-o,--output", arguments->output, "mesh file: .glb .ply .obj .stl")
        ->required();
    command
        ->add_option(
            "--isovalue",
            arguments->isovalue,
            "solid is where the value is at or above it; default: what separates the volume best")
        ->check(isovalues());
    command->add_option(
        "--spacing",
        arguments->spacing,
        "'native' (one lattice step a voxel, the default for volumes) or a step in world units");
    command->add_option("--level", arguments->level, "a bisection level, 0 to 92, everywhere");
    command->add_option(
        "--max-error",
        arguments->maxError,
        "refine until the estimated distance to the true surface is below this [world units]");
    CLI::Option* eye =
        command->add_option("--eye", arguments->eye, "X,Y,Z: as fine as a viewer there needs it");
    command->add_option(
        "--pixel-error", arguments->pixelError, "with --eye: pixels of error to allow, default 1");
    command->add_option("--fov", arguments->fov, "with --eye: vertical field of view [degrees]")
        ->check(within(1.0, 179.0))
        ->needs(eye)
        ->capture_default_str();
    command->add_option("--size", arguments->size, "with --eye: size of the picture [px]")
        ->needs(eye)
        ->capture_default_str();
    command->add_option("--lattice", arguments->lattice, "lattice segments of a cell: 4, 8 or 16")
        ->capture_default_str();
    command
        ->add_option(
            "--filter",
            arguments->filter,
            "strength of the low-pass filter: 0 none (default), 0.5 (default with --eye), 1 all "
            "that "
            "the lattice can't hold")
        ->check(within(0.0, 100.0));
    arguments->detail.addDetailTo(*command);
    arguments->mesh.addTo(*command);
    command->add_flag(
        "--attributes",
        arguments->attributes,
        "write the field's colours or materials, if it has any, to .glb or .ply");
    command->add_flag(
        "--closed",
        arguments->closed,
        "close the surface at the border of the data; otherwise it ends there");
    command->add_flag(
        "--estimate-error",
        arguments->estimateError,
        "report the distance between mesh and unfiltered field (always with --max-error)");
    command->add_option("--threads", arguments->threads, "0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command
        ->add_option(
            "--max-triangles",
            arguments->maxTriangles,
            "of the mesh; what was asked for is made coarser until there are no more")
        ->check(CLI::Range(std::size_t{1}, kMostTriangles));
    addSourceArguments(*command, arguments->input);
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer(
        "The same cells as in 'fly' and 'render', joined to one indexed mesh. World coordinates "
        "are\n"
        "the source's own.\n\n"
        "Examples:\n"
        "  isofront extract head.nrrd --isovalue 300 --closed -o bone.glb\n"
        "  isofront extract scans/head/ --series bone -o skull.ply\n"
        "  isofront extract foot.raw --raw 256x256x256,uint8 --voxel-size 1,1,1 -o foot.stl\n"
        "  isofront extract N44W072.hgt --spacing 60 -o mountains.glb\n"
        "  isofront extract 'proc:gyroid?periods=3' --spacing 0.01 -o gyroid.ply");
    return [arguments] { return extract(*arguments); };
}

} // namespace isofront::cli

#include "Arguments.h"
#include "Console.h"
#include "FieldVoxels.h"
#include "ModelReports.h"
#include "SourceArguments.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/ModelFile.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/DiskRoom.h>
#include <isofront/voxels/FieldVoxelization.h>
#include <isofront/voxels/Voxelization.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct VoxelizeArguments {
    std::string source;
    SourceArguments input;
    std::string output;
    std::string format = "lmdb";
    FieldVoxelOptions field; ///< with the resolution, which is that of meshes, too
    bool conservative = false;
    bool allFaces = false;
    std::string scratch;
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
    const CLI::App* command = nullptr; ///< that they came with
};

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The name of a file or folder without a slash at its end.
std::filesystem::path bare(const std::filesystem::path& path)
{
    return path.has_filename() ? path : path.parent_path();
}

/// A source that is ready to be voxelised, whatever it is.
struct VoxelSource {
    using Voxelizing = std::function<core::Result<voxels::VoxelizationReport>(
        const voxels::VoxelizationSettings&,
        voxels::ChunkSink&,
        core::Jobs&,
        const std::atomic<bool>* cancelled,
        const std::function<void(double)>& progress)>;
    Voxelizing voxelize;
    std::uint32_t resolution = 0; ///< that is asked for; `voxelize` takes others, too
    std::string name;             ///< kept with the model
    std::optional<voxels::ModelField> field = {}; ///< the same of a field
    bool coloured = false;
    std::optional<voxels::ModelSource> file = {}; ///< of a mesh
    std::vector<std::string> notes = {};          ///< on what is missed of it
    /// Its part of the JSON object, and the key that it has there.
    std::string key;
    std::function<Json(const voxels::VoxelizationReport&)> describe;
};

core::Result<VoxelSource> openMesh(const VoxelizeArguments& arguments, const SourceOptions& options)
{
    if (arguments.field.resolution == 0)
        return core::failure(
            ErrorCode::usage,
            arguments.source + " is a mesh: say how many voxels with --resolution N");
    if (const auto useful = checkOptions(
            *arguments.command,
            {"--output",
             "--resolution",
             "--conservative",
             "--all-faces",
             "--format",
             "--scratch",
             "--memory-limit",
             "--threads",
             "--json",
             "--quiet"},
            arguments.source + ", which is a mesh");
        !useful)
        return tl::unexpected(useful.error());
    auto read = exchange::readModel(arguments.source, options.memoryLimit);
    if (!read)
        return tl::unexpected(withMemoryLimit(read.error(), arguments.input));
    const auto model = std::make_shared<const voxels::TriangleModel>(std::move(*read));
    auto file = voxels::describedSource(arguments.source, bare(arguments.output));
    if (!file)
        return tl::unexpected(file.error());
    VoxelSource source;
    source.file = std::move(*file);
    source.resolution = arguments.field.resolution;
    source.voxelize = [model](auto&&... passed) { return voxels::voxelize(*model, passed...); };
    source.name = std::filesystem::path(arguments.source).filename().string();
    source.coloured = model->isColoured();
    source.notes = model->notes;
    source.key = "mesh";
    source.describe = [model](const voxels::VoxelizationReport& report) {
        return meshJson(*model, report.model);
    };
    return source;
}

/// @param say  told what is decided for the user
core::Result<VoxelSource> openField(
    const VoxelizeArguments& arguments,
    const SourceOptions& options,
    const std::function<void(const std::string&)>& say)
{
    auto opened = openSource(arguments.source, options);
    if (!opened)
        return tl::unexpected(withMemoryLimit(opened.error(), arguments.input));
    const auto from = std::make_shared<const Source>(std::move(*opened));
    for (const std::string& note : from->notes)
        say("note: " + note);
    if (!arguments.field.isovalue && from->volume)
        say(isovalueNote(from->defaultIsovalue));
    const auto wanted = fieldVoxelSettings(*from, arguments.field);
    if (!wanted)
        return tl::unexpected(wanted.error());
    const auto made = std::make_shared<voxels::FieldVoxelizationReport>();
    VoxelSource source;
    source.resolution = voxels::latticeOf(*wanted).resolution;
    source.voxelize = [=, wanted = *wanted, resolution = source.resolution](
                          const voxels::VoxelizationSettings& settings,
                          auto&&... passed) -> core::Result<voxels::VoxelizationReport> {
        voxels::FieldVoxelizationSettings own = wanted;
        if (settings.resolution != resolution)
            own.edge *= static_cast<double>(resolution) / settings.resolution;
        own.separability = settings.separability;
        own.allFaces = settings.allFaces;
        own.scratchFolder = settings.scratchFolder;
        const auto report = voxels::voxelizeField(*from->field, own, passed...);
        if (!report)
            return tl::unexpected(report.error());
        *made = *report;
        voxels::VoxelizationReport all;
        all.model.bounds = from->worldBox;
        all.lattice = report->lattice;
        all.voxels = report->voxels;
        all.allVoxels = report->allVoxels;
        all.chunks = report->chunks;
        all.emptyRegions = report->emptyRegions;
        all.scratchBytes = report->scratchBytes;
        return all;
    };
    source.name = from->isProcedural ? from->name
                                     : std::filesystem::path(arguments.source).filename().string();
    source.coloured = from->field->hasAttributes();
    source.field = voxels::ModelField{
        .source = from->identity,
        .isovalue = arguments.field.isovalue.value_or(from->defaultIsovalue),
        .filter = arguments.field.filter,
        .closed = arguments.field.closed,
        .checksum = checksumOf(*from)};
    source.key = "field";
    source.describe = [=,
                       closed = arguments.field.closed,
                       filter = arguments.field.filter,
                       isovalue = arguments.field.isovalue.value_or(from->defaultIsovalue)](
                          const voxels::VoxelizationReport&) {
        Json json;
        json["description"] = from->description;
        json["isovalue"] = isovalue;
        json["filter"] = filter;
        json["closed"] = closed;
        json["samples"] = made->samples;
        json["sanitised_samples"] = made->sanitisedSamples;
        return json;
    };
    return source;
}

core::Result<VoxelSource> openVoxelSource(
    const VoxelizeArguments& arguments,
    const SourceOptions& options,
    const std::function<void(const std::string&)>& say)
{
    const std::string& name = arguments.source;
    if (exchange::isModelName(name))
        return openMesh(arguments, options);
    if (name.starts_with("proc:") || elevation::isElevationName(name) || volume::isVolume(name))
        return openField(arguments, options, say);
    return core::failure(
        ErrorCode::usage,
        name + ": neither a mesh, .glb .gltf .ply .obj or .stl, gzipped or not, nor a volume, an "
               "elevation raster or proc:NAME");
}

/// Refuses, before any work, what writing would end in.
core::Result<void> checkOutput(const VoxelizeArguments& arguments)
{
    std::error_code ignored;
    if (std::filesystem::equivalent(arguments.source, arguments.output, ignored))
        return core::failure(
            ErrorCode::usage, arguments.output + " is the source: name another model to write");
    if (arguments.format == "folder" && std::filesystem::is_directory(arguments.output, ignored))
        return {}; // an empty one will do
    // What is renamed onto a device or a pipe takes its place.
    if (std::filesystem::exists(arguments.output, ignored) &&
        !std::filesystem::is_regular_file(arguments.output, ignored))
        return core::failure(
            ErrorCode::inputOutput,
            arguments.output + " is there and no regular file: choose another name");
    return checkFolderOf(
        arguments.format == "folder" ? bare(arguments.output).string() : arguments.output);
}

/// Where there is room for what waits between the passes: where the model goes, if nothing is said,
/// as the system's folder for such may be in memory.
std::filesystem::path scratchFolderOf(const VoxelizeArguments& arguments)
{
    if (!arguments.scratch.empty())
        return arguments.scratch;
    const std::filesystem::path folder = bare(arguments.output).parent_path();
    return folder.empty() ? "." : folder;
}

/// Refuses, before hours of work, what there is no room for on the disk: a coarse trial tells.
core::Result<void> checkRoom(
    const VoxelizeArguments& arguments,
    const VoxelSource& source,
    const voxels::VoxelizationSettings& settings,
    core::Jobs& jobs,
    const std::atomic<bool>& cancelled,
    const std::function<void(double)>& progress)
{
    const std::filesystem::path folder = bare(arguments.output).parent_path();
    const auto model = voxels::diskFolderOf(folder.empty() ? "." : folder);
    const auto scratch = voxels::diskFolderOf(settings.scratchFolder);
    if (!model || !scratch)
        return {}; // writing there says better what is wrong
    const auto coarse = voxels::trialResolution(source.resolution, *model, *scratch);
    if (!coarse)
        return {};
    voxels::VoxelizationSettings trial = settings;
    trial.resolution = *coarse;
    voxels::TrialSink sink;
    const auto made = source.voxelize(trial, sink, jobs, &cancelled, progress);
    if (!made)
        return tl::unexpected(made.error());
    return voxels::checkDiskRoom(
        voxels::neededAt(source.resolution, *coarse, sink.bytes(), made->scratchBytes),
        source.resolution,
        *model,
        *scratch);
}

int voxelize(const VoxelizeArguments& arguments)
{
    const auto start = Clock::now();
    const std::stop_token stop = interruptions();
    Progress progress(arguments.quiet);
    const auto options = sourceOptions(arguments.input, stop);
    if (!options)
        return report(options.error());
    if (const auto checked = checkOutput(arguments); !checked)
        return report(checked.error());

    progress.show("loading " + arguments.source, -1);
    const auto source =
        openVoxelSource(arguments, *options, [&](const std::string& note) { progress.say(note); });
    if (!source)
        return report(source.error());
    const double loadSeconds = secondsSince(start);

    auto store = arguments.format == "folder" ? voxels::createFolderStore(arguments.output)
                                              : voxels::createStore(arguments.output);
    if (!store)
        return report(store.error());
    voxels::VoxelizationSettings settings;
    settings.resolution = source->resolution;
    settings.separability =
        arguments.conservative ? voxels::Separability::conservative : voxels::Separability::six;
    settings.allFaces = arguments.allFaces;
    settings.scratchFolder = scratchFolderOf(arguments);
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);
    std::atomic<bool> cancelled = false;
    const std::stop_callback cancelling(stop, [&] { cancelled = true; });
    const auto work = [&]() -> core::Result<voxels::VoxelizationReport> {
        const auto fits =
            checkRoom(arguments, *source, settings, *jobs, cancelled, [&](double share) {
                progress.show("estimating the room that it needs", share);
            });
        if (!fits)
            return tl::unexpected(fits.error());
        return source->voxelize(settings, **store, *jobs, &cancelled, [&](double share) {
            progress.show("voxelising " + arguments.source, share);
        });
    };
    const auto made = work();
    progress.finish();
    if (!made && made.error().code == ErrorCode::interrupted)
        return report({ErrorCode::interrupted, "interrupted; nothing was written"});
    if (!made && made.error().code == ErrorCode::inputOutput)
        return report(
            {ErrorCode::inputOutput,
             made.error().within(arguments.source).message + " (temporary files go to " +
                 settings.scratchFolder.string() + ": see --scratch)"});
    if (!made)
        return report(made.error().within(arguments.source));
    const double voxelizeSeconds = secondsSince(start) - loadSeconds;

    voxels::StoredModel model;
    model.name = source->name;
    model.lattice = made->lattice;
    model.voxels = made->voxels;
    model.allVoxels = made->allVoxels;
    model.chunks = made->chunks;
    model.coloured = source->coloured;
    model.separability = settings.separability;
    model.source = source->file;
    model.field = source->field;
    progress.show("writing " + arguments.output, -1);
    if (const auto failed = (*store)->finish(model))
        return report(*failed);
    progress.finish();

    std::vector<std::string> warnings = source->notes;
    std::ranges::copy(made->model.notes(), std::back_inserter(warnings));
    if (made->voxels == 0)
        warnings.emplace_back(
            source->key == "mesh"
                ? "no voxel separates anything: the surface is too small, or too thin"
                : "there is no surface: no two voxels lie on different sides of the isovalue");
    for (const std::string& warning : warnings)
        progress.say("warning: " + warning);
    const std::uint64_t bytes = bytesOnDisk(arguments.output);
    const double total = secondsSince(start);
    if (!arguments.json) {
        progress.say(
            arguments.output + ": " + grouped(made->voxels) + " voxels, " +
            grouped(made->allVoxels) + " in " + std::to_string(made->lattice.levels) +
            " levels of detail, " + grouped(made->chunks) + " chunks, " + grouped(bytes) +
            " bytes; " + brief(total) + " s");
        return 0;
    }
    Json json;
    json["output"] = arguments.output;
    json["format"] = arguments.format;
    json["bytes"] = bytes;
    json["scratch_bytes"] = made->scratchBytes;
    json["model"] = modelJson(model);
    if (source->key == "mesh")
        json["touched_voxels"] = made->touched;
    json["empty_regions"] = made->emptyRegions;
    json["bounds"] = boxJson(made->model.bounds);
    json[source->key] = source->describe(*made);
    json["seconds"] = {
        {"total", total},
        {"load", loadSeconds},
        {"voxelize", voxelizeSeconds},
        {"finish", total - loadSeconds - voxelizeSeconds}};
    json["peak_rss_bytes"] = core::peakResidentBytes();
    json["threads"] = jobs->concurrency();
    json["settings"] = {
        {"resolution", made->lattice.resolution},
        {"conservative", arguments.conservative},
        {"all_faces", arguments.allFaces}};
    json["warnings"] = warnings;
    print(json);
    return 0;
}

} // namespace

Action addVoxelize(CLI::App& app)
{
    auto arguments = std::make_shared<VoxelizeArguments>();
    CLI::App* command = app.add_subcommand(
        "voxelize",
        "Turn a mesh, a volume or a field into surface voxels of all levels of detail, chunk by "
        "chunk");
    arguments->command = command;
    addSource(*command, arguments->source)
        ->required()
        ->description(
            "a mesh: .glb .gltf .ply .obj .stl, gzipped or not; or what 'extract' takes: a volume, "
            "an elevation raster or proc:NAME[?key=value&...]");
    command
        ->add_option(
            "-o,--output", arguments->output, "model to write: a file, or with --format a folder")
        ->required();
    command
        ->add_option(
            "--resolution",
            arguments->field.resolution,
            "voxels along the longest edge of what there is; default: the voxels of a volume, the "
            "posts of an elevation raster")
        ->check(CLI::Range(1U, voxels::kMaxResolution));
    command
        ->add_option(
            "--isovalue",
            arguments->field.isovalue,
            "solid is where a field is at or above it; default: what separates a volume best")
        ->check(isovalues());
    command
        ->add_option(
            "--filter",
            arguments->field.filter,
            "strength of a field's low-pass filter: 0 none, 0.5 as views have it, 1 all that "
            "voxels can't hold")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    command->add_flag(
        "--closed",
        arguments->field.closed,
        "close a field's solid at the border of the data; otherwise its surface ends there");
    command->add_flag(
        "--conservative",
        arguments->conservative,
        "every voxel that is touched, about twice as many; otherwise the fewest that hide what "
        "lies behind");
    command->add_flag(
        "--all-faces",
        arguments->allFaces,
        "show both sides of every voxel, for models that a viewer may enter");
    command
        ->add_option(
            "--format", arguments->format, "'lmdb', one file, or 'folder', a file for each chunk")
        ->check(CLI::IsMember({"lmdb", "folder"}))
        ->capture_default_str();
    command->add_option(
        "--scratch",
        arguments->scratch,
        "folder for what waits between the passes, two to three times the model; default: where "
        "the model goes");
    command->add_option("--threads", arguments->threads, "0: one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    addSourceArguments(*command, arguments->input);
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer(
        "The same source and resolution give the same chunks with any number of threads.\n"
        "'isofront info MODEL' tells what was written.\n\n"
        "Examples:\n"
        "  isofront voxelize dragon.ply.gz --resolution 2048 -o dragon.voxels\n"
        "  isofront voxelize head.nrrd --isovalue 300 -o bone.voxels\n"
        "  isofront voxelize 'proc:terrain?preset=karst' --resolution 4096 -o karst.voxels\n"
        "  isofront voxelize city.obj --resolution 8192 --format folder -o city");
    return [arguments] { return voxelize(*arguments); };
}

} // namespace isofront::cli

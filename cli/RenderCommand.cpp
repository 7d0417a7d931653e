#include "Arguments.h"
#include "Console.h"
#include "FarField.h"
#include "ModelView.h"
#include "Pictures.h"
#include "SourceArguments.h"
#include "VoxelPicture.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/Png.h>
#include <isofront/render/HybridScene.h>
#include <isofront/voxels/ChunkStore.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <memory>
#include <optional>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

struct RenderArguments {
    std::string source;
    SourceArguments input;
    std::string output;
    std::optional<double> isovalue;
    std::string eye;
    std::string target;
    double fov = 45;
    std::string size = "1280x720";
    double pixelError = 2;
    int lattice = 8;
    double filter = extractor::ExtractionSettings{}.filterStrength;
    bool closed = false;
    MeshOptions mesh;
    DetailOptions detail;
    FarFieldOptions far;
    std::string up;
    double voxelPixels = 1;
    std::string way = "auto";
    SourceChoice sourceChoice;
    std::uint64_t cacheMib = 128;
    int samples = 1;
    std::string device;
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
    const CLI::App* command = nullptr; ///< that they came with
};

/// The same for a model of voxels, which is drawn without a surface.
int renderModel(const RenderArguments& arguments, const PictureSize& size)
{
    VoxelPictureRequest request{
        .model = arguments.source,
        .output = arguments.output,
        .fov = arguments.fov,
        .size = size,
        .voxelPixels = arguments.voxelPixels,
        .way = arguments.way,
        .cacheBytes = arguments.cacheMib << 20U,
        .samples = arguments.samples,
        .source = arguments.sourceChoice,
        .memoryLimit = memoryLimit(arguments.input),
        .device = arguments.device,
        .threads = arguments.threads,
        .json = arguments.json,
        .quiet = arguments.quiet};
    for (const auto& [text, point, name] :
         {std::tuple{&arguments.eye, &request.eye, "--eye"},
          std::tuple{&arguments.target, &request.target, "--target"}}) {
        if (text->empty())
            continue;
        const auto parsed = parsePoint(*text, name);
        if (!parsed)
            return report(parsed.error());
        *point = *parsed;
    }
    const auto up = parseUp(arguments.up);
    if (!up)
        return report(up.error());
    request.up = *up;
    return renderVoxels(request);
}

nlohmann::ordered_json farFieldJson(const voxels::ChunkStore& far, const render::HybridFrame& frame)
{
    nlohmann::ordered_json json;
    json["resolution"] = far.model().lattice.resolution;
    json["voxels_drawn"] = frame.drawn.voxels.voxels;
    json["chunks_drawn"] = frame.drawn.voxels.chunksDrawn;
    json["chunks_damaged"] = frame.damaged.size();
    json["chunk_bytes"] = frame.residentVoxelBytes;
    json["effective_voxel_pixels"] = frame.voxelPixels;
    json["mesh_blocks"] = frame.meshBlocks;
    json["voxel_blocks"] = frame.voxelBlocks;
    return json;
}

int render(const RenderArguments& arguments)
{
    const auto start = Clock::now();
    const std::stop_token stop = interruptions();
    Progress progress(arguments.quiet);

    const auto size = parseSize(arguments.size);
    if (!size)
        return report(size.error());
    if (const auto checked = checkPixelError(arguments.pixelError); !checked)
        return report(checked.error());
    const auto detail = arguments.detail.request();
    if (!detail)
        return report(detail.error());
    if (!arguments.output.ends_with(".png"))
        return report({ErrorCode::usage, arguments.output + ": pictures are written as .png"});
    if (const auto folder = checkFolderOf(arguments.output); !folder)
        return report(folder.error());
    if (voxels::isStore(arguments.source)) {
        const auto useful = checkOptions(
            *arguments.command,
            {"--output",
             "--eye",
             "--target",
             "--up",
             "--fov",
             "--size",
             "--msaa",
             "--voxel-pixels",
             "--way",
             "--cache-mib",
             kSourceOption,
             kNoSourceOption,
             "--memory-limit",
             "--device",
             "--threads",
             "--json",
             "--quiet"},
            "a voxel model");
        return useful ? renderModel(arguments, *size) : report(useful.error());
    }
    if (const auto useful = checkNoOptions(
            *arguments.command,
            {"--up", "--voxel-pixels", "--way", kSourceOption, kNoSourceOption},
            "what is no voxel model");
        !useful)
        return report(useful.error());
    if (!arguments.far.voxels)
        if (const auto useful = checkNoOptions(*arguments.command, {"--cache-mib"}, kWithoutVoxels);
            !useful)
            return report(useful.error());
    const auto farRequest = farFieldRequest(arguments.far);
    if (!farRequest)
        return report(farRequest.error());
    if (!extractor::VolumeMesh::isValidSize(arguments.lattice) || arguments.lattice < 4)
        return report(
            {ErrorCode::usage,
             "--lattice " + std::to_string(arguments.lattice) + ": it must be 4, 8 or 16"});

    progress.show("loading " + arguments.source, -1);
    auto source = openSource(arguments.source, arguments.input, stop);
    if (!source)
        return report(source.error());
    for (const std::string& note : source->notes)
        progress.say("note: " + note);
    for (const auto& [text, point, name] :
         {std::tuple{&arguments.eye, &source->eye, "--eye"},
          std::tuple{&arguments.target, &source->target, "--target"}}) {
        if (text->empty())
            continue;
        const auto parsed = parsePoint(*text, name);
        if (!parsed)
            return report(parsed.error());
        *point = *parsed;
    }
    const double isovalue = arguments.isovalue.value_or(source->defaultIsovalue);
    if (arguments.eye.empty() && source->volume)
        frameSurface(
            *source, isovalue, !arguments.target.empty(), arguments.fov, size->width, size->height);
    if (source->eye == source->target)
        return report({ErrorCode::usage, "--eye and --target must not be the same point"});

    auto studio = openStudio(
        *source,
        {.device = arguments.device,
         .width = size->width,
         .height = size->height,
         .samples = arguments.samples,
         .voxelBytes = arguments.cacheMib << 20U});
    if (!studio)
        return report(studio.error());

    if (!arguments.isovalue && source->volume)
        progress.say(isovalueNote(isovalue));
    const std::shared_ptr<core::Jobs> jobs =
        core::makeJobs(core::JobsBackend::automatic, arguments.threads);
    const surface::SurfaceOptions options = surfaceOptions(
        *source,
        isovalue,
        arguments.lattice,
        arguments.filter,
        arguments.pixelError,
        arguments.closed,
        arguments.mesh,
        *detail);
    surface::Surface surface(source->field, source->domain, options, jobs);
    const hierarchy::View view =
        viewTo(source->eye, source->target, arguments.fov, size->width, size->height, source->up);
    const render::HandOverSettings handOver{
        .pixels = arguments.far.handOver, .meshPixels = arguments.pixelError};
    std::shared_ptr<const voxels::ChunkStore> far;
    if (*farRequest) {
        auto opened = openFarField(
            **farRequest,
            *source,
            {.isovalue = isovalue,
             .filter = arguments.filter,
             .voxelFilter = arguments.filter * render::voxelFilterFactor(handOver),
             .closed = arguments.closed},
            *jobs,
            progress,
            stop);
        if (!opened)
            return report(opened.error());
        far = std::move(*opened);
    }
    auto scene = render::HybridScene::create(
        *studio->renderer,
        &surface,
        far,
        jobs,
        {.handOver = handOver,
         .pixelError = arguments.pixelError,
         .detail = options.detail,
         .latticeSize = arguments.lattice,
         .streaming = {.cacheBytes = arguments.cacheMib << 20U}});
    if (!scene)
        return report(far ? withCache(scene.error(), arguments.cacheMib << 20U) : scene.error());
    if (far) {
        const std::string note = coarseFarFieldNote(
            *scene->handOver(), far->model().lattice.resolution, source->worldBox, {&view, 1});
        if (!note.empty())
            progress.say(note);
    }
    const Clock::time_point settling = Clock::now();
    std::optional<EndedAtOnce> drawing(std::in_place, stop, kNoPicture);
    const auto frame = scene->settle(
        view, studio->scene, [&](double share) { progress.show("extracting", share); });
    if (!frame)
        return report(
            frame.error().code == ErrorCode::resourceLimit
                ? frame.error().within(
                      "the mesh doesn't fit on the device; choose a larger --pixel-error")
                : frame.error());
    const double extractSeconds =
        std::chrono::duration<double>(settling - start).count() + frame->surfaceMilliseconds / 1000;

    progress.show("drawing", -1);
    const auto image = studio->renderer->readImage();
    if (!image)
        return report(image.error());
    drawing.reset();
    if (stop.stop_requested())
        return report({ErrorCode::interrupted, kNoPicture});
    const auto written = exchange::writePng(*image, arguments.output);
    if (!written)
        return report(written.error());
    progress.finish();

    const surface::SurfaceStats stats = surface.stats();
    if (stats.triangles == 0)
        progress.say("warning: there is no surface at isovalue " + brief(isovalue));
    if (stats.sanitisedSamples > 0)
        progress.say(
            "warning: " + grouped(stats.sanitisedSamples) +
            " samples were not finite or huge; they were clamped, and NaN counts as outside");
    if (const std::string note = coarserNote(arguments.pixelError, stats.effectivePixelError);
        !note.empty())
        progress.say(note);
    for (const core::Error& error : frame->damaged)
        progress.say("warning: " + error.message + "; coarser voxels are shown in its place");
    if (!arguments.json) {
        progress.say(
            arguments.output + ": " + std::to_string(size->width) + "x" +
            std::to_string(size->height) + ", " + grouped(frame->drawn.triangles) + " of " +
            grouped(stats.triangles) + " triangles" +
            (far ? " and " + grouped(frame->drawn.voxels.voxels) + " voxels" : "") + " drawn by " +
            studio->device->description().name);
        return 0;
    }
    const auto point = [](const glm::dvec3& p) { return nlohmann::ordered_json{p.x, p.y, p.z}; };
    nlohmann::ordered_json json;
    json["output"] = arguments.output;
    json["size"] = {size->width, size->height};
    json["device"] = studio->device->description().name;
    json["isovalue"] = isovalue;
    json["eye"] = point(source->eye);
    json["target"] = point(source->target);
    json["msaa"] = arguments.samples;
    json["pixel_error"] = arguments.pixelError;
    json["effective_pixel_error"] = stats.effectivePixelError;
    json["triangles"] = stats.triangles;
    json["triangles_drawn"] = frame->drawn.triangles;
    json["cells"] = stats.frontCells;
    json["cells_extracted"] = stats.cellsExtracted;
    json["cells_skipped"] = stats.cellsSkipped;
    json["samples"] = stats.samples;
    json["sanitised_samples"] = stats.sanitisedSamples;
    json["mesh_bytes"] = stats.meshBytes;
    json["surface_bytes"] = stats.totalBytes;
    json["seconds"] = {
        {"total", std::chrono::duration<double>(Clock::now() - start).count()},
        {"extract", extractSeconds}};
    json["peak_rss_bytes"] = core::peakResidentBytes();
    json["threads"] = jobs->concurrency();
    json["far_field"] = far ? farFieldJson(*far, *frame) : nullptr;
    detail->describeDetail(json["settings"]);
    detail->describeCeilings(json["settings"]);
    print(json);
    return 0;
}

} // namespace

Action addRender(CLI::App& app)
{
    auto arguments = std::make_shared<RenderArguments>();
    CLI::App* command =
        app.add_subcommand("render", "Draw one picture of a source, at the detail its pixels need");
    arguments->command = command;
    addSource(*command, arguments->source)->required();
    command->add_option("-o,--output", arguments->output, "picture: .png")->required();
    command
        ->add_option(
            "--isovalue",
            arguments->isovalue,
            "solid is where the value is at or above it; default: what separates the volume best")
        ->check(isovalues());
    command->add_option("--eye", arguments->eye, "X,Y,Z [world]; default: a good place");
    command->add_option("--target", arguments->target, "X,Y,Z to look at [world]");
    command->add_option("--fov", arguments->fov, "vertical field of view [degrees]")
        ->check(within(1.0, 179.0))
        ->capture_default_str();
    command->add_option("--size", arguments->size, "[px]")->capture_default_str();
    addSamples(*command, arguments->samples);
    command->add_option("--pixel-error", arguments->pixelError, "expected error of the mesh [px]")
        ->capture_default_str();
    addVoxelOptions(*command, arguments->voxelPixels, arguments->way, arguments->up);
    arguments->sourceChoice.addTo(*command);
    addCacheOption(*command, arguments->cacheMib, "");
    arguments->far.addTo(*command);
    command->add_option("--lattice", arguments->lattice, "lattice segments of a cell: 4, 8 or 16")
        ->capture_default_str();
    command->add_option("--filter", arguments->filter, "strength of the low-pass filter")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    arguments->detail.addDetailTo(*command);
    arguments->detail.addCeilingsTo(*command);
    arguments->mesh.addTo(*command);
    command->add_flag("--closed", arguments->closed, "close the surface at the border of the data");
    command->add_option(
        "--device",
        arguments->device,
        "Vulkan device: an index, 'cpu', 'gpu' or part of its name; also ISOFRONT_DEVICE");
    arguments->input.detail = "natural";
    addSourceArguments(*command, arguments->input);
    command->add_option("--threads", arguments->threads, "0: one for each core")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer("Examples:\n"
                    "  isofront render head.nrrd --isovalue 300 -o bone.png\n"
                    "  isofront render dragon.voxels -o dragon.png\n"
                    "  isofront render N44W072.hgt -o mountains.png\n"
                    "  isofront render 'proc:terrain?preset=islands&seed=4' -o islands.png");
    return [arguments] { return render(*arguments); };
}

} // namespace isofront::cli

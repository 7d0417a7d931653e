#include "FlightStage.h"

#include "Arguments.h"
#include "FarField.h"
#include "Flight.h"
#include "ModelView.h"

#include <isofront/voxels/ChunkStore.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace isofront::cli {

namespace {

using core::ErrorCode;

constexpr int kShadowInterval = 8; // frames

StudioOptions studioOptions(const FlyArguments& arguments, const PictureSize& size)
{
    StudioOptions options;
    options.device = arguments.device;
    options.width = size.width;
    options.height = size.height;
    options.samples = arguments.samples;
    // Shadows that are some frames old would change the picture, too.
    options.shadowInterval = arguments.measurePopping ? 1 : kShadowInterval;
    options.voxelBytes = arguments.cacheMib << 20U;
    return options;
}

FlightPlan planOf(const FlyArguments& arguments, const PictureSize& size)
{
    return {
        .frames = arguments.frames,
        .framesPerSecond = kFramesPerSecond,
        .speed = arguments.speed,
        .fovDegrees = arguments.fov,
        .width = size.width,
        .height = size.height};
}

/// The device's memory for voxels, as it is: drivers may allow less than was asked for.
core::Result<void> noteCache(FlightStage& stage)
{
    const auto bytes = stage.studio.renderer->chunkCacheBytes();
    if (!bytes)
        return tl::unexpected(bytes.error());
    stage.cacheBytes = *bytes;
    return {};
}

/// What the report says of any flight.
void describe(FlightStage& stage, const FlyArguments& arguments, const PictureSize& size)
{
    FlightSettings& settings = stage.settings;
    const gpu::DeviceDescription& device = stage.studio.device->description();
    settings.width = size.width;
    settings.height = size.height;
    settings.pixelError = std::numeric_limits<double>::quiet_NaN();
    settings.device = device.name;
    settings.threads = static_cast<int>(stage.jobs->concurrency());
    settings.versions = {
        {"isofront", ISOFRONT_VERSION}, {"driver", device.driver}, {"vulkan", device.apiVersion}};
    settings.others = {
        {"msaa", std::to_string(arguments.samples)}, {"fade_seconds", brief(arguments.fade)}};
}

void describeField(
    FlightSettings& settings, const FlyArguments& arguments, const DetailRequest& detail)
{
    settings.pixelError = arguments.pixelError;
    settings.preset = arguments.source.empty() ? arguments.preset : "";
    settings.seed = arguments.source.empty() ? arguments.seed : 0;
    auto& others = settings.others;
    others.emplace_back("lattice", std::to_string(arguments.lattice));
    others.emplace_back("filter", brief(arguments.filter));
    others.emplace_back("update_milliseconds", brief(arguments.updateMilliseconds));
    if (arguments.far.voxels) {
        others.emplace_back("far_voxels", *arguments.far.voxels);
        others.emplace_back("hand_over_pixels", brief(arguments.far.handOver));
        others.emplace_back("cache_mib", std::to_string(arguments.cacheMib));
    }
    nlohmann::ordered_json json;
    arguments.mesh.describe(json);
    detail.describeDetail(json);
    detail.describeCeilings(json);
    for (const auto& [key, value] : json.items())
        others.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
}

core::Result<void> checkField(const FlyArguments& arguments)
{
    if (const auto useful = checkNoOptions(
            *arguments.command,
            {"--up", "--voxel-pixels", "--way", kSourceOption, kNoSourceOption},
            "what is no voxel model");
        !useful)
        return useful;
    if (!arguments.far.voxels) {
        if (const auto useful = checkNoOptions(*arguments.command, {"--cache-mib"}, kWithoutVoxels);
            !useful)
            return useful;
    }
    if (const auto checked = checkPixelError(arguments.pixelError); !checked)
        return checked;
    if (!extractor::VolumeMesh::isValidSize(arguments.lattice) || arguments.lattice < 4)
        return core::failure(
            ErrorCode::usage,
            "--lattice " + std::to_string(arguments.lattice) + ": it must be 4, 8 or 16");
    return {};
}

core::Result<FlightStage> stageOfField(
    const FlyArguments& arguments,
    const PictureSize& size,
    Progress& progress,
    const std::stop_token& stop)
{
    if (const auto checked = checkField(arguments); !checked)
        return tl::unexpected(checked.error());
    const auto detail = arguments.detail.request();
    if (!detail)
        return tl::unexpected(detail.error());
    const auto farRequest = farFieldRequest(arguments.far);
    if (!farRequest)
        return tl::unexpected(farRequest.error());
    const std::string text =
        !arguments.source.empty()
            ? arguments.source
            : "proc:terrain?preset=" + arguments.preset + "&seed=" + std::to_string(arguments.seed);
    auto opened = openSource(text, arguments.input, stop);
    if (!opened)
        return tl::unexpected(opened.error());
    Source& source = *opened;
    for (const std::string& note : source.notes)
        progress.say("note: " + note);
    const double isovalue = arguments.isovalue.value_or(source.defaultIsovalue);
    if (source.volume) {
        if (!arguments.isovalue)
            progress.say(isovalueNote(isovalue));
        frameSurface(source, isovalue, false, arguments.fov, size.width, size.height);
    }

    FlightStage stage;
    auto studio = openStudio(source, studioOptions(arguments, size));
    if (!studio)
        return tl::unexpected(studio.error());
    stage.studio = std::move(*studio);
    stage.jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);
    const surface::SurfaceOptions options = surfaceOptions(
        source,
        isovalue,
        arguments.lattice,
        arguments.filter,
        arguments.pixelError,
        false,
        arguments.mesh,
        *detail);
    stage.surface =
        std::make_unique<surface::Surface>(source.field, source.domain, options, stage.jobs);
    const render::HandOverSettings handOver{
        .pixels = arguments.far.handOver, .meshPixels = arguments.pixelError};
    std::shared_ptr<const voxels::ChunkStore> far;
    if (*farRequest) {
        auto made = openFarField(
            **farRequest,
            source,
            {.isovalue = isovalue,
             .filter = arguments.filter,
             .voxelFilter = arguments.filter * render::voxelFilterFactor(handOver)},
            *stage.jobs,
            progress,
            stop);
        if (!made)
            return tl::unexpected(made.error());
        far = std::move(*made);
    }
    auto scene = render::HybridScene::create(
        *stage.studio.renderer,
        stage.surface.get(),
        far,
        stage.jobs,
        {.handOver = handOver,
         .transitionSeconds = arguments.fade,
         .pixelError = arguments.pixelError,
         .detail = options.detail,
         .latticeSize = arguments.lattice,
         .updateMilliseconds = arguments.updateMilliseconds,
         .streaming = {.cacheBytes = arguments.cacheMib << 20U}});
    if (!scene)
        return tl::unexpected(
            far ? withCache(scene.error(), arguments.cacheMib << 20U) : scene.error());
    stage.scene.emplace(std::move(*scene));
    if (far) {
        stage.voxelPixels = std::min(
            voxels::StreamingSettings{}.voxelPixels, arguments.far.handOver / render::kVoxelError);
        if (const auto known = noteCache(stage); !known)
            return tl::unexpected(known.error());
    }
    progress.show("finding a way", -1);
    stage.views = flightPath(source, planOf(arguments, size));
    if (far) {
        const std::string note = coarseFarFieldNote(
            *stage.scene->handOver(),
            far->model().lattice.resolution,
            source.worldBox,
            stage.views);
        if (!note.empty())
            progress.say(note);
    }
    describe(stage, arguments, size);
    stage.settings.source = source.name;
    describeField(stage.settings, arguments, *detail);
    return stage;
}

core::Result<FlightStage> stageOfModel(const FlyArguments& arguments, const PictureSize& size)
{
    if (const auto useful = checkOptions(
            *arguments.command,
            {"--frames",
             "--speed",
             "--fov",
             "--size",
             "--msaa",
             "--fade",
             "--measure-popping",
             "--voxel-pixels",
             "--way",
             "--up",
             kSourceOption,
             kNoSourceOption,
             "--cache-mib",
             "--memory-limit",
             "--out",
             "--device",
             "--threads",
             "--json",
             "--quiet"},
            "a voxel model");
        !useful)
        return tl::unexpected(useful.error());
    const auto up = parseUp(arguments.up);
    if (!up)
        return tl::unexpected(up.error());
    const auto model = openModel(arguments.source, *up);
    if (!model)
        return tl::unexpected(model.error());

    FlightStage stage;
    auto source =
        sourceOf(*model, arguments.source, arguments.sourceChoice, memoryLimit(arguments.input));
    if (!source)
        return tl::unexpected(source.error());
    StudioOptions options = studioOptions(arguments, size);
    options.hasSource = source->read != nullptr;
    auto studio = openStudio(*model, options);
    if (!studio)
        return tl::unexpected(withCache(studio.error(), options.voxelBytes));
    stage.studio = std::move(*studio);
    stage.jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);
    auto scene = render::HybridScene::create(
        *stage.studio.renderer,
        nullptr,
        model->store,
        stage.jobs,
        {.transitionSeconds = arguments.fade,
         .streaming =
             {.voxelPixels = arguments.voxelPixels, .cacheBytes = arguments.cacheMib << 20U},
         .way = voxelWay(arguments.way),
         .source = std::move(source->read)});
    if (!scene)
        return tl::unexpected(withCache(scene.error(), options.voxelBytes));
    stage.scene.emplace(std::move(*scene));
    if (const auto known = noteCache(stage); !known)
        return tl::unexpected(known.error());
    auto views = flightPath(*model, planOf(arguments, size));
    if (!views)
        return tl::unexpected(views.error());
    stage.views = std::move(*views);
    stage.voxelPixels = arguments.voxelPixels;
    describe(stage, arguments, size);
    stage.settings.source = arguments.source;
    auto& others = stage.settings.others;
    others.emplace_back("model", model->store->model().name);
    others.emplace_back("resolution", std::to_string(model->store->model().lattice.resolution));
    others.emplace_back("voxel_pixels", brief(arguments.voxelPixels));
    others.emplace_back("way", arguments.way);
    others.emplace_back("source", options.hasSource ? source->file.string() : "none");
    if (options.hasSource)
        stage.sourceFile = source->file;
    others.emplace_back("cache_mib", std::to_string(arguments.cacheMib));
    return stage;
}

} // namespace

core::Result<FlightStage>
stageOf(const FlyArguments& arguments, Progress& progress, const std::stop_token& stop)
{
    const auto size = parseSize(arguments.size);
    if (!size)
        return tl::unexpected(size.error());
    if (arguments.window)
        return core::failure(
            ErrorCode::usage,
            "--window: this version flies without a window; leave it out and watch the video");
    return voxels::isStore(arguments.source) ? stageOfModel(arguments, *size)
                                             : stageOfField(arguments, *size, progress, stop);
}

} // namespace isofront::cli

#include "VoxelPicture.h"

#include "Console.h"
#include "ModelView.h"
#include "Pictures.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/Png.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/ChunkStreamer.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

/// The last picture, and what led to it.
struct Picture {
    render::FrameStats stats;
    std::size_t frames = 0;
    std::uint64_t uploadedBytes = 0;
    std::uint64_t residentBytes = 0;
    double coarsening = 1;
    std::vector<core::Error> damaged;
    double loadSeconds = 0;
    double gpuMilliseconds = 0;
    render::HybridFrame source; ///< where the model's source is shown
};

core::Result<double> gpuMilliseconds(render::Renderer& renderer)
{
    const auto passes = renderer.finish();
    if (!passes)
        return tl::unexpected(passes.error());
    double sum = 0;
    for (const render::PassTime& pass : *passes)
        sum += pass.milliseconds;
    return sum;
}

/// Draws until all that the view needs is there.
core::Result<Picture> drawComplete(
    Studio& studio,
    voxels::ChunkStreamer& streamer,
    const hierarchy::View& view,
    const render::VoxelScene& how,
    Progress& progress)
{
    const auto start = Clock::now();
    const double near = studio.renderer->defaultNearPlane();
    const voxels::ChunkView chunkView = voxels::perspectiveView(
        view.eye, view.forward, view.up, view.verticalFieldOfView, view.width, view.height, near);
    Picture picture;
    bool wasComplete = false;
    for (;;) {
        const auto completed = studio.renderer->completedFrame();
        if (!completed)
            return tl::unexpected(completed.error());
        ++picture.frames;
        const voxels::ChunkFrame& frame = streamer.update(chunkView, picture.frames, *completed);
        const auto applied = studio.renderer->apply(frame);
        if (!applied)
            return tl::unexpected(applied.error());
        picture.uploadedBytes += *applied;
        picture.residentBytes = frame.residentBytes;
        picture.coarsening = frame.coarsening;
        picture.damaged.insert(picture.damaged.end(), frame.damaged.begin(), frame.damaged.end());
        progress.show(
            "loading",
            static_cast<double>(frame.residentBytes) /
                static_cast<double>(std::max(frame.wantedBytes, frame.residentBytes) + 1));
        if (frame.isComplete && !wasComplete)
            picture.loadSeconds = std::chrono::duration<double>(Clock::now() - start).count();
        // Frames on the way are drawn too: what they use may only be freed when they are done.
        render::VoxelScene scene = how;
        scene.placed = frame.draws;
        scene.frame = picture.frames;
        // Nobody sees them: they need no shadows.
        render::Scene look = studio.scene;
        look.shadowDistance = frame.isComplete ? look.shadowDistance : 0;
        if (const auto sun = studio.renderer->sunlight(view, look))
            scene.casters = streamer.casters(sun->space, sun->texel);
        auto drawn = studio.renderer->draw(view, look, scene);
        if (!drawn)
            return tl::unexpected(drawn.error());
        picture.stats = *drawn;
        const auto milliseconds = gpuMilliseconds(*studio.renderer);
        if (!milliseconds)
            return tl::unexpected(milliseconds.error());
        picture.gpuMilliseconds = *milliseconds;
        // Once more: the first time, drivers still compile.
        if (frame.isComplete && wasComplete)
            return picture;
        wasComplete = frame.isComplete;
        if (!wasComplete)
            streamer.waitForChunks();
    }
}

/// The same with the model's source where voxels are too large.
core::Result<Picture> drawWithSource(
    Studio& studio,
    const ShownModel& model,
    const render::HybridSettings& settings,
    const std::shared_ptr<core::Jobs>& jobs,
    const hierarchy::View& view)
{
    const auto start = Clock::now();
    auto scene =
        render::HybridScene::create(*studio.renderer, nullptr, model.store, jobs, settings);
    if (!scene)
        return tl::unexpected(scene.error());
    const auto settled = scene->settle(view, studio.scene);
    if (!settled)
        return tl::unexpected(settled.error());
    Picture picture;
    picture.loadSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    // Once more: the first time, drivers still compile.
    const auto drawn = scene->redraw(view, studio.scene);
    if (!drawn)
        return tl::unexpected(drawn.error());
    picture.stats = *drawn;
    picture.frames = settled->number + 1;
    picture.uploadedBytes = settled->residentVoxelBytes + settled->meshes.uploadedBytes;
    picture.residentBytes = settled->residentVoxelBytes;
    picture.coarsening = settled->coarsening;
    picture.damaged = settled->damaged;
    picture.source = *settled;
    const auto milliseconds = gpuMilliseconds(*studio.renderer);
    if (!milliseconds)
        return tl::unexpected(milliseconds.error());
    picture.gpuMilliseconds = *milliseconds;
    return picture;
}

void printJson(
    const VoxelPictureRequest& request,
    const voxels::StoredModel& model,
    const hierarchy::View& view,
    const Studio& studio,
    const Picture& picture,
    const ShownSource& source,
    double seconds)
{
    const render::VoxelStats& voxels = picture.stats.voxels;
    const auto point = [](const glm::dvec3& p) { return nlohmann::ordered_json{p.x, p.y, p.z}; };
    nlohmann::ordered_json json;
    json["output"] = request.output;
    json["size"] = {request.size.width, request.size.height};
    json["device"] = studio.device->description().name;
    json["model"] = model.name;
    json["resolution"] = model.lattice.resolution;
    json["eye"] = point(view.eye);
    json["target"] = point(view.eye + view.forward);
    json["msaa"] = request.samples;
    json["voxel_pixels"] = request.voxelPixels;
    json["effective_voxel_pixels"] = request.voxelPixels * picture.coarsening;
    json["way"] = request.way;
    json["voxels_drawn"] = voxels.voxels;
    json["voxels_splatted"] = voxels.splatted;
    json["voxels_casting_shadows"] = voxels.shadowVoxels;
    json["chunks_drawn"] = voxels.chunksDrawn;
    json["chunks_damaged"] = picture.damaged.size();
    json["chunk_bytes"] = picture.residentBytes;
    json["source"] = sourceJson(source, picture.source);
    json["uploaded_bytes"] = picture.uploadedBytes;
    json["device_bytes"] = picture.stats.deviceBytes;
    json["frames"] = picture.frames;
    json["frame_milliseconds"] = {
        {"cpu", picture.stats.cpuMilliseconds}, {"gpu", picture.gpuMilliseconds}};
    json["seconds"] = {{"total", seconds}, {"load", picture.loadSeconds}};
    json["peak_rss_bytes"] = core::peakResidentBytes();
    print(json);
}

} // namespace

int renderVoxels(const VoxelPictureRequest& request)
{
    const auto start = Clock::now();
    const std::stop_token stop = interruptions();
    Progress progress(request.quiet);
    const auto opened = openModel(request.model, request.up);
    if (!opened)
        return report(opened.error());
    const ShownModel& shown = *opened;
    const voxels::StoredModel model = shown.store->model();
    const glm::dvec3 target = request.target.value_or(shown.box.centre());
    const glm::dvec3 eye = request.eye.value_or(placeBefore(
        shown.box,
        target,
        forwardTo(shown),
        shown.up,
        request.fov,
        request.size.width,
        request.size.height));
    if (eye == target)
        return report({ErrorCode::usage, "--eye and --target must not be the same point"});
    const hierarchy::View view =
        viewTo(eye, target, request.fov, request.size.width, request.size.height, shown.up);

    const auto source = sourceOf(shown, request.model, request.source, request.memoryLimit);
    if (!source)
        return report(source.error());
    const bool usesSource = source->read && needsSource(shown, view, request.voxelPixels);
    auto opening = openStudio(
        shown,
        {.hasSource = usesSource,
         .device = request.device,
         .width = request.size.width,
         .height = request.size.height,
         .samples = request.samples,
         .voxelBytes = request.cacheBytes});
    if (!opening)
        return report(withCache(opening.error(), request.cacheBytes));
    Studio studio = std::move(*opening);
    studio.scene.shadowDistance = shadowDistance(shown, eye);
    const auto cacheBytes = studio.renderer->chunkCacheBytes();
    if (!cacheBytes)
        return report(cacheBytes.error());
    constexpr std::uint64_t kAll = std::uint64_t{1} << 32U;
    const voxels::StreamingSettings streaming{
        .voxelPixels = request.voxelPixels,
        .occlusion = false,
        .cacheBytes = *cacheBytes,
        .uploadBytes = kAll};
    const std::shared_ptr<core::Jobs> jobs =
        core::makeJobs(core::JobsBackend::automatic, request.threads);
    const auto draw = [&]() -> core::Result<Picture> {
        if (usesSource) {
            progress.show("loading", -1);
            render::HybridSettings settings;
            settings.handOver.hysteresis = 1;
            settings.streaming = streaming;
            settings.way = voxelWay(request.way);
            settings.source = source->read;
            return drawWithSource(studio, shown, settings, jobs, view);
        }
        auto streamer = voxels::ChunkStreamer::create(shown.store, streaming, jobs);
        if (!streamer)
            return tl::unexpected(streamer.error());
        render::VoxelScene how;
        how.lattice = model.lattice;
        how.tree = &(*streamer)->tree();
        how.way = voxelWay(request.way);
        return drawComplete(studio, **streamer, view, how, progress);
    };
    std::optional<EndedAtOnce> drawing(std::in_place, stop, kNoPicture);
    const auto picture = draw();
    if (!picture)
        return report(withCache(picture.error(), request.cacheBytes));
    const auto image = studio.renderer->readImage();
    if (!image)
        return report(image.error());
    drawing.reset();
    if (stop.stop_requested())
        return report({ErrorCode::interrupted, kNoPicture});
    const auto written = exchange::writePng(*image, request.output);
    if (!written)
        return report(written.error());
    progress.finish();
    for (const core::Error& error : picture->damaged)
        progress.say("warning: " + error.message + "; coarser voxels are shown in its place");
    if (const std::string note = coarserVoxelsNote(
            request.voxelPixels, request.voxelPixels * picture->coarsening, *cacheBytes);
        !note.empty())
        progress.say(note);
    if (const std::string note = sourceNote(picture->source); !note.empty())
        progress.say(note);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (request.json)
        printJson(request, model, view, studio, *picture, *source, seconds);
    else
        progress.say(
            request.output + ": " + std::to_string(request.size.width) + "x" +
            std::to_string(request.size.height) + ", " + grouped(picture->stats.voxels.voxels) +
            " voxels" +
            (usesSource ? " and " + grouped(picture->stats.triangles) + " triangles" : "") +
            " drawn by " + studio.device->description().name);
    return 0;
}

} // namespace isofront::cli

#include "VoxelPicture.h"

#include "Console.h"
#include "Pictures.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/ModelFile.h>
#include <isofront/exchange/Png.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/ChunkStreamer.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

/// Models have y up; scans, landscapes and formulas z.
bool isUpright(const voxels::StoredModel& model)
{
    return exchange::isModelName(model.name) || model.name.ends_with(".vdb");
}

glm::dvec3 upOf(const VoxelPictureRequest& request, const voxels::StoredModel& model)
{
    if (request.up)
        return glm::normalize(*request.up);
    return isUpright(model) ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
}

/// Towards the front, from the right and from above.
glm::dvec3 forwardOf(const glm::dvec3& up)
{
    const glm::dvec3 front = up.y > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, -1, 0);
    return -glm::normalize(front + 0.45 * glm::cross(up, front) + 0.4 * up);
}

bool isLandscape(const std::string& name)
{
    return name.starts_with("proc:terrain");
}

/// Landscapes get their own light and ground, all else is an object before a wall.
void dress(render::Scene& scene, const std::string& name, const glm::dvec3& up)
{
    scene.up = up;
    scene.look = render::Look::studio;
    if (!isLandscape(name))
        return;
    scene.look = render::Look::terrain;
    const std::string_view key = "preset=";
    const std::size_t preset = name.find(key);
    if (preset != std::string::npos) {
        const std::string kind = name.substr(preset + key.size());
        scene.terrain = render::terrainLook(kind.substr(0, kind.find('&')));
    }
}

/// So far that the sun's map covers all that a view shows of a box [world].
double shadowDistance(const core::Box& box, const glm::dvec3& eye)
{
    const glm::dvec3 farthest = glm::max(glm::abs(box.low - eye), glm::abs(box.high - eye));
    return 1.1 * glm::length(farthest); // it is a square, most of which lies before the eye
}

/// A cube around a box, for the renderer: it sets the near plane.
hierarchy::Domain domainAround(const core::Box& box)
{
    const glm::dvec3 size = box.size();
    return {.origin = box.low, .edge = std::max({size.x, size.y, size.z})};
}

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
};

/// Draws until all that the view needs is there.
core::Result<Picture> drawComplete(
    Studio& studio,
    voxels::ChunkStreamer& streamer,
    const hierarchy::View& view,
    const render::VoxelScene& how,
    Progress& progress,
    const std::stop_token& stop)
{
    const auto start = Clock::now();
    const double near = studio.renderer->defaultNearPlane();
    const voxels::ChunkView chunkView = voxels::perspectiveView(
        view.eye, view.forward, view.up, view.verticalFieldOfView, view.width, view.height, near);
    Picture picture;
    bool wasComplete = false;
    for (;;) {
        if (stop.stop_requested())
            return core::failure(ErrorCode::interrupted, "interrupted; no picture was written");
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
        const auto passes = studio.renderer->finish();
        if (!passes)
            return tl::unexpected(passes.error());
        picture.gpuMilliseconds = 0;
        for (const render::PassTime& pass : *passes)
            picture.gpuMilliseconds += pass.milliseconds;
        // Once more: the first time, drivers still compile.
        if (frame.isComplete && wasComplete)
            return picture;
        wasComplete = frame.isComplete;
        if (!wasComplete)
            streamer.waitForChunks();
    }
}

void printJson(
    const VoxelPictureRequest& request,
    const voxels::StoredModel& model,
    const hierarchy::View& view,
    const Studio& studio,
    const Picture& picture,
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
    auto opened = voxels::openAnyStore(request.model);
    if (!opened)
        return report(opened.error());
    const std::shared_ptr<const voxels::ChunkStore> store = std::move(*opened);
    const voxels::StoredModel model = store->model();
    const auto box = voxels::worldBox(*store);
    if (!box)
        return report(box.error());
    if (box->isEmpty())
        return report({ErrorCode::badData, request.model.string() + ": the model has no voxels"});
    const glm::dvec3 up = upOf(request, model);
    const glm::dvec3 target = request.target.value_or(box->centre());
    const glm::dvec3 eye = request.eye.value_or(placeBefore(
        *box, target, forwardOf(up), up, request.fov, request.size.width, request.size.height));
    if (eye == target)
        return report({ErrorCode::usage, "--eye and --target must not be the same point"});
    const hierarchy::View view =
        viewTo(eye, target, request.fov, request.size.width, request.size.height, up);

    auto device = gpu::Device::create({.device = request.device});
    if (!device)
        return report(device.error());
    Studio studio;
    studio.device = std::move(*device);
    constexpr std::uint32_t kNoMeshes = 1U << 16U; // [bytes]
    auto renderer = render::Renderer::create(
        *studio.device,
        domainAround(*box),
        {.width = request.size.width,
         .height = request.size.height,
         .poolBytes = 2ULL * kNoMeshes,
         .slabBytes = kNoMeshes,
         .samples = request.samples,
         .shadowMapSize = isLandscape(model.name) ? 2048 : 16,
         .voxelPoolBytes = request.cacheBytes});
    if (!renderer)
        return report(renderer.error());
    studio.renderer = std::move(*renderer);
    dress(studio.scene, model.name, up);
    studio.scene.shadowDistance = shadowDistance(*box, eye);
    const auto cacheBytes = studio.renderer->chunkCacheBytes();
    if (!cacheBytes)
        return report(cacheBytes.error());
    constexpr std::uint64_t kAll = std::uint64_t{1} << 32U;
    auto streamer = voxels::ChunkStreamer::create(
        store,
        {.voxelPixels = request.voxelPixels,
         .occlusion = false,
         .cacheBytes = *cacheBytes,
         .uploadBytes = kAll},
        core::makeJobs(core::JobsBackend::automatic, request.threads));
    if (!streamer)
        return report(streamer.error());

    render::VoxelScene how;
    how.lattice = model.lattice;
    how.tree = &(*streamer)->tree();
    how.way = request.way == "cubes"    ? render::VoxelWay::cubes
              : request.way == "splats" ? render::VoxelWay::splats
                                        : render::VoxelWay::automatic;
    const auto picture = drawComplete(studio, **streamer, view, how, progress, stop);
    if (!picture)
        return report(picture.error());
    const auto image = studio.renderer->readImage();
    if (!image)
        return report(image.error());
    const auto written = exchange::writePng(*image, request.output);
    if (!written)
        return report(written.error());
    progress.finish();
    for (const core::Error& error : picture->damaged)
        progress.say("warning: " + error.message + "; coarser voxels are shown in its place");
    if (picture->coarsening > 1)
        progress.say(
            "note: voxels are up to " + brief(request.voxelPixels * picture->coarsening) +
            " px large, because " + grouped(*cacheBytes >> 20U) +
            " MiB hold no more (see --cache-mib)");
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (request.json)
        printJson(request, model, view, studio, *picture, seconds);
    else
        progress.say(
            request.output + ": " + std::to_string(request.size.width) + "x" +
            std::to_string(request.size.height) + ", " + grouped(picture->stats.voxels.voxels) +
            " voxels drawn by " + studio.device->description().name);
    return 0;
}

} // namespace isofront::cli

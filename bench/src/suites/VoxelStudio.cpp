#include "VoxelStudio.h"

#include "Models.h"
#include "isofront/bench/Timing.h"

#include <isofront/gpu/Device.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace isofront::bench {

core::Result<std::unique_ptr<VoxelStudio>>
VoxelStudio::create(std::shared_ptr<const voxels::ChunkStore> store, const Settings& settings)
{
    const auto box = voxels::worldBox(*store);
    if (!box)
        return tl::unexpected(box.error());
    auto device = gpu::Device::create();
    if (!device)
        return tl::unexpected(device.error());
    std::unique_ptr<VoxelStudio> studio(new VoxelStudio);
    studio->_settings = settings;
    studio->_device = std::move(*device);
    constexpr std::uint32_t kNoMeshes = 1U << 16U; // [bytes]
    const glm::dvec3 size = box->size();
    auto renderer = render::Renderer::create(
        *studio->_device,
        {.origin = box->low, .edge = std::max({size.x, size.y, size.z})},
        {.width = settings.width,
         .height = settings.height,
         .poolBytes = 2ULL * kNoMeshes,
         .slabBytes = kNoMeshes,
         .samples = settings.samples,
         .shadowMapSize = 16,
         .voxelPoolBytes = settings.poolBytes});
    if (!renderer)
        return tl::unexpected(renderer.error());
    studio->_renderer = std::move(*renderer);
    const auto cacheBytes = studio->_renderer->chunkCacheBytes();
    if (!cacheBytes)
        return tl::unexpected(cacheBytes.error());
    voxels::StreamingSettings streaming = settings.streaming;
    streaming.cacheBytes = *cacheBytes;
    streaming.hostBytes = *cacheBytes;
    streaming.uploadBytes = settings.uploadBytes != 0 ? settings.uploadBytes : *cacheBytes;
    studio->_loading = std::make_shared<WaitingJobs>();
    studio->_lattice = store->model().lattice;
    auto streamer = voxels::ChunkStreamer::create(std::move(store), streaming, studio->_loading);
    if (!streamer)
        return tl::unexpected(streamer.error());
    studio->_streamer = std::move(*streamer);
    studio->_scene.look = render::Look::studio;
    studio->_scene.up = settings.up;
    studio->_scene.antialias = settings.antialias;
    return studio;
}

VoxelStudio::~VoxelStudio()
{
    if (_loading)
        _loading->wait(); // or the streamer would, for good
}

hierarchy::View
VoxelStudio::view(const glm::dvec3& eye, const glm::dvec3& target, double fieldOfView) const
{
    return {
        .eye = eye,
        .forward = target - eye,
        .up = _settings.up,
        .verticalFieldOfView = fieldOfView,
        .width = _settings.width,
        .height = _settings.height};
}

core::Result<StudioFrame> VoxelStudio::next(const hierarchy::View& view)
{
    _loading->wait();
    StudioFrame result;
    std::optional<core::Error> failure;
    const Timing timing = timed(
        [&] {
            const auto sights = _renderer->takeSights();
            const auto completed = _renderer->completedFrame();
            if (!sights || !completed) {
                failure = !sights ? sights.error() : completed.error();
                return;
            }
            std::vector<voxels::Visibility> seen;
            for (const render::FrameSight& sight : *sights)
                seen.push_back({.frame = sight.frame, .visible = sight.visible});
            const voxels::ChunkView chunkView = voxels::perspectiveView(
                view.eye,
                view.forward,
                view.up,
                view.verticalFieldOfView,
                view.width,
                view.height,
                _renderer->defaultNearPlane());
            ++_frame;
            const voxels::ChunkFrame* frame = nullptr;
            result.update =
                timed([&] { frame = &_streamer->update(chunkView, _frame, *completed, seen); }, 1)
                    .least;
            const auto applied = _renderer->apply(*frame);
            const auto drawn = applied ? _renderer->draw(
                                             view,
                                             _scene,
                                             {.lattice = _lattice,
                                              .placed = frame->draws,
                                              .tree = &_streamer->tree(),
                                              .frame = _frame,
                                              .way = _settings.way})
                                       : tl::unexpected(applied.error());
            if (!drawn) {
                failure = drawn.error();
                return;
            }
            const auto passes = _renderer->finish();
            if (!passes) {
                failure = passes.error();
                return;
            }
            for (const render::PassTime& pass : *passes)
                result.gpu += 1e-3 * pass.milliseconds;
            result.chunks = frame->opaque;
            result.tests = frame->draws.size() - frame->opaque;
            result.voxels = drawn->voxels.voxels;
            result.uploadBytes = frame->uploadBytes;
            result.residentBytes = frame->residentBytes;
            result.wantedBytes = frame->wantedBytes;
            result.missing = frame->missing;
            result.coarsening = frame->coarsening;
            result.isComplete = frame->isComplete;
        },
        1);
    if (failure)
        return tl::unexpected(*failure);
    result.wall = timing.wall;
    result.cpu = timing.least;
    return result;
}

core::Result<StudioFrame> VoxelStudio::settle(const hierarchy::View& view)
{
    constexpr int kMostFrames = 200;
    constexpr int kQuietFrames = 8; // hiding climbs a level a frame
    StudioFrame last;
    for (int i = 0, quiet = 0; i < kMostFrames && quiet < kQuietFrames; ++i) {
        const auto frame = next(view);
        if (!frame)
            return frame;
        const bool isSame = frame->isComplete && frame->chunks == last.chunks &&
                            frame->tests == last.tests && frame->voxels == last.voxels;
        quiet = isSame ? quiet + 1 : 0;
        last = *frame;
    }
    return last;
}

std::string VoxelStudio::deviceName() const
{
    return _device->description().name;
}

} // namespace isofront::bench

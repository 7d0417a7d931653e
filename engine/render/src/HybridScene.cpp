#include "isofront/render/HybridScene.h"

#include "SourceStream.h"
#include "isofront/render/TransitionClock.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <utility>

namespace isofront::render {

namespace {

using Clock = std::chrono::steady_clock;

/// Share of the hand-over's distance within which chunks need not be loaded.
constexpr double kSurelyMeshes = 0.8;
/// The reach of the surface follows what it should be when it is so many times off.
constexpr double kReachStep = 1.05;
/// Share of the renderer's pool that a source may have: the rest is for ranges that don't fit, and
/// where things fade, for what is on its way out.
constexpr double kSourceShare = 0.75;

/// The scene as a transition has it. What casts shadows changes only where one begins, and shadows
/// are drawn anew then: in between, new ones would come at once.
Scene faded(const Scene& scene, float weight)
{
    Scene shown = scene;
    shown.transition = weight;
    if (weight < 1)
        shown.shadowInterval = std::numeric_limits<int>::max();
    return shown;
}

double millisecondsSince(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

} // namespace

struct HybridScene::Parts {
    Renderer* renderer;
    surface::Surface* surface;
    std::shared_ptr<const voxels::ChunkStore> model;
    HybridSettings settings;
    TransitionClock clock;
    std::unique_ptr<voxels::ChunkStreamer> streamer;
    std::optional<HandOver> handOver;
    std::unique_ptr<SourceStream> source;
    std::vector<VoxelDetail> details; ///< of the last frame
    double coarsening = 1;            ///< of the last frame
    double reach = 0;
    std::uint64_t frames = 0;
    std::size_t fadingBytes = 0;
    bool hasVoxels = false;    ///< some of them have been there: without, meshes show everything
    bool waits = false;        ///< a delta, for the next transition
    bool ownersChange = false; ///< in the transition under way
    VoxelScene lastVoxels;     ///< its draws are the streamer's, until the next frame
    float lastWeight = 1;

    [[nodiscard]] Scene shownScene(const Scene& scene, float weight) const;
    void setReach(const hierarchy::View& view);
    core::Result<UploadStats> apply(const surface::Delta& delta);
    /// Brings what the view needs of the source.
    core::Result<UploadStats> followSource(const hierarchy::View& view, HybridFrame& frame);
    /// Chooses, uploads and draws, after the meshes are up to date.
    core::Result<void> show(
        const hierarchy::View& view,
        const Scene& scene,
        bool begins,
        float weight,
        HybridFrame& frame);
    [[nodiscard]] voxels::ChunkTurn
    turnOf(const hierarchy::View& view, bool begins, float weight) const;
    void noteDetails(const voxels::ChunkFrame& frame);
};

HybridScene::HybridScene(std::unique_ptr<Parts> parts) : _parts(std::move(parts)) {}
HybridScene::HybridScene(HybridScene&&) noexcept = default;
HybridScene& HybridScene::operator=(HybridScene&&) noexcept = default;
HybridScene::~HybridScene() = default;

core::Result<HybridScene> HybridScene::create(
    Renderer& renderer,
    surface::Surface* surface,
    std::shared_ptr<const voxels::ChunkStore> model,
    std::shared_ptr<core::Jobs> jobs,
    const HybridSettings& settings)
{
    auto parts = std::make_unique<Parts>(Parts{
        .renderer = &renderer,
        .surface = surface,
        .model = model,
        .settings = settings,
        .clock = TransitionClock(settings.transitionSeconds),
        .streamer = nullptr,
        .handOver = {},
        .source = nullptr,
        .details = {},
        .lastVoxels = {}});
    const auto made = [&] {
        renderer.holdChanges(parts->clock.length() > 0);
        return HybridScene(std::move(parts));
    };
    const bool hasSource = model && settings.source;
    if (settings.source && (surface != nullptr || !model))
        return core::failure(
            core::ErrorCode::usage,
            "a source is shown near voxels, in place of a surface: give one or the other");
    if (hasSource && (renderer.domain().origin != voxelDomain(model->model().lattice).origin ||
                      renderer.domain().edge != voxelDomain(model->model().lattice).edge))
        return core::failure(
            core::ErrorCode::usage,
            "a voxel model's source needs a renderer of the model's own domain (voxelDomain)");
    if (!model)
        return made();
    const auto pool = renderer.chunkCacheBytes();
    if (!pool)
        return tl::unexpected(pool.error());
    voxels::StreamingSettings& streaming = parts->settings.streaming;
    streaming.cacheBytes = std::min(streaming.cacheBytes, *pool);
    if (surface != nullptr)
        streaming.voxelPixels =
            std::min(streaming.voxelPixels, settings.handOver.pixels / kVoxelError);
    auto streamer = voxels::ChunkStreamer::create(model, streaming, jobs);
    if (!streamer)
        return tl::unexpected(streamer.error());
    parts->streamer = std::move(*streamer);
    if (surface == nullptr && !hasSource)
        return made();
    const voxels::ChunkTree& tree = parts->streamer->tree();
    std::optional<voxels::Chunk> coarsest;
    if (tree.size() > 0) {
        auto read = model->get(tree[0].entry.key);
        if (!read)
            return tl::unexpected(read.error());
        coarsest = std::move(*read);
    }
    HandOverSettings handOver = settings.handOver;
    handOver.meshPixels = settings.pixelError;
    if (hasSource)
        handOver.pixels = kVoxelError * streaming.voxelPixels;
    const voxels::Chunk* const root = coarsest ? &*coarsest : nullptr;
    auto decider =
        hasSource ? HandOver::createForSource(tree, root, handOver)
                  : HandOver::create(tree, root, surface->domain(), settings.latticeSize, handOver);
    if (!decider)
        return tl::unexpected(decider.error());
    parts->handOver = std::move(*decider);
    if (hasSource)
        parts->source = std::make_unique<SourceStream>(
            settings.source,
            tree.lattice(),
            parts->handOver->grid(),
            std::move(jobs),
            static_cast<std::uint64_t>(
                kSourceShare * static_cast<double>(renderer.options().poolBytes)));
    return made();
}

const HandOver* HybridScene::handOver() const
{
    return _parts->handOver ? &*_parts->handOver : nullptr;
}

/// The scene as it is drawn. Of a closed source no backs are: where it folds away from the eye they
/// share an edge with fronts, and would win single pixels of it.
Scene HybridScene::Parts::shownScene(const Scene& scene, float weight) const
{
    Scene shown = faded(scene, weight);
    if (source && source->isClosed() && !shown.twoSided)
        shown.twoSided = false;
    return shown;
}

void HybridScene::Parts::setReach(const hierarchy::View& view)
{
    if (!handOver || surface == nullptr || !view.isValid())
        return;
    const double wanted = handOver->reach(view, coarsening);
    if (reach > 0 && wanted < reach * kReachStep && wanted * kReachStep > reach)
        return;
    reach = wanted;
    surface::DetailSettings detail = settings.detail;
    detail.reach = std::min(detail.reach, reach);
    surface->setDetail(settings.pixelError, detail);
}

core::Result<UploadStats> HybridScene::Parts::apply(const surface::Delta& delta)
{
    auto applied = renderer->apply(delta);
    if (applied && handOver)
        handOver->apply(delta);
    waits = waits || !delta.isEmpty();
    return applied;
}

core::Result<UploadStats>
HybridScene::Parts::followSource(const hierarchy::View& view, HybridFrame& frame)
{
    UploadStats stats;
    const surface::Delta delta = source->update(view, *handOver, fadingBytes);
    if (!delta.isEmpty()) {
        const auto applied = renderer->apply(delta);
        if (!applied && applied.error().code != core::ErrorCode::resourceLimit)
            return applied;
        if (applied)
            stats = *applied;
        else
            source->refuse();
        waits = waits || applied.has_value();
    }
    source->confirm();
    handOver->setSource(source->states());
    frame.sourceBytes = source->bytes();
    frame.sourceHostBytes = source->hostBytes();
    frame.sourceIsFull = source->isFull();
    frame.sourceError = source->takeError();
    return stats;
}

voxels::ChunkTurn
HybridScene::Parts::turnOf(const hierarchy::View& view, bool begins, float weight) const
{
    voxels::ChunkTurn turn;
    turn.begins = begins;
    turn.weight = weight;
    if (!handOver)
        return turn;
    const HandOver& owners = *handOver;
    const auto isCovered = [&owners](const voxels::ChunkTree::Node& chunk) {
        return owners.ownersAround(chunk.box, chunk.entry.key.level).voxels == 0;
    };
    const double near = kSurelyMeshes * owners.distance(view);
    turn.isCovered = isCovered;
    turn.isUnneeded = [isCovered, near, eye = view.eye](const voxels::ChunkTree::Node& chunk) {
        const core::Box& box = chunk.box;
        const glm::dvec3 most = glm::max(glm::abs(box.low - eye), glm::abs(box.high - eye));
        return glm::length(most) < near && isCovered(chunk);
    };
    return turn;
}

void HybridScene::Parts::noteDetails(const voxels::ChunkFrame& frame)
{
    details.clear();
    const voxels::ChunkTree& tree = streamer->tree();
    // What is only tested is hidden, and says nothing; of two pictures the present one counts.
    for (const voxels::ChunkDraw& draw : frame.draws)
        if (!draw.occlusionOnly && draw.inPresent)
            details.push_back({tree[draw.index].entry.key, draw.key.level});
    for (const voxels::CoveredChunk& chunk : frame.covered)
        details.push_back({tree[chunk.index].entry.key, chunk.level});
    hasVoxels = hasVoxels || !details.empty();
    coarsening = frame.coarsening;
}

core::Result<void> HybridScene::Parts::show(
    const hierarchy::View& view, const Scene& scene, bool begins, float weight, HybridFrame& frame)
{
    const Clock::time_point start = Clock::now();
    bool hasChanged = false;
    if (begins) {
        renderer->beginTransition();
        waits = false;
        hasChanged = handOver && (hasVoxels || source) && handOver->begin(view, details);
        ownersChange = hasChanged;
    }
    if (handOver && weight >= 1)
        handOver->end();
    const Scene shown = shownScene(scene, weight);
    VoxelScene voxels;
    voxels.way = settings.way;
    frame.isComplete = true;
    if (streamer) {
        const auto sights = renderer->takeSights();
        if (!sights)
            return tl::unexpected(sights.error());
        const auto completed = renderer->completedFrame();
        if (!completed)
            return tl::unexpected(completed.error());
        std::vector<voxels::Visibility> seen;
        for (const FrameSight& sight : *sights)
            seen.push_back({.frame = sight.frame, .visible = sight.visible});
        const double near = scene.nearPlane > 0 ? scene.nearPlane : renderer->defaultNearPlane();
        const voxels::ChunkFrame& chunks = streamer->update(
            voxels::perspectiveView(
                view.eye,
                view.forward,
                view.up,
                view.verticalFieldOfView,
                view.width,
                view.height,
                near),
            ++frames,
            *completed,
            seen,
            turnOf(view, begins, weight));
        const auto uploaded = renderer->apply(chunks);
        if (!uploaded)
            return tl::unexpected(uploaded.error());
        frame.uploadedVoxelBytes = *uploaded;
        frame.residentVoxelBytes = chunks.residentBytes;
        frame.missingChunks = chunks.missing;
        frame.coarsening = chunks.coarsening;
        frame.voxelPixels = settings.streaming.voxelPixels * chunks.coarsening;
        frame.damaged = chunks.damaged;
        frame.isComplete = chunks.isComplete && !hasChanged;
        noteDetails(chunks);
        voxels.lattice = streamer->tree().lattice();
        voxels.placed = chunks.draws;
        voxels.tree = &streamer->tree();
        if (const auto sun = renderer->sunlight(view, scene))
            voxels.casters = streamer->casters(sun->space, sun->texel);
        voxels.frame = frames;
        voxels.handOver = handOver ? &*handOver : nullptr;
    }
    if (handOver) {
        frame.meshBlocks = handOver->meshBlocks();
        frame.voxelBlocks = handOver->voxelBlocks();
    }
    frame.number = frames;
    frame.transition = weight;
    frame.voxelMilliseconds = millisecondsSince(start);
    lastVoxels = voxels;
    lastVoxels.frame = 0; // what it shows is known already
    lastWeight = weight;
    const auto drawn = renderer->draw(view, shown, voxels);
    if (!drawn)
        return tl::unexpected(drawn.error());
    frame.drawn = *drawn;
    fadingBytes = drawn->fadingBytes;
    const bool fades = waits || ownersChange || fadingBytes > 0 || drawn->cellsFading > 0 ||
                       drawn->voxels.chunksFading > 0;
    frame.isComplete = frame.isComplete && (weight >= 1 || !fades);
    return {};
}

core::Result<HybridFrame>
HybridScene::frame(const hierarchy::View& view, const Scene& scene, double seconds)
{
    Parts& parts = *_parts;
    HybridFrame frame;
    const bool begins = parts.clock.begins(seconds);
    const float weight = parts.clock.weight();
    bool isSettled = true;
    if (parts.surface != nullptr) {
        const Clock::time_point start = Clock::now();
        parts.setReach(view);
        const surface::Delta delta = parts.surface->update(
            view,
            {.milliseconds = parts.settings.updateMilliseconds, .hostBytes = parts.fadingBytes});
        frame.surfaceMilliseconds = millisecondsSince(start);
        const auto applied = parts.apply(delta);
        if (!applied)
            return tl::unexpected(applied.error());
        frame.meshes = *applied;
        isSettled = delta.isEmpty() && parts.surface->isSettled();
    }
    if (parts.source) {
        const auto followed = parts.followSource(view, frame);
        if (!followed)
            return tl::unexpected(followed.error());
        frame.meshes = *followed;
        isSettled = parts.source->isComplete() && !parts.waits;
    }
    if (const auto shown = parts.show(view, scene, begins, weight, frame); !shown)
        return tl::unexpected(shown.error());
    frame.isComplete = frame.isComplete && isSettled;
    return frame;
}

core::Result<FrameStats> HybridScene::redraw(const hierarchy::View& view, const Scene& scene)
{
    const Scene shown = _parts->shownScene(scene, _parts->lastWeight);
    auto drawn = _parts->renderer->draw(view, shown, _parts->lastVoxels);
    if (!drawn)
        return drawn;
    // The streamer doesn't know of this picture, and may write over what it reads.
    if (const auto done = _parts->renderer->finish(); !done)
        return tl::unexpected(done.error());
    return drawn;
}

core::Result<HybridFrame> HybridScene::settle(
    const hierarchy::View& view,
    const Scene& scene,
    const std::function<void(double)>& progress,
    const std::stop_token& stop)
{
    Parts& parts = *_parts;
    const auto interrupted = [] {
        return core::failure(core::ErrorCode::interrupted, "interrupted while a view was prepared");
    };
    UploadStats meshes;
    double surfaceMilliseconds = 0;
    const auto settleMeshes = [&]() -> core::Result<void> {
        if (parts.surface == nullptr)
            return {};
        const Clock::time_point start = Clock::now();
        parts.setReach(view);
        const surface::Delta delta = parts.surface->settle(view, progress, stop);
        surfaceMilliseconds += millisecondsSince(start);
        const auto applied = parts.apply(delta);
        if (!applied)
            return tl::unexpected(applied.error());
        meshes.cellsAdded += applied->cellsAdded;
        meshes.cellsRemoved += applied->cellsRemoved;
        meshes.uploadedBytes += applied->uploadedBytes;
        return {};
    };
    if (const auto settled = settleMeshes(); !settled)
        return tl::unexpected(settled.error());
    std::vector<core::Error> damaged;
    std::optional<core::Error> sourceError;
    bool wasComplete = false;
    for (;;) {
        if (stop.stop_requested())
            return interrupted();
        HybridFrame frame;
        while (parts.source) {
            const auto followed = parts.followSource(view, frame);
            if (!followed)
                return tl::unexpected(followed.error());
            if (frame.sourceError)
                sourceError = frame.sourceError;
            meshes.cellsAdded += followed->cellsAdded;
            meshes.cellsRemoved += followed->cellsRemoved;
            meshes.uploadedBytes += followed->uploadedBytes;
            if (parts.source->isComplete() || !parts.source->isWorking() || stop.stop_requested())
                break;
            parts.source->wait(stop);
        }
        if (const auto shown = parts.show(view, scene, true, 1, frame); !shown)
            return tl::unexpected(shown.error());
        const bool hasSource = !parts.source || parts.source->isComplete();
        const bool areVoxelsThere = frame.isComplete;
        frame.isComplete = frame.isComplete && hasSource;
        damaged.insert(damaged.end(), frame.damaged.begin(), frame.damaged.end());
        if (const auto done = parts.renderer->finish(); !done)
            return tl::unexpected(done.error());
        // With voxels, once more: who owns what depends on what was there before.
        if (frame.isComplete && (wasComplete || !parts.streamer)) {
            frame.meshes = meshes;
            frame.surfaceMilliseconds = surfaceMilliseconds;
            frame.damaged = std::move(damaged);
            frame.sourceError = sourceError;
            // all of this is there at once: nothing of it is to fade afterwards
            parts.clock = TransitionClock(parts.settings.transitionSeconds);
            return frame;
        }
        wasComplete = frame.isComplete;
        if (!areVoxelsThere && parts.streamer)
            parts.streamer->waitForChunks();
        // Where the cache is too small for the voxels, meshes have to reach further.
        if (const auto settled = settleMeshes(); !settled)
            return tl::unexpected(settled.error());
    }
}

} // namespace isofront::render

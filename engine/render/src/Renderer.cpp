#include "Culling.h"
#include "FrameData.h"
#include "IndirectDraws.h"
#include "Readback.h"
#include "RendererParts.h"
#include "Samples.h"

#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Device.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

namespace isofront::render {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

core::Result<void> checkOptions(const gpu::Device& device, const RendererOptions& options)
{
    const auto limit = static_cast<int>(device.limits().maxImageDimension2D);
    const bool size = options.width >= 1 && options.height >= 1 && options.width <= limit &&
                      options.height <= limit;
    if (!size || options.shadowMapSize < 16 || options.shadowMapSize > limit ||
        options.framesInFlight < 1 || options.framesInFlight > 8) {
        return core::failure(
            core::ErrorCode::usage,
            "a renderer of " + std::to_string(options.width) + " x " +
                std::to_string(options.height) + " pixels with " +
                std::to_string(options.framesInFlight) + " frames in flight and shadow maps of " +
                std::to_string(options.shadowMapSize) + " texels is not possible; use 1 to " +
                std::to_string(limit) + " pixels a side, 1 to 8 frames and at least 16 texels");
    }
    return {};
}

} // namespace

Renderer::Renderer(std::unique_ptr<Parts> parts) : _parts(std::move(parts)) {}

Renderer::~Renderer()
{
    // Whatever it owns may still be read; a device that fails here has stopped reading.
    if (_parts != nullptr)
        (void)_parts->device->wait(_parts->device->submitted());
}

core::Result<std::unique_ptr<Renderer>> Renderer::create(
    gpu::Device& device, const hierarchy::Domain& domain, const RendererOptions& options)
{
    if (core::Result<void> sound = checkOptions(device, options); !sound)
        return tl::unexpected(sound.error());
    if (core::Result<void> sound = checkSamples(device, options.samples); !sound)
        return tl::unexpected(sound.error());
    const auto samples = static_cast<VkSampleCountFlagBits>(options.samples);
    core::Result<MeshStore> store = MeshStore::create(device, options);
    if (!store)
        return tl::unexpected(store.error());
    core::Result<Targets> targets = Targets::create(
        device,
        static_cast<std::uint32_t>(options.width),
        static_cast<std::uint32_t>(options.height),
        samples);
    if (!targets)
        return tl::unexpected(targets.error());
    core::Result<SunMap> sun = SunMap::create(device, options.shadowMapSize);
    if (!sun)
        return tl::unexpected(sun.error());
    core::Result<Passes> passes = Passes::create(
        device, static_cast<std::uint32_t>(options.framesInFlight), samples, options.meshColours);
    if (!passes)
        return tl::unexpected(passes.error());
    core::Result<gpu::Commands> copying = gpu::Commands::create(device);
    if (!copying)
        return tl::unexpected(copying.error());
    std::vector<Slot> slots;
    for (int i = 0; i < options.framesInFlight; ++i) {
        core::Result<Slot> slot = makeSlot(device);
        if (!slot)
            return tl::unexpected(slot.error());
        slots.push_back(std::move(*slot));
    }
    auto parts = std::make_unique<Parts>(Parts{
        .device = &device,
        .domain = domain,
        .options = options,
        .indirect = device.drawsManyIndirectly() && !options.forceDirectDraws,
        .store = std::move(*store),
        .targets = std::move(*targets),
        .passes = std::move(*passes),
        .slots = std::move(slots),
        .copying = std::move(*copying),
        .sun = std::move(*sun),
        .seen = {},
        .pictures = {},
        .sunlitPictures = {},
        .sunlit = {},
        .voxels = {},
        .lastVoxels = {},
        .sights = {}});
    return std::unique_ptr<Renderer>(new Renderer(std::move(parts)));
}

core::Result<UploadStats> Renderer::apply(const surface::Delta& delta)
{
    const Clock::time_point start = Clock::now();
    core::Result<UploadStats> stats = _parts->store.apply(delta);
    if (stats) {
        stats->cpuMilliseconds = millisecondsSince(start);
        _parts->uploadedSinceFrame += stats->uploadedBytes;
    }
    return stats;
}

void Renderer::holdChanges(bool hold)
{
    _parts->store.hold(hold);
}

void Renderer::beginTransition()
{
    _parts->store.beginTransition();
    _parts->sun.beginTransition();
}

void Renderer::clear()
{
    _parts->store.clear();
}

std::size_t Renderer::cellCount() const
{
    return _parts->store.wanted();
}

const hierarchy::Domain& Renderer::domain() const
{
    return _parts->domain;
}

const RendererOptions& Renderer::options() const
{
    return _parts->options;
}

double Renderer::defaultNearPlane() const
{
    return render::defaultNearPlane(_parts->domain);
}

core::Result<void> Renderer::Parts::resize(int width, int height)
{
    const VkExtent2D extent{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    if (extent.width == targets.extent().width && extent.height == targets.extent().height)
        return {};
    if (core::Result<void> idle = device->wait(device->submitted()); !idle)
        return idle;
    core::Result<Targets> fresh = Targets::create(
        *device, extent.width, extent.height, static_cast<VkSampleCountFlagBits>(options.samples));
    if (!fresh)
        return tl::unexpected(fresh.error());
    targets = std::move(*fresh);
    lastSlot = nullptr;
    lastVoxels.reset();
    return {};
}

void Renderer::Parts::issueMeshes(
    VkCommandBuffer commands, const Slot& slot, std::size_t first, std::size_t count) const
{
    issueDraws(*device, commands, slot.draws, first, count, indirect);
}

core::Result<void> Renderer::Parts::record(
    std::size_t index,
    const hierarchy::View& view,
    const Scene& scene,
    const HandOver* handOver,
    bool redrawShadows,
    bool withVoxels,
    bool castsVoxels)
{
    Slot& slot = slots[index];
    shared::Frame frame =
        frameData(domain, view, scene, sun.box(), sun.texels(), options.samples, handOver);
    setFormerShadows(frame, sun.formerBox());
    std::memcpy(slot.frame.mapped().data(), &frame, sizeof frame);
    // Where nothing has a colour of its own, nobody looks.
    const bool hasColours = withVoxels || options.meshColours;
    if (hasColours) {
        if (core::Result<void> made = targets.needColours(*device); !made)
            return made;
    }
    const gpu::Image& colours = hasColours ? targets.colours : targets.surface;
    passes.bind(
        index, slot.frame, slot.cells, slot.owners, targets, colours, sun.present(), sun.former());

    const VkCommandBuffer commands = slot.commands.get();
    slot.timestamps.reset(commands);
    slot.passes.clear();
    slot.timestamps.mark(commands);
    const auto pass = [&](const char* name) {
        slot.timestamps.mark(commands);
        slot.passes.push_back(name);
    };
    const bool twoSided = scene.twoSided.value_or(scene.look == Look::studio);
    Passes::MeshDraw draw{
        .meshes = &store.buffer(),
        .colours = store.colours(),
        .cull = VK_CULL_MODE_BACK_BIT,
        .front = domain.worldFromField.mirrors() ? VK_FRONT_FACE_CLOCKWISE
                                                 : VK_FRONT_FACE_COUNTER_CLOCKWISE,
        .issue = [&](VkCommandBuffer buffer) {
            issueMeshes(buffer, slot, seen.size(), sunlit.size());
        }};
    if (redrawShadows)
        passes.drawShadows(commands, index, sun.present(), draw, [&] {
            if (castsVoxels)
                voxels->pass.drawShadows(commands, index, sun.present().extent());
        });
    else if (!sun.box().casts)
        Passes::skipShadows(commands, sun.present());
    pass("shadow");
    draw.cull = twoSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT;
    const std::size_t steady = seen.size() - fading;
    draw.issue = [&](VkCommandBuffer buffer) { issueMeshes(buffer, slot, 0, steady); };
    if (fading > 0)
        draw.issueFading = [&](VkCommandBuffer buffer) {
            issueMeshes(buffer, slot, steady, fading);
        };
    passes.drawMeshes(commands, index, targets, draw);
    pass("mesh");
    if (withVoxels) {
        voxels->pass.record(commands, index, targets, options.meshColours);
        pass("voxels");
    }
    const bool softens = scene.antialias && options.samples == 1;
    passes.shade(commands, index, targets, scene.look, !softens, hasColours);
    pass("shade");
    if (softens) {
        passes.antialias(commands, index, targets);
        pass("antialias");
    }
    Passes::finish(commands, targets);
    slot.timestamps.resolve(commands);
    const core::Result<gpu::Device::Ticket> ticket = slot.commands.submit();
    if (!ticket)
        return tl::unexpected(ticket.error());
    return {};
}

core::Result<FrameStats>
Renderer::draw(const hierarchy::View& view, const Scene& scene, const VoxelScene& voxels)
{
    Parts& parts = *_parts;
    const auto limit = static_cast<int>(parts.device->limits().maxImageDimension2D);
    if (!view.isValid() || view.width > limit || view.height > limit) {
        return core::failure(
            core::ErrorCode::usage,
            "the view can't be drawn: it needs finite numbers, an up direction off the looking "
            "direction, an angle below 180 degrees and 1 to " +
                std::to_string(limit) + " pixels a side");
    }
    if (core::Result<void> sized = parts.resize(view.width, view.height); !sized)
        return tl::unexpected(sized.error());

    const std::size_t index = parts.nextSlot;
    Slot& slot = parts.slots[index];
    if (core::Result<void> begun = slot.commands.begin(); !begun)
        return tl::unexpected(begun.error());
    parts.settle(index);
    const Clock::time_point start = Clock::now();
    FrameStats stats;
    const std::vector<double> spans = slot.timestamps.spans();
    stats.gpuMilliseconds = std::accumulate(spans.begin(), spans.end(), 0.0);

    const std::span<const StoredCell> cells = parts.store.cells();
    const SunBox sun = sunBox(parts.domain, view, scene, parts.sun.texels());
    const float weight = shownWeight(scene);
    const std::uint32_t shown = picturesShown(weight);
    visibleInto(cells, gridView(parts.domain, view), parts.seen, shown);
    picturesInto(cells, parts.domain, voxels.handOver, shown, parts.seen, parts.pictures);
    parts.fading = moveFadingLast(parts.pictures, shown, parts.seen);
    parts.sunlit.clear();
    const core::Result<bool> redrawShadows =
        parts.sun.update(*parts.device, parts.domain, sun, scene.shadowInterval, weight);
    if (!redrawShadows)
        return tl::unexpected(redrawShadows.error());
    if (*redrawShadows) {
        visibleInto(cells, gridView(parts.domain, view, sun), parts.sunlit, shared::kInPresent);
        picturesInto(
            cells,
            parts.domain,
            voxels.handOver,
            shared::kInPresent,
            parts.sunlit,
            parts.sunlitPictures);
    }
    if (core::Result<void> room =
            reserveDraws(*parts.device, slot, parts.seen.size() + parts.sunlit.size());
        !room)
        return tl::unexpected(room.error());
    if (core::Result<void> filled = fillOwners(*parts.device, slot, voxels.handOver); !filled)
        return tl::unexpected(filled.error());
    stats.triangles = fillDraws(slot, cells, parts.pictures, parts.seen, 0);
    stats.shadowTriangles =
        fillDraws(slot, cells, parts.sunlitPictures, parts.sunlit, parts.seen.size());
    stats.draws = parts.seen.size() + parts.sunlit.size();
    stats.cellsDrawn = parts.seen.size();
    stats.cellsFading = static_cast<std::size_t>(
        std::count_if(parts.seen.begin(), parts.seen.end(), [&](std::uint32_t cell) {
            return isInTransition(parts.pictures[cell], shown);
        }));
    stats.cellsCulled = parts.store.countIn(shown) - parts.seen.size();
    const core::Result<VoxelStats> voxelStats =
        parts.prepareVoxels(index, view, scene, voxels, *redrawShadows);
    if (!voxelStats)
        return tl::unexpected(voxelStats.error());
    stats.voxels = *voxelStats;
    const bool withVoxels = stats.voxels.chunksDrawn + stats.voxels.boxes > 0;
    const bool castsVoxels = stats.voxels.shadowVoxels > 0;
    if (core::Result<void> recorded = parts.record(
            index, view, scene, voxels.handOver, *redrawShadows, withVoxels, castsVoxels);
        !recorded)
        return tl::unexpected(recorded.error());
    if (*redrawShadows)
        parts.sun.setDrawn();
    parts.nextSlot = (index + 1) % parts.slots.size();
    slot.streamed = voxels.frame;
    slot.hasVoxels = withVoxels;
    parts.lastVoxels = withVoxels ? std::optional(index) : std::nullopt;
    parts.lastSlot = &slot;

    stats.uploadedBytes = std::exchange(parts.uploadedSinceFrame, 0);
    stats.poolBytesUsed = parts.store.usedBytes();
    stats.fadingBytes = parts.store.fadingBytes();
    stats.deviceBytes = parts.device->allocatedBytes();
    stats.cpuMilliseconds = millisecondsSince(start);
    return stats;
}

std::optional<Sunlight> Renderer::sunlight(const hierarchy::View& view, const Scene& scene) const
{
    const int texels = _parts->sun.texels();
    const SunBox box = sunBox(_parts->domain, view, scene, texels);
    if (!box.casts)
        return std::nullopt;
    Sunlight light{.space = {.eye = view.eye}, .texel = 2 * box.halfWidth / texels};
    for (std::size_t i = 0; i < 2; ++i) {
        light.space.planes[2 * i] = {box.axes[i], box.halfWidth - box.centre[i]};
        light.space.planes[2 * i + 1] = {-box.axes[i], box.halfWidth + box.centre[i]};
    }
    return light;
}

core::Result<std::vector<PassTime>> Renderer::finish()
{
    const Slot* slot = _parts->lastSlot;
    if (slot == nullptr)
        return std::vector<PassTime>();
    if (core::Result<void> waited = _parts->device->wait(slot->commands.ticket()); !waited)
        return tl::unexpected(waited.error());
    const std::vector<double> spans = slot->timestamps.spans();
    std::vector<PassTime> times;
    for (std::size_t i = 0; i < spans.size(); ++i)
        times.push_back({slot->passes[i], spans[i]});
    return times;
}

core::Result<std::vector<std::byte>>
Renderer::Parts::copied(const gpu::Image& image, const gpu::Use& now)
{
    if (lastSlot == nullptr)
        return core::failure(core::ErrorCode::usage, "there is no picture to read; draw one first");
    return copiedImage(*device, copying, image, now);
}

core::Result<core::Image> Renderer::readImage()
{
    const core::Result<std::vector<std::byte>> bytes =
        _parts->copied(_parts->targets.picture, gpu::use::kTransferRead);
    if (!bytes)
        return tl::unexpected(bytes.error());
    core::Image image;
    image.width = static_cast<int>(_parts->targets.extent().width);
    image.height = static_cast<int>(_parts->targets.extent().height);
    image.rgba.resize(bytes->size());
    std::memcpy(image.rgba.data(), bytes->data(), bytes->size());
    return image;
}

core::Result<std::vector<float>> Renderer::readDepth()
{
    const core::Result<std::vector<std::byte>> bytes =
        _parts->copied(_parts->targets.depth, gpu::use::kSampledInFragment);
    if (!bytes)
        return tl::unexpected(bytes.error());
    std::vector<float> depth(bytes->size() / sizeof(float));
    std::memcpy(depth.data(), bytes->data(), bytes->size());
    return depth;
}

} // namespace isofront::render

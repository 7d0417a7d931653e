#include "isofront/render/Renderer.h"

#include "Culling.h"
#include "FrameData.h"
#include "MeshStore.h"
#include "Passes.h"
#include "SunBox.h"
#include "Targets.h"

#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Commands.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Timestamps.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstring>
#include <limits>
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

constexpr std::array<const char*, 4> kPassNames{"shadow", "mesh", "shade", "antialias"};

/// What one of the frames in flight owns.
struct Slot {
    gpu::Commands commands;
    gpu::Timestamps timestamps;
    gpu::Buffer frame; ///< a shared::Frame
    gpu::Buffer cells; ///< a shared::DrawnCell for each draw
    gpu::Buffer draws; ///< a VkDrawIndexedIndirectCommand for each draw
};

template <typename T>
std::span<T> mappedAs(const gpu::Buffer& buffer)
{
    return {reinterpret_cast<T*>(buffer.mapped().data()), buffer.mapped().size() / sizeof(T)};
}

/// Makes sure that the slot, which the GPU is done with, has room for so many draws.
core::Result<void> reserveDraws(gpu::Device& device, Slot& slot, std::size_t count)
{
    const std::size_t room = std::bit_ceil(std::max<std::size_t>(count, 256));
    const auto grow = [&](gpu::Buffer& buffer,
                          std::size_t bytes,
                          VkBufferUsageFlags usage) -> core::Result<void> {
        if (buffer.bytes() >= bytes)
            return {};
        core::Result<gpu::Buffer> larger =
            gpu::Buffer::create(device, bytes, usage, gpu::MemoryKind::upload);
        if (!larger)
            return tl::unexpected(larger.error());
        buffer = std::move(*larger);
        return {};
    };
    if (core::Result<void> grown =
            grow(slot.cells, room * sizeof(shared::DrawnCell), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        !grown)
        return grown;
    return grow(
        slot.draws,
        room * sizeof(VkDrawIndexedIndirectCommand),
        VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
}

core::Result<Slot> makeSlot(gpu::Device& device)
{
    core::Result<gpu::Commands> commands = gpu::Commands::create(device);
    if (!commands)
        return tl::unexpected(commands.error());
    core::Result<gpu::Timestamps> timestamps =
        gpu::Timestamps::create(device, kPassNames.size() + 1);
    if (!timestamps)
        return tl::unexpected(timestamps.error());
    core::Result<gpu::Buffer> frame = gpu::Buffer::create(
        device, sizeof(shared::Frame), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, gpu::MemoryKind::upload);
    if (!frame)
        return tl::unexpected(frame.error());
    return Slot{std::move(*commands), std::move(*timestamps), std::move(*frame), {}, {}};
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

struct Renderer::Parts {
    gpu::Device* device;
    hierarchy::Domain domain;
    bool indirect = true;
    MeshStore store;
    Targets targets;
    Passes passes;
    std::vector<Slot> slots;
    std::size_t nextSlot = 0;
    const Slot* lastSlot = nullptr; ///< of the last picture
    gpu::Commands copying;
    std::uint64_t uploadedSinceFrame = 0;
    gpu::Image shadowMap;
    std::vector<std::uint32_t> seen;   ///< cells in the picture, the nearest first
    SunBox shadowBox;                  ///< what the shadow map shows
    int mapAge = 0;                    ///< in frames
    std::vector<std::uint32_t> sunlit; ///< cells that may cast shadows into it

    core::Result<void> resize(int width, int height);
    /// Writes what the passes over the mesh read of these cells, from a draw on. Returns how many
    /// triangles they have.
    std::uint64_t
    fill(const Slot& slot, std::span<const std::uint32_t> order, std::size_t first) const;
    void issueDraws(
        VkCommandBuffer commands, const Slot& slot, std::size_t first, std::size_t count) const;
    core::Result<void>
    record(std::size_t index, const hierarchy::View& view, const Scene& scene, bool redrawShadows);
    /// Keeps the shadow map, or takes a new box for it. Returns true if it must be drawn.
    bool updateSun(const SunBox& wanted, int interval);
    /// Copies an image of the last picture, four bytes a pixel.
    core::Result<std::vector<std::byte>> copied(const gpu::Image& image, const gpu::Use& now);
};

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
    core::Result<MeshStore> store = MeshStore::create(device, options);
    if (!store)
        return tl::unexpected(store.error());
    core::Result<Targets> targets = Targets::create(
        device,
        static_cast<std::uint32_t>(options.width),
        static_cast<std::uint32_t>(options.height));
    if (!targets)
        return tl::unexpected(targets.error());
    const auto shadowTexels = static_cast<std::uint32_t>(options.shadowMapSize);
    core::Result<gpu::Image> shadowMap = gpu::Image::create(
        device,
        shadowTexels,
        shadowTexels,
        kDepthFormat,
        VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    if (!shadowMap)
        return tl::unexpected(shadowMap.error());
    core::Result<Passes> passes =
        Passes::create(device, static_cast<std::uint32_t>(options.framesInFlight));
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
        .indirect = device.drawsManyIndirectly() && !options.forceDirectDraws,
        .store = std::move(*store),
        .targets = std::move(*targets),
        .passes = std::move(*passes),
        .slots = std::move(slots),
        .copying = std::move(*copying),
        .shadowMap = std::move(*shadowMap),
        .seen = {},
        .shadowBox = {},
        .sunlit = {}});
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

void Renderer::clear()
{
    _parts->store.clear();
}

std::size_t Renderer::cellCount() const
{
    return _parts->store.cells().size();
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
    core::Result<Targets> fresh = Targets::create(*device, extent.width, extent.height);
    if (!fresh)
        return tl::unexpected(fresh.error());
    targets = std::move(*fresh);
    lastSlot = nullptr;
    return {};
}

std::uint64_t Renderer::Parts::fill(
    const Slot& slot, std::span<const std::uint32_t> order, std::size_t first) const
{
    const std::span<shared::DrawnCell> drawn = mappedAs<shared::DrawnCell>(slot.cells);
    const std::span<VkDrawIndexedIndirectCommand> draws =
        mappedAs<VkDrawIndexedIndirectCommand>(slot.draws);
    const std::span<const StoredCell> cells = store.cells();
    std::uint64_t triangles = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const StoredCell& cell = cells[order[i]];
        drawn[first + i].lowAndExponent = {
            cell.corner.x, cell.corner.y, cell.corner.z, cell.exponent};
        draws[first + i] = {
            .indexCount = cell.indexCount,
            .instanceCount = 1,
            .firstIndex = cell.firstIndex(),
            .vertexOffset = cell.vertexOffset(),
            .firstInstance = static_cast<std::uint32_t>(first + i)};
        triangles += cell.indexCount / 3;
    }
    return triangles;
}

void Renderer::Parts::issueDraws(
    VkCommandBuffer commands, const Slot& slot, std::size_t first, std::size_t count) const
{
    constexpr std::uint32_t kStride = sizeof(VkDrawIndexedIndirectCommand);
    if (indirect) {
        const std::size_t most = std::max(device->limits().maxDrawIndirectCount, 1U);
        while (count > 0) {
            const std::size_t some = std::min(most, count);
            vkCmdDrawIndexedIndirect(
                commands,
                slot.draws.get(),
                first * kStride,
                static_cast<std::uint32_t>(some),
                kStride);
            first += some;
            count -= some;
        }
        return;
    }
    for (const VkDrawIndexedIndirectCommand& draw :
         mappedAs<VkDrawIndexedIndirectCommand>(slot.draws).subspan(first, count)) {
        vkCmdDrawIndexed(
            commands,
            draw.indexCount,
            draw.instanceCount,
            draw.firstIndex,
            draw.vertexOffset,
            draw.firstInstance);
    }
}

core::Result<void> Renderer::Parts::record(
    std::size_t index, const hierarchy::View& view, const Scene& scene, bool redrawShadows)
{
    Slot& slot = slots[index];
    const auto shadowTexels = static_cast<int>(shadowMap.extent().width);
    const shared::Frame frame = frameData(domain, view, scene, shadowBox, shadowTexels);
    std::memcpy(slot.frame.mapped().data(), &frame, sizeof frame);
    passes.bind(index, slot.frame, slot.cells, targets, shadowMap);

    const VkCommandBuffer commands = slot.commands.get();
    slot.timestamps.reset(commands);
    slot.timestamps.mark(commands);
    const bool twoSided = scene.twoSided.value_or(scene.look == Look::studio);
    Passes::MeshDraw draw{
        .meshes = &store.buffer(),
        .cull = VK_CULL_MODE_BACK_BIT,
        .front = domain.worldFromField.mirrors() ? VK_FRONT_FACE_CLOCKWISE
                                                 : VK_FRONT_FACE_COUNTER_CLOCKWISE,
        .issue = [&](VkCommandBuffer buffer) {
            issueDraws(buffer, slot, seen.size(), sunlit.size());
        }};
    if (redrawShadows)
        passes.drawShadows(commands, index, shadowMap, draw);
    else if (!shadowBox.casts)
        Passes::skipShadows(commands, shadowMap);
    slot.timestamps.mark(commands);
    draw.cull = twoSided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT;
    draw.issue = [&](VkCommandBuffer buffer) { issueDraws(buffer, slot, 0, seen.size()); };
    passes.drawMeshes(commands, index, targets, draw);
    slot.timestamps.mark(commands);
    passes.shade(commands, index, targets, scene.look, !scene.antialias);
    slot.timestamps.mark(commands);
    if (scene.antialias) {
        passes.antialias(commands, index, targets);
        slot.timestamps.mark(commands);
    }
    Passes::finish(commands, targets);
    slot.timestamps.resolve(commands);
    const core::Result<gpu::Device::Ticket> ticket = slot.commands.submit();
    if (!ticket)
        return tl::unexpected(ticket.error());
    return {};
}

bool Renderer::Parts::updateSun(const SunBox& wanted, int interval)
{
    const SunBox kept = shadowBox.seenFrom(domain, wanted.eye);
    if (wanted.casts && mapAge < interval && kept.isNear(wanted)) {
        shadowBox = kept;
        ++mapAge;
        return false;
    }
    shadowBox = wanted;
    // Until it is really drawn, it must not be kept.
    mapAge = std::numeric_limits<int>::max();
    return wanted.casts;
}

core::Result<FrameStats> Renderer::draw(const hierarchy::View& view, const Scene& scene)
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
    const Clock::time_point start = Clock::now();
    FrameStats stats;
    const std::vector<double> spans = slot.timestamps.spans();
    stats.gpuMilliseconds = std::accumulate(spans.begin(), spans.end(), 0.0);

    const std::span<const StoredCell> cells = parts.store.cells();
    const SunBox sun =
        sunBox(parts.domain, view, scene, static_cast<int>(parts.shadowMap.extent().width));
    visibleInto(cells, gridView(parts.domain, view), parts.seen);
    parts.sunlit.clear();
    const bool redrawShadows = parts.updateSun(sun, scene.shadowInterval);
    if (redrawShadows)
        visibleInto(cells, gridView(parts.domain, view, sun), parts.sunlit);
    if (core::Result<void> room =
            reserveDraws(*parts.device, slot, parts.seen.size() + parts.sunlit.size());
        !room)
        return tl::unexpected(room.error());
    stats.triangles = parts.fill(slot, parts.seen, 0);
    stats.shadowTriangles = parts.fill(slot, parts.sunlit, parts.seen.size());
    stats.draws = parts.seen.size() + parts.sunlit.size();
    stats.cellsDrawn = parts.seen.size();
    stats.cellsCulled = cells.size() - parts.seen.size();
    if (core::Result<void> recorded = parts.record(index, view, scene, redrawShadows); !recorded)
        return tl::unexpected(recorded.error());
    if (redrawShadows)
        parts.mapAge = 1;
    parts.nextSlot = (index + 1) % parts.slots.size();
    parts.lastSlot = &slot;

    stats.uploadedBytes = std::exchange(parts.uploadedSinceFrame, 0);
    stats.poolBytesUsed = parts.store.usedBytes();
    stats.deviceBytes = parts.device->allocatedBytes();
    stats.cpuMilliseconds = millisecondsSince(start);
    return stats;
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
        times.push_back({kPassNames[i], spans[i]});
    return times;
}

core::Result<std::vector<std::byte>>
Renderer::Parts::copied(const gpu::Image& image, const gpu::Use& now)
{
    if (lastSlot == nullptr)
        return core::failure(core::ErrorCode::usage, "there is no picture to read; draw one first");
    const VkExtent2D extent = image.extent();
    const std::size_t bytes = std::size_t{extent.width} * extent.height * 4;
    core::Result<gpu::Buffer> target = gpu::Buffer::create(
        *device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryKind::readback);
    if (!target)
        return tl::unexpected(target.error());
    if (core::Result<void> begun = copying.begin(); !begun)
        return tl::unexpected(begun.error());
    const VkCommandBuffer commands = copying.get();
    gpu::imageBarrier(commands, image, now, gpu::use::kTransferRead);
    const VkBufferImageCopy region{
        .imageSubresource = {image.aspect(), 0, 0, 1},
        .imageExtent = {extent.width, extent.height, 1}};
    vkCmdCopyImageToBuffer(
        commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target->get(), 1, &region);
    gpu::imageBarrier(commands, image, gpu::use::kTransferRead, now);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kHostRead);
    const core::Result<gpu::Device::Ticket> ticket = copying.submit();
    if (!ticket)
        return tl::unexpected(ticket.error());
    if (core::Result<void> waited = device->wait(*ticket); !waited)
        return tl::unexpected(waited.error());
    const std::span<const std::byte> mapped = target->mapped();
    return std::vector<std::byte>(mapped.begin(), mapped.end());
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

// What a renderer does about voxels: see Renderer.h.
#include "ChunkLists.h"
#include "Culling.h"
#include "FrameData.h"
#include "RendererParts.h"
#include "VoxelFrame.h"

#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Device.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

namespace isofront::render {

core::Result<void> Renderer::Parts::openVoxels()
{
    if (voxels)
        return {};
    core::Result<VoxelStore> pool =
        VoxelStore::create(*device, options.voxelPoolBytes, options.forceStaging);
    if (!pool)
        return tl::unexpected(pool.error());
    core::Result<VoxelPass> pass = VoxelPass::create(
        *device,
        static_cast<std::uint32_t>(slots.size()),
        indirect,
        static_cast<VkSampleCountFlagBits>(options.samples));
    if (!pass)
        return tl::unexpected(pass.error());
    voxels.emplace(VoxelParts{std::move(*pool), std::move(*pass)});
    return {};
}

core::Result<std::uint64_t> Renderer::addChunks(std::span<const voxels::Chunk> chunks)
{
    if (core::Result<void> opened = _parts->openVoxels(); !opened)
        return tl::unexpected(opened.error());
    core::Result<std::uint64_t> bytes = _parts->voxels->store.add(chunks);
    if (bytes)
        _parts->voxelBytesSinceFrame += *bytes;
    return bytes;
}

core::Result<std::uint64_t> Renderer::addTransitions(std::span<const VoxelTransition> transitions)
{
    if (core::Result<void> opened = _parts->openVoxels(); !opened)
        return tl::unexpected(opened.error());
    core::Result<std::uint64_t> bytes = _parts->voxels->store.add(transitions);
    if (bytes)
        _parts->voxelBytesSinceFrame += *bytes;
    return bytes;
}

void Renderer::removeChunks(std::span<const voxels::ChunkKey> keys)
{
    if (_parts->voxels)
        _parts->voxels->store.remove(keys);
}

core::Result<void> Renderer::clearChunks()
{
    return _parts->voxels ? _parts->voxels->store.clear() : core::Result<void>();
}

core::Result<std::uint64_t> Renderer::chunkCacheBytes()
{
    if (core::Result<void> opened = _parts->openVoxels(); !opened)
        return tl::unexpected(opened.error());
    return _parts->voxels->store.buffer().bytes();
}

core::Result<std::uint64_t> Renderer::apply(const voxels::ChunkFrame& frame)
{
    if (core::Result<void> opened = _parts->openVoxels(); !opened)
        return tl::unexpected(opened.error());
    core::Result<std::uint64_t> bytes = _parts->voxels->store.apply(frame);
    if (bytes)
        _parts->voxelBytesSinceFrame += *bytes;
    return bytes;
}

core::Result<std::vector<FrameSight>> Renderer::takeSights()
{
    if (core::Result<void> settled = _parts->settleAll(); !settled)
        return tl::unexpected(settled.error());
    std::vector<FrameSight> sights = std::exchange(_parts->sights, {});
    std::sort(sights.begin(), sights.end(), [](const FrameSight& a, const FrameSight& b) {
        return a.frame < b.frame;
    });
    return sights;
}

core::Result<std::uint64_t> Renderer::completedFrame()
{
    if (core::Result<void> settled = _parts->settleAll(); !settled)
        return tl::unexpected(settled.error());
    return _parts->completedFrame;
}

void Renderer::Parts::settle(std::size_t index)
{
    Slot& slot = slots[index];
    if (slot.streamed == 0)
        return;
    completedFrame = std::max(completedFrame, slot.streamed);
    FrameSight sight{.frame = std::exchange(slot.streamed, 0)};
    if (slot.hasVoxels) {
        const VoxelFrame& frame = voxels->pass.frame(index);
        const std::span<const std::uint32_t> visible = voxels->pass.visible(index);
        sight.visible.resize(frame.listed);
        for (std::size_t i = 0; i < visible.size(); ++i)
            sight.visible[frame.places[i]] = visible[i];
        for (const std::uint32_t place : frame.untested)
            sight.visible[place] = 1;
        sight.pattern = voxels->pass.pattern(index);
        sights.push_back(std::move(sight));
    }
}

core::Result<void> Renderer::Parts::settleAll()
{
    const core::Result<gpu::Device::Ticket> completed = device->completed();
    if (!completed)
        return tl::unexpected(completed.error());
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i].commands.ticket() <= *completed)
            settle(i);
    }
    return {};
}

core::Result<VoxelStats> Renderer::Parts::prepareVoxels(
    std::size_t index,
    const hierarchy::View& view,
    const Scene& scene,
    const VoxelScene& shown,
    bool castsShadows)
{
    if (!voxels && shown.draws.empty() && shown.placed.empty())
        return VoxelStats{};
    if (core::Result<void> opened = openVoxels(); !opened)
        return tl::unexpected(opened.error());
    const double near = scene.nearPlane > 0 ? scene.nearPlane : render::defaultNearPlane(domain);
    const core::Result<std::vector<PlacedChunk>> chunks = chunksOf(voxels->store, shown);
    if (!chunks)
        return tl::unexpected(chunks.error());
    VoxelFrame frame = voxelFrame(
        view,
        near,
        shown,
        *chunks,
        voxels->pass.splatsInto(targets.extent()),
        picturesShown(shownWeight(scene)));
    if (castsShadows && shown.casters.empty())
        addCasters(frame, view, shown, sun.box(), *chunks);
    if (castsShadows && !shown.casters.empty()) {
        const core::Result<std::vector<PlacedChunk>> casters =
            placedIn(voxels->store, shown.casters, *shown.tree);
        if (!casters)
            return tl::unexpected(casters.error());
        addCasters(frame, view, shown, sun.box(), *casters);
    }
    frame.stats.uploadedBytes = std::exchange(voxelBytesSinceFrame, 0);
    frame.stats.poolBytesUsed = voxels->store.usedBytes();
    const VoxelStats stats = frame.stats;
    if (frame.chunks.empty())
        return stats;
    if (core::Result<void> ready = voxels->pass.prepare(
            index,
            std::move(frame),
            targets.extent(),
            slots[index].frame,
            voxels->store.buffer(),
            slots[index].owners);
        !ready)
        return tl::unexpected(ready.error());
    return stats;
}

core::Result<std::vector<ShownVoxel>> Renderer::readVoxels()
{
    Parts& parts = *_parts;
    const VkExtent2D extent = parts.targets.extent();
    std::vector<ShownVoxel> shown(std::size_t{extent.width} * extent.height);
    if (!parts.lastVoxels)
        return shown;
    const core::Result<std::vector<std::byte>> bytes =
        parts.copied(parts.voxels->pass.names(), gpu::use::kSampledInFragment);
    if (!bytes)
        return tl::unexpected(bytes.error());
    std::vector<std::uint32_t> names(shown.size());
    std::memcpy(names.data(), bytes->data(), bytes->size());
    const VoxelFrame& frame = parts.voxels->pass.frame(*parts.lastVoxels);
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] != 0)
            shown[i] = voxelNamed(frame, names[i]);
    }
    return shown;
}

core::Result<std::vector<ChunkSight>> Renderer::readSight()
{
    Parts& parts = *_parts;
    std::vector<ChunkSight> sights;
    if (!parts.lastVoxels)
        return sights;
    if (core::Result<void> waited = parts.device->wait(parts.lastSlot->commands.ticket()); !waited)
        return tl::unexpected(waited.error());
    const VoxelFrame& frame = parts.voxels->pass.frame(*parts.lastVoxels);
    const std::span<const std::uint32_t> visible = parts.voxels->pass.visible(*parts.lastVoxels);
    for (std::size_t i = 0; i < visible.size(); ++i)
        sights.push_back({frame.keys[i], visible[i] != 0});
    return sights;
}

core::Result<std::optional<ShownPattern>> Renderer::readPattern()
{
    Parts& parts = *_parts;
    if (!parts.lastVoxels)
        return std::optional<ShownPattern>();
    if (core::Result<void> waited = parts.device->wait(parts.lastSlot->commands.ticket()); !waited)
        return tl::unexpected(waited.error());
    return parts.voxels->pass.pattern(*parts.lastVoxels);
}

} // namespace isofront::render

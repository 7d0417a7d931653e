#include "VoxelPass.h"

#include "IndirectDraws.h"

#include <isofront/gpu/Barriers.h>
#include <isofront/shaders/fullscreenVert.h>
#include <isofront/shaders/voxelBoxFrag.h>
#include <isofront/shaders/voxelBoxVert.h>
#include <isofront/shaders/voxelCubeFadingFrag.h>
#include <isofront/shaders/voxelCubeFrag.h>
#include <isofront/shaders/voxelCubeVert.h>
#include <isofront/shaders/voxelMergeFrag.h>
#include <isofront/shaders/voxelMergeSamplesFrag.h>
#include <isofront/shaders/voxelShadowVert.h>
#include <isofront/shaders/voxelSplatComp.h>
#include <isofront/shaders/voxelSurfaceFrag.h>
#include <isofront/shaders/voxelSurfaceSamplesFrag.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace isofront::render {

namespace {

constexpr std::uint64_t kSplatBytes = sizeof(std::uint64_t); // a sample
constexpr std::uint32_t kBoxCorners = 36;

/// Colours that are kept where nothing is drawn over them.
constexpr gpu::Use kColourChange{
    gpu::use::kColourWrite.stages,
    gpu::use::kColourWrite.access | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT,
    gpu::use::kColourWrite.layout};

struct SplatConstants {
    std::uint32_t firstBlock = 0;
    std::uint32_t blockCount = 0;
    std::uint32_t onlyVisible = 0;
};

/// Makes sure that a buffer which the GPU is done with has so much room.
core::Result<void> reserve(
    gpu::Device& device,
    gpu::Buffer& buffer,
    std::size_t bytes,
    VkBufferUsageFlags usage,
    gpu::MemoryKind kind)
{
    if (buffer.bytes() >= std::max<std::size_t>(bytes, 1))
        return {};
    constexpr std::size_t kLeast = 4096;
    core::Result<gpu::Buffer> larger =
        gpu::Buffer::create(device, std::bit_ceil(std::max(bytes, kLeast)), usage, kind);
    if (!larger)
        return tl::unexpected(larger.error());
    buffer = std::move(*larger);
    return {};
}

std::uint64_t splatBytes(VkExtent2D extent, VkSampleCountFlagBits samples)
{
    return std::uint64_t{extent.width} * extent.height *
           std::uint64_t{static_cast<std::uint32_t>(samples)} * kSplatBytes;
}

template <typename T>
void copyInto(const gpu::Buffer& buffer, const std::vector<T>& values)
{
    if (!values.empty())
        std::memcpy(buffer.mapped().data(), values.data(), values.size() * sizeof(T));
}

} // namespace

core::Result<VoxelPass> VoxelPass::create(
    gpu::Device& device, std::uint32_t slots, bool indirect, VkSampleCountFlagBits samples)
{
    if (!device.storesFromFragments()) {
        return core::failure(
            core::ErrorCode::noDevice,
            "the graphics device can't draw voxels: its fragment shaders write no buffers; try "
            "another device (ISOFRONT_DEVICE=cpu)");
    }
    VoxelPass pass;
    pass._device = &device;
    pass._indirect = indirect;
    pass._samples = samples;
    pass._slots.resize(slots);
    core::Result<gpu::Sampler> sampler = gpu::makeSampler(device, VK_FILTER_NEAREST);
    if (!sampler)
        return tl::unexpected(sampler.error());
    pass._nearest = std::move(*sampler);

    constexpr VkShaderStageFlags kAll =
        VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    constexpr gpu::Binding kBlock{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kAll};
    constexpr gpu::Binding kBuffer{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kAll};
    constexpr gpu::Binding kImage{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER};
    // As in shaders/include/voxel.glsl; then splats, flags of what is visible, and names; and the
    // owners of blocks.
    constexpr std::array kBindings{
        kBlock, kBlock, kBuffer, kBuffer, kBuffer, kBuffer, kBuffer, kImage, kBuffer};
    core::Result<Stage> stage = makeStage(device, kBindings, slots, sizeof(SplatConstants));
    if (!stage)
        return tl::unexpected(stage.error());
    pass._stage = std::move(*stage);
    if (core::Result<void> made = pass.makePipelines(); !made)
        return tl::unexpected(made.error());
    if (core::Result<void> made = pass.makeIndices(); !made)
        return tl::unexpected(made.error());
    return pass;
}

core::Result<void> VoxelPass::makePipelines()
{
    using Code = std::span<const std::uint32_t>;
    const VkPipelineLayout layout = _stage.layout.get();
    const bool many = _samples != VK_SAMPLE_COUNT_1_BIT;
    constexpr std::array kSurfaceFormats{kSurfaceFormat, kColourFormat};
    const std::array wanted{
        std::pair{
            &_cubePipeline,
            gpu::GraphicsPipeline{
                .vertexShader = voxelCubeVert,
                .fragmentShader = voxelCubeFrag,
                .layout = layout,
                .colourFormats = {&kNameFormat, 1},
                .depthFormat = kDepthFormat,
                .samples = _samples}},
        std::pair{
            &_fadingPipeline,
            gpu::GraphicsPipeline{
                .vertexShader = voxelCubeVert,
                .fragmentShader = voxelCubeFadingFrag,
                .layout = layout,
                .colourFormats = {&kNameFormat, 1},
                .depthFormat = kDepthFormat,
                .samples = _samples}},
        std::pair{
            &_mergePipeline,
            gpu::GraphicsPipeline{
                .vertexShader = fullscreenVert,
                .fragmentShader = many ? Code(voxelMergeSamplesFrag) : Code(voxelMergeFrag),
                .layout = layout,
                .colourFormats = {&kNameFormat, 1},
                .depthFormat = kDepthFormat,
                .samples = _samples,
                .shadesSamples = many}},
        std::pair{
            &_boxPipeline,
            gpu::GraphicsPipeline{
                .vertexShader = voxelBoxVert,
                .fragmentShader = voxelBoxFrag,
                .layout = layout,
                .depthFormat = kDepthFormat,
                .writesDepth = false,
                .samples = _samples}},
        std::pair{
            &_shadowPipeline,
            gpu::GraphicsPipeline{
                .vertexShader = voxelShadowVert, .layout = layout, .depthFormat = kDepthFormat}},
        std::pair{
            &_surfacePipeline,
            gpu::GraphicsPipeline{
                .vertexShader = fullscreenVert,
                .fragmentShader = many ? Code(voxelSurfaceSamplesFrag) : Code(voxelSurfaceFrag),
                .layout = layout,
                .colourFormats = kSurfaceFormats,
                .samples = _samples,
                .shadesSamples = many}}};
    for (const auto& [place, description] : wanted) {
        core::Result<gpu::Pipeline> pipeline = gpu::makePipeline(*_device, description);
        if (!pipeline)
            return tl::unexpected(pipeline.error());
        *place = std::move(*pipeline);
    }
    if (!_device->hasLongAtomics())
        return {};
    core::Result<gpu::Pipeline> splats = gpu::makeComputePipeline(*_device, voxelSplatComp, layout);
    if (!splats)
        return tl::unexpected(splats.error());
    _splatPipeline = std::move(*splats);
    return {};
}

core::Result<void> VoxelPass::makeIndices()
{
    // Two triangles for each face, of four corners each.
    constexpr std::array<std::uint16_t, 6> kFace{0, 1, 2, 2, 1, 3};
    std::vector<std::uint16_t> indices;
    for (std::uint32_t corner = 0; corner < kVoxelsInDraw * shared::kCornersOfVoxel; corner += 4) {
        for (const std::uint16_t index : kFace)
            indices.push_back(static_cast<std::uint16_t>(corner + index));
    }
    core::Result<gpu::Buffer> buffer = gpu::Buffer::create(
        *_device,
        indices.size() * sizeof(std::uint16_t),
        VK_BUFFER_USAGE_INDEX_BUFFER_BIT,
        gpu::MemoryKind::upload);
    if (!buffer)
        return tl::unexpected(buffer.error());
    _indices = std::move(*buffer);
    copyInto(_indices, indices);
    return {};
}

bool VoxelPass::splatsInto(VkExtent2D extent) const
{
    return _device->hasLongAtomics() &&
           splatBytes(extent, _samples) <= _device->limits().maxStorageBufferRange;
}

core::Result<void> VoxelPass::resize(VkExtent2D extent)
{
    if (_names.get() != VK_NULL_HANDLE && _names.extent().width == extent.width &&
        _names.extent().height == extent.height)
        return {};
    // Frames in flight draw into what is replaced.
    if (core::Result<void> idle = _device->wait(_device->submitted()); !idle)
        return idle;
    constexpr VkImageUsageFlags kUsage =
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    core::Result<gpu::Image> names = gpu::Image::create(
        *_device,
        extent.width,
        extent.height,
        kNameFormat,
        kUsage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
        _samples);
    if (!names)
        return tl::unexpected(names.error());
    core::Result<gpu::Buffer> splats = gpu::Buffer::create(
        *_device,
        splatsInto(extent) ? splatBytes(extent, _samples) : kSplatBytes,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        gpu::MemoryKind::device);
    if (!splats)
        return tl::unexpected(splats.error());
    _names = std::move(*names);
    _splats = std::move(*splats);
    return {};
}

core::Result<void> VoxelPass::fill(Slot& slot) const
{
    struct Wanted {
        gpu::Buffer* buffer;
        std::size_t bytes;
        VkBufferUsageFlags usage;
        gpu::MemoryKind kind;
    };
    const VoxelFrame& frame = slot.frame;
    const std::size_t flags = frame.keys.size() * sizeof(std::uint32_t);
    constexpr auto kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    constexpr auto kUpload = gpu::MemoryKind::upload;
    const std::array wanted{
        Wanted{&slot.view, sizeof frame.view, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, kUpload},
        Wanted{&slot.chunks, frame.chunks.size() * sizeof(shared::DrawnChunk), kStorage, kUpload},
        Wanted{&slot.blocks, frame.blocks.size() * sizeof(shared::VoxelBlock), kStorage, kUpload},
        Wanted{
            &slot.cubes,
            frame.cubes.size() * sizeof(VkDrawIndexedIndirectCommand),
            VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
            kUpload},
        Wanted{
            &slot.shadows,
            frame.shadows.size() * sizeof(VkDrawIndexedIndirectCommand),
            VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
            kUpload},
        Wanted{
            &slot.visible,
            flags,
            kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            gpu::MemoryKind::device},
        Wanted{&slot.seen, flags, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryKind::readback}};
    for (const Wanted& each : wanted) {
        if (core::Result<void> grown =
                reserve(*_device, *each.buffer, each.bytes, each.usage, each.kind);
            !grown)
            return grown;
    }
    std::memcpy(slot.view.mapped().data(), &frame.view, sizeof frame.view);
    copyInto(slot.chunks, frame.chunks);
    copyInto(slot.blocks, frame.blocks);
    copyInto(slot.cubes, frame.cubes);
    copyInto(slot.shadows, frame.shadows);
    return {};
}

core::Result<void> VoxelPass::prepare(
    std::size_t slot,
    VoxelFrame frame,
    VkExtent2D extent,
    const gpu::Buffer& frameBlock,
    const gpu::Buffer& pool,
    const gpu::Buffer& owners)
{
    if (core::Result<void> sized = resize(extent); !sized)
        return sized;
    if (frame.findsPattern && !_pattern) {
        core::Result<PatternPass> made =
            PatternPass::create(*_device, static_cast<std::uint32_t>(_slots.size()), _samples);
        if (!made)
            return tl::unexpected(made.error());
        _pattern = std::move(*made);
    }
    Slot& mine = _slots[slot];
    mine.frame = std::move(frame);
    if (core::Result<void> filled = fill(mine); !filled)
        return filled;
    _stage.sets.write(
        slot,
        std::array{
            gpu::Bound{.buffer = &frameBlock},
            gpu::Bound{.buffer = &mine.view},
            gpu::Bound{.buffer = &mine.chunks},
            gpu::Bound{.buffer = &mine.blocks},
            gpu::Bound{.buffer = &pool},
            gpu::Bound{.buffer = &_splats},
            gpu::Bound{.buffer = &mine.visible},
            gpu::Bound{.image = &_names, .sampler = _nearest.get()},
            gpu::Bound{.buffer = &owners}});
    return {};
}

void VoxelPass::splat(VkCommandBuffer commands, std::size_t slot) const
{
    const std::uint32_t blocks = _slots[slot].frame.splatBlocks;
    if (blocks == 0)
        return;
    // The frame before may still be merging its own.
    gpu::memoryBarrier(
        commands, {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT}, gpu::use::kTransferWrite);
    vkCmdFillBuffer(commands, _splats.get(), 0, VK_WHOLE_SIZE, 0);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kComputeStorage);
    bindStage(commands, _splatPipeline, _stage, slot, VK_PIPELINE_BIND_POINT_COMPUTE);
    const SplatConstants constants{.firstBlock = 0, .blockCount = blocks, .onlyVisible = 0};
    vkCmdPushConstants(
        commands,
        _stage.layout.get(),
        VK_SHADER_STAGE_COMPUTE_BIT,
        0,
        sizeof constants,
        &constants);
    const std::uint32_t width = std::min(blocks, 32768U);
    vkCmdDispatch(commands, width, (blocks + width - 1) / width, 1);
    gpu::memoryBarrier(commands, gpu::use::kComputeStorage, gpu::use::kStorageRead);
}

void VoxelPass::drawNames(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const
{
    const VoxelFrame& frame = _slots[slot].frame;
    const VkRenderingAttachmentInfo depth = attachment(
        targets.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD);
    const VkRenderingAttachmentInfo names =
        attachment(_names, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR);
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = targets.extent()},
        .layerCount = 1,
        .colorAttachmentCount = 1,
        .pColorAttachments = &names,
        .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands, &info);
    if (frame.splatBlocks > 0) {
        bindStage(commands, _mergePipeline, _stage, slot);
        coverPicture(commands, targets.extent());
    }
    if (!frame.cubes.empty()) {
        bindStage(commands, _cubePipeline, _stage, slot);
        // Which faces are drawn is decided by the shader.
        gpu::setRasterState(commands, targets.extent(), VK_CULL_MODE_NONE);
        vkCmdBindIndexBuffer(commands, _indices.get(), 0, VK_INDEX_TYPE_UINT16);
        const std::size_t steady = frame.cubes.size() - frame.fadingCubes;
        issueDraws(*_device, commands, _slots[slot].cubes, 0, steady, _indirect);
        if (frame.fadingCubes > 0) {
            bindStage(commands, _fadingPipeline, _stage, slot);
            issueDraws(
                *_device, commands, _slots[slot].cubes, steady, frame.fadingCubes, _indirect);
        }
    }
    vkCmdEndRendering(commands);
}

void VoxelPass::drawBoxes(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const
{
    const VoxelFrame& frame = _slots[slot].frame;
    if (frame.boxes == 0)
        return;
    gpu::imageBarrier(commands, targets.depth, gpu::use::kDepthWrite, gpu::use::kDepthWrite);
    const VkRenderingAttachmentInfo depth = attachment(
        targets.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD);
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = targets.extent()},
        .layerCount = 1,
        .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands, &info);
    bindStage(commands, _boxPipeline, _stage, slot);
    gpu::setRasterState(commands, targets.extent(), VK_CULL_MODE_NONE);
    vkCmdDraw(commands, kBoxCorners, frame.boxes, 0, frame.firstBox);
    vkCmdEndRendering(commands);
    gpu::memoryBarrier(commands, gpu::use::kFragmentStorage, gpu::use::kFragmentStorage);
}

void VoxelPass::drawSurface(
    VkCommandBuffer commands, std::size_t slot, const Targets& targets, bool keepsColours) const
{
    gpu::imageBarrier(commands, _names, gpu::use::kColourWrite, gpu::use::kSampledInFragment);
    gpu::imageBarrier(commands, targets.surface, gpu::use::kColourWrite, kColourChange);
    if (keepsColours)
        gpu::imageBarrier(commands, targets.colours, gpu::use::kColourWrite, kColourChange);
    else
        gpu::imageBarrier(
            commands,
            targets.colours,
            gpu::use::kSampledInFragment.discarded(),
            gpu::use::kColourWrite);
    const std::array outputs{
        attachment(
            targets.surface, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD),
        attachment(
            targets.colours,
            VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
            keepsColours ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_DONT_CARE)};
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = targets.extent()},
        .layerCount = 1,
        .colorAttachmentCount = static_cast<std::uint32_t>(outputs.size()),
        .pColorAttachments = outputs.data()};
    vkCmdBeginRendering(commands, &info);
    bindStage(commands, _surfacePipeline, _stage, slot);
    coverPicture(commands, targets.extent());
    vkCmdEndRendering(commands);
}

void VoxelPass::drawShadows(VkCommandBuffer commands, std::size_t slot, VkExtent2D map) const
{
    const Slot& mine = _slots[slot];
    if (mine.frame.shadows.empty())
        return;
    bindStage(commands, _shadowPipeline, _stage, slot);
    gpu::setRasterState(commands, map, VK_CULL_MODE_NONE);
    vkCmdBindIndexBuffer(commands, _indices.get(), 0, VK_INDEX_TYPE_UINT16);
    issueDraws(*_device, commands, mine.shadows, 0, mine.frame.shadows.size(), _indirect);
}

void VoxelPass::record(
    VkCommandBuffer commands, std::size_t slot, const Targets& targets, bool keepsColours) const
{
    const Slot& mine = _slots[slot];
    vkCmdFillBuffer(commands, mine.visible.get(), 0, VK_WHOLE_SIZE, 0);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kFragmentStorage);
    splat(commands, slot);
    gpu::imageBarrier(commands, targets.depth, gpu::use::kDepthWrite, gpu::use::kDepthWrite);
    // The frame before may still read its names, or be copying them.
    constexpr gpu::Use kReadBefore{
        VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT};
    gpu::imageBarrier(commands, _names, kReadBefore, gpu::use::kColourWrite);
    drawNames(commands, slot, targets);
    drawBoxes(commands, slot, targets);
    drawSurface(commands, slot, targets, keepsColours);
    if (mine.frame.findsPattern)
        _pattern->record(commands, slot, _names, targets.depth);

    gpu::memoryBarrier(commands, gpu::use::kFragmentStorage, gpu::use::kTransferRead);
    const VkBufferCopy all{.size = mine.frame.keys.size() * sizeof(std::uint32_t)};
    vkCmdCopyBuffer(commands, mine.visible.get(), mine.seen.get(), 1, &all);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kHostRead);
}

std::optional<ShownPattern> VoxelPass::pattern(std::size_t slot) const
{
    const VoxelFrame& frame = _slots[slot].frame;
    const auto found = frame.findsPattern ? _pattern->found(slot) : std::nullopt;
    if (!found)
        return std::nullopt;
    return ShownPattern{
        .voxel = voxelNamed(frame, found->node.id),
        .node = found->node,
        .voxelPixels = found->voxelPixels};
}

std::span<const std::uint32_t> VoxelPass::visible(std::size_t slot) const
{
    const Slot& mine = _slots[slot];
    return {
        reinterpret_cast<const std::uint32_t*>(mine.seen.mapped().data()), mine.frame.keys.size()};
}

} // namespace isofront::render

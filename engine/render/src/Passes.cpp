#include "Passes.h"

#include <isofront/extractor/CellMesh.h>
#include <isofront/gpu/Barriers.h>
#include <isofront/shaders/antialiasFrag.h>
#include <isofront/shaders/fullscreenVert.h>
#include <isofront/shaders/meshColouredFrag.h>
#include <isofront/shaders/meshColouredVert.h>
#include <isofront/shaders/meshFadingColouredFrag.h>
#include <isofront/shaders/meshFadingColouredVert.h>
#include <isofront/shaders/meshFadingFrag.h>
#include <isofront/shaders/meshFadingVert.h>
#include <isofront/shaders/meshFrag.h>
#include <isofront/shaders/meshVert.h>
#include <isofront/shaders/shadowVert.h>
#include <isofront/shaders/studioFrag.h>
#include <isofront/shaders/studioSamplesFrag.h>
#include <isofront/shaders/terrainFrag.h>
#include <isofront/shaders/terrainSamplesFrag.h>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace isofront::render {

namespace {

using extractor::CellVertex;
static_assert(offsetof(CellVertex, flags) == 6, "flags follow the position in one attribute");

/// Vertices, and their colours if there are some.
constexpr std::array kVertexBindings{
    VkVertexInputBindingDescription{0, sizeof(CellVertex), VK_VERTEX_INPUT_RATE_VERTEX},
    VkVertexInputBindingDescription{1, sizeof(std::uint32_t), VK_VERTEX_INPUT_RATE_VERTEX}};
constexpr std::array kVertexAttributes{
    VkVertexInputAttributeDescription{
        0, 0, VK_FORMAT_R16G16B16A16_UINT, offsetof(CellVertex, position)},
    VkVertexInputAttributeDescription{1, 0, VK_FORMAT_R16G16_SNORM, offsetof(CellVertex, normal)},
    VkVertexInputAttributeDescription{2, 1, VK_FORMAT_R8G8B8A8_UNORM, 0}};

void drawMesh(VkCommandBuffer commands, VkExtent2D extent, const Passes::MeshDraw& draw)
{
    gpu::setRasterState(commands, extent, draw.cull, draw.front);
    const VkBuffer vertices = draw.meshes->get();
    constexpr VkDeviceSize kStart = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &kStart);
    if (draw.colours != nullptr) {
        const VkBuffer colours = draw.colours->get();
        vkCmdBindVertexBuffers(commands, 1, 1, &colours, &kStart);
    }
    vkCmdBindIndexBuffer(commands, vertices, kStart, VK_INDEX_TYPE_UINT16);
    draw.issue(commands);
}

} // namespace

core::Result<Passes> Passes::create(
    gpu::Device& device, std::uint32_t slots, VkSampleCountFlagBits samples, bool coloured)
{
    // The first thing that fails is what is reported; what comes after it is not tried.
    std::optional<core::Error> error;
    const auto take = [&](auto& place, auto&& make) {
        if (error)
            return;
        auto made = make();
        if (made)
            place = std::move(*made);
        else
            error = made.error();
    };

    Passes passes;
    take(passes._nearest, [&] { return gpu::makeSampler(device, VK_FILTER_NEAREST); });
    take(passes._linear, [&] { return gpu::makeSampler(device, VK_FILTER_LINEAR); });

    constexpr gpu::Binding kFrameInFragment{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER};
    constexpr gpu::Binding kImage{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER};
    constexpr std::array kMeshBindings{
        gpu::Binding{
            VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
            VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT},
        gpu::Binding{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_VERTEX_BIT},
        gpu::Binding{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_FRAGMENT_BIT}};
    constexpr std::array kShadeBindings{kFrameInFragment, kImage, kImage, kImage, kImage, kImage};
    constexpr std::array kAntialiasBindings{kFrameInFragment, kImage};
    take(passes._mesh, [&] { return makeStage(device, kMeshBindings, slots); });
    take(passes._shade, [&] { return makeStage(device, kShadeBindings, slots); });
    take(passes._antialias, [&] { return makeStage(device, kAntialiasBindings, slots); });

    using Code = std::span<const std::uint32_t>;
    constexpr std::array kSurfaceFormats{kSurfaceFormat, kColourFormat};
    const std::size_t streams = coloured ? 2 : 1;
    const auto meshPipeline = [&](Code vertex, Code fragment) {
        return gpu::makePipeline(
            device,
            {.vertexShader = vertex,
             .fragmentShader = fragment,
             .layout = passes._mesh.layout.get(),
             .vertexBindings = {kVertexBindings.data(), streams},
             .vertexAttributes = {kVertexAttributes.data(), 1 + streams},
             .colourFormats = {kSurfaceFormats.data(), streams},
             .depthFormat = kDepthFormat,
             .samples = samples});
    };
    take(passes._meshPipeline, [&] {
        return coloured ? meshPipeline(meshColouredVert, meshColouredFrag)
                        : meshPipeline(meshVert, meshFrag);
    });
    take(passes._fadingPipeline, [&] {
        return coloured ? meshPipeline(meshFadingColouredVert, meshFadingColouredFrag)
                        : meshPipeline(meshFadingVert, meshFadingFrag);
    });
    take(passes._shadowPipeline, [&] {
        return gpu::makePipeline(
            device,
            {.vertexShader = shadowVert,
             .layout = passes._mesh.layout.get(),
             .vertexBindings = {kVertexBindings.data(), 1},
             .vertexAttributes = {kVertexAttributes.data(), 1},
             .depthFormat = kDepthFormat});
    });
    const auto screenPipeline = [&](const Stage& stage, std::span<const std::uint32_t> shader) {
        return gpu::makePipeline(
            device,
            {.vertexShader = fullscreenVert,
             .fragmentShader = shader,
             .layout = stage.layout.get(),
             .colourFormats = {&kPictureFormat, 1}});
    };
    const bool many = samples != VK_SAMPLE_COUNT_1_BIT;
    const auto lookPipeline = [&](Code one, Code several) {
        return screenPipeline(passes._shade, many ? several : one);
    };
    take(passes._terrainPipeline, [&] { return lookPipeline(terrainFrag, terrainSamplesFrag); });
    take(passes._studioPipeline, [&] { return lookPipeline(studioFrag, studioSamplesFrag); });
    take(passes._antialiasPipeline, [&] {
        return screenPipeline(passes._antialias, antialiasFrag);
    });
    if (error)
        return tl::unexpected(*error);
    return passes;
}

void Passes::bind(
    std::size_t slot,
    const gpu::Buffer& frame,
    const gpu::Buffer& cells,
    const gpu::Buffer& owners,
    const Targets& targets,
    const gpu::Image& colours,
    const gpu::Image& shadowMap,
    const gpu::Image& formerShadowMap) const
{
    const gpu::Bound frameBound{.buffer = &frame};
    const auto read = [&](const gpu::Image& image) {
        return gpu::Bound{.image = &image, .sampler = _nearest.get()};
    };
    _mesh.sets.write(
        slot, std::array{frameBound, gpu::Bound{.buffer = &cells}, gpu::Bound{.buffer = &owners}});
    _shade.sets.write(
        slot,
        std::array{
            frameBound,
            read(targets.depth),
            read(targets.surface),
            read(shadowMap),
            read(colours),
            read(formerShadowMap)});
    _antialias.sets.write(
        slot,
        std::array{frameBound, gpu::Bound{.image = &targets.shaded, .sampler = _linear.get()}});
}

void Passes::drawShadows(
    VkCommandBuffer commands,
    std::size_t slot,
    const gpu::Image& map,
    const MeshDraw& draw,
    const std::function<void()>& others) const
{
    gpu::imageBarrier(
        commands, map, gpu::use::kSampledInFragment.discarded(), gpu::use::kDepthWrite);
    const VkRenderingAttachmentInfo depth =
        attachment(map, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR);
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = map.extent()},
        .layerCount = 1,
        .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands, &info);
    bindStage(commands, _shadowPipeline, _mesh, slot);
    drawMesh(commands, map.extent(), draw);
    others();
    vkCmdEndRendering(commands);
    gpu::imageBarrier(commands, map, gpu::use::kDepthWrite, gpu::use::kSampledInFragment);
}

void Passes::skipShadows(VkCommandBuffer commands, const gpu::Image& map)
{
    gpu::imageBarrier(
        commands, map, gpu::use::kSampledInFragment.discarded(), gpu::use::kSampledInFragment);
}

void Passes::drawMeshes(
    VkCommandBuffer commands, std::size_t slot, const Targets& targets, const MeshDraw& draw) const
{
    // The frame before may still read what this one overwrites, or be copying it.
    constexpr gpu::Use kReadBefore{
        VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT};
    gpu::imageBarrier(commands, targets.depth, kReadBefore, gpu::use::kDepthWrite);
    gpu::imageBarrier(commands, targets.surface, kReadBefore, gpu::use::kColourWrite);

    // Reversed depth: what is cleared lies infinitely far away.
    VkRenderingAttachmentInfo depth = attachment(
        targets.depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_CLEAR);
    depth.clearValue.depthStencil = {0.0F, 0};
    std::vector<VkRenderingAttachmentInfo> outputs{attachment(
        targets.surface,
        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
        VK_ATTACHMENT_LOAD_OP_DONT_CARE)};
    if (draw.colours != nullptr) {
        gpu::imageBarrier(
            commands,
            targets.colours,
            gpu::use::kSampledInFragment.discarded(),
            gpu::use::kColourWrite);
        outputs.push_back(attachment(
            targets.colours,
            VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
            VK_ATTACHMENT_LOAD_OP_DONT_CARE));
    }
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = targets.extent()},
        .layerCount = 1,
        .colorAttachmentCount = static_cast<std::uint32_t>(outputs.size()),
        .pColorAttachments = outputs.data(),
        .pDepthAttachment = &depth};
    vkCmdBeginRendering(commands, &info);
    bindStage(commands, _meshPipeline, _mesh, slot);
    drawMesh(commands, targets.extent(), draw);
    if (draw.issueFading) {
        bindStage(commands, _fadingPipeline, _mesh, slot);
        draw.issueFading(commands);
    }
    vkCmdEndRendering(commands);
}

void Passes::fillScreen(
    VkCommandBuffer commands,
    const Stage& stage,
    const gpu::Pipeline& pipeline,
    std::size_t slot,
    const gpu::Image& target)
{
    const VkRenderingAttachmentInfo colour = attachment(
        target, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ATTACHMENT_LOAD_OP_DONT_CARE);
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = target.extent()},
        .layerCount = 1,
        .colorAttachmentCount = 1,
        .pColorAttachments = &colour};
    vkCmdBeginRendering(commands, &info);
    bindStage(commands, pipeline, stage, slot);
    coverPicture(commands, target.extent());
    vkCmdEndRendering(commands);
}

void Passes::shade(
    VkCommandBuffer commands,
    std::size_t slot,
    const Targets& targets,
    Look look,
    bool last,
    bool hasColours) const
{
    if (hasColours)
        gpu::imageBarrier(
            commands, targets.colours, gpu::use::kColourWrite, gpu::use::kSampledInFragment);
    gpu::imageBarrier(commands, targets.depth, gpu::use::kDepthWrite, gpu::use::kSampledInFragment);
    gpu::imageBarrier(
        commands, targets.surface, gpu::use::kColourWrite, gpu::use::kSampledInFragment);
    const gpu::Image& target = last ? targets.picture : targets.shaded;
    const gpu::Use before = last ? gpu::use::kTransferRead : gpu::use::kSampledInFragment;
    gpu::imageBarrier(commands, target, before.discarded(), gpu::use::kColourWrite);
    const gpu::Pipeline& pipeline = look == Look::terrain ? _terrainPipeline : _studioPipeline;
    fillScreen(commands, _shade, pipeline, slot, target);
}

void Passes::antialias(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const
{
    gpu::imageBarrier(
        commands, targets.shaded, gpu::use::kColourWrite, gpu::use::kSampledInFragment);
    gpu::imageBarrier(
        commands, targets.picture, gpu::use::kTransferRead.discarded(), gpu::use::kColourWrite);
    fillScreen(commands, _antialias, _antialiasPipeline, slot, targets.picture);
}

void Passes::finish(VkCommandBuffer commands, const Targets& targets)
{
    gpu::imageBarrier(commands, targets.picture, gpu::use::kColourWrite, gpu::use::kTransferRead);
}

} // namespace isofront::render

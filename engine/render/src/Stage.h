#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Descriptors.h>
#include <isofront/gpu/Image.h>
#include <isofront/gpu/Pipeline.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace isofront::render {

/// What pipelines share that read the same things: one descriptor set for each frame in flight.
struct Stage {
    gpu::DescriptorSets sets;
    gpu::PipelineLayout layout;
};

/// @param constants  bytes that may be pushed to its compute shaders
core::Result<Stage> makeStage(
    gpu::Device& device,
    std::span<const gpu::Binding> bindings,
    std::uint32_t slots,
    std::uint32_t constants = 0);

/// An image to draw into; what is drawn is kept.
VkRenderingAttachmentInfo
attachment(const gpu::Image& image, VkImageLayout layout, VkAttachmentLoadOp load);

/// Makes a pipeline current, with a slot's descriptor set.
void bindStage(
    VkCommandBuffer commands,
    const gpu::Pipeline& pipeline,
    const Stage& stage,
    std::size_t slot,
    VkPipelineBindPoint point = VK_PIPELINE_BIND_POINT_GRAPHICS);

/// Draws one triangle over the whole picture.
void coverPicture(VkCommandBuffer commands, VkExtent2D extent);

} // namespace isofront::render

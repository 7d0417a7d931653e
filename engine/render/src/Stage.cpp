#include "Stage.h"

#include <utility>

namespace isofront::render {

core::Result<Stage> makeStage(
    gpu::Device& device,
    std::span<const gpu::Binding> bindings,
    std::uint32_t slots,
    std::uint32_t constants)
{
    core::Result<gpu::DescriptorSets> sets = gpu::DescriptorSets::create(device, bindings, slots);
    if (!sets)
        return tl::unexpected(sets.error());
    core::Result<gpu::PipelineLayout> layout =
        gpu::makePipelineLayout(device, sets->layout(), constants);
    if (!layout)
        return tl::unexpected(layout.error());
    return Stage{std::move(*sets), std::move(*layout)};
}

VkRenderingAttachmentInfo
attachment(const gpu::Image& image, VkImageLayout layout, VkAttachmentLoadOp load)
{
    return {
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = image.view(),
        .imageLayout = layout,
        .loadOp = load,
        .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

void bindStage(
    VkCommandBuffer commands,
    const gpu::Pipeline& pipeline,
    const Stage& stage,
    std::size_t slot,
    VkPipelineBindPoint point)
{
    const VkDescriptorSet set = stage.sets.set(slot);
    vkCmdBindPipeline(commands, point, pipeline.get());
    vkCmdBindDescriptorSets(commands, point, stage.layout.get(), 0, 1, &set, 0, nullptr);
}

void coverPicture(VkCommandBuffer commands, VkExtent2D extent)
{
    gpu::setRasterState(commands, extent, VK_CULL_MODE_NONE);
    vkCmdDraw(commands, 3, 1, 0, 0);
}

} // namespace isofront::render

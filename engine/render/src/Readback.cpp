#include "Readback.h"

#include "Stage.h"

#include <isofront/gpu/Buffer.h>

#include <utility>

namespace isofront::render {

namespace {

/// Takes the first sample of each pixel.
/// @param to  of the same size and format, one sample a pixel
/// @return how that was used
gpu::Use takeFirstSamples(
    VkCommandBuffer commands, const gpu::Image& image, const gpu::Use& now, const gpu::Image& to)
{
    const bool isDepth = image.aspect() == VK_IMAGE_ASPECT_DEPTH_BIT;
    // Samples are taken where colours are written, those of depth too.
    const gpu::Use use{
        gpu::use::kColourWrite.stages | gpu::use::kDepthWrite.stages,
        gpu::use::kColourWrite.access | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT |
            gpu::use::kDepthWrite.access,
        isDepth ? gpu::use::kDepthWrite.layout : gpu::use::kColourWrite.layout};
    gpu::imageBarrier(commands, image, now, use);
    gpu::imageBarrier(commands, to, {}, use);
    VkRenderingAttachmentInfo taken = attachment(image, use.layout, VK_ATTACHMENT_LOAD_OP_LOAD);
    taken.resolveMode = VK_RESOLVE_MODE_SAMPLE_ZERO_BIT;
    taken.resolveImageView = to.view();
    taken.resolveImageLayout = use.layout;
    const VkRenderingInfo info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
        .renderArea = {.extent = image.extent()},
        .layerCount = 1,
        .colorAttachmentCount = isDepth ? 0U : 1U,
        .pColorAttachments = isDepth ? nullptr : &taken,
        .pDepthAttachment = isDepth ? &taken : nullptr};
    vkCmdBeginRendering(commands, &info);
    vkCmdEndRendering(commands);
    gpu::imageBarrier(commands, image, use, now);
    return use;
}

} // namespace

core::Result<std::vector<std::byte>> copiedImage(
    gpu::Device& device, gpu::Commands& copying, const gpu::Image& image, const gpu::Use& now)
{
    const VkExtent2D extent = image.extent();
    const std::size_t bytes = std::size_t{extent.width} * extent.height * 4;
    core::Result<gpu::Buffer> target = gpu::Buffer::create(
        device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryKind::readback);
    if (!target)
        return tl::unexpected(target.error());
    const bool hasSamples = image.samples() != VK_SAMPLE_COUNT_1_BIT;
    gpu::Image first;
    if (hasSamples) {
        core::Result<gpu::Image> made =
            gpu::Image::create(device, extent.width, extent.height, image.format(), image.usage());
        if (!made)
            return tl::unexpected(made.error());
        first = std::move(*made);
    }
    if (core::Result<void> begun = copying.begin(); !begun)
        return tl::unexpected(begun.error());
    const VkCommandBuffer commands = copying.get();
    const gpu::Image& source = hasSamples ? first : image;
    const gpu::Use use = hasSamples ? takeFirstSamples(commands, image, now, first) : now;
    gpu::imageBarrier(commands, source, use, gpu::use::kTransferRead);
    const VkBufferImageCopy region{
        .imageSubresource = {source.aspect(), 0, 0, 1},
        .imageExtent = {extent.width, extent.height, 1}};
    vkCmdCopyImageToBuffer(
        commands, source.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target->get(), 1, &region);
    gpu::imageBarrier(commands, source, gpu::use::kTransferRead, use);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kHostRead);
    const core::Result<gpu::Device::Ticket> ticket = copying.submit();
    if (!ticket)
        return tl::unexpected(ticket.error());
    if (core::Result<void> waited = device.wait(*ticket); !waited)
        return tl::unexpected(waited.error());
    const std::span<const std::byte> mapped = target->mapped();
    return std::vector<std::byte>(mapped.begin(), mapped.end());
}

} // namespace isofront::render

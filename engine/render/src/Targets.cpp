#include "Targets.h"

#include <utility>

namespace isofront::render {

core::Result<Targets> Targets::create(
    gpu::Device& device, std::uint32_t width, std::uint32_t height, VkSampleCountFlagBits samples)
{
    struct Wanted {
        gpu::Image Targets::*image;
        VkFormat format;
        VkImageUsageFlags usage;
        VkSampleCountFlagBits samples;
    };
    constexpr VkImageUsageFlags kColour =
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const Wanted all[] = {
        {&Targets::depth,
         kDepthFormat,
         VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
             VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
         samples},
        {&Targets::surface, kSurfaceFormat, kColour, samples},
        {&Targets::shaded, kPictureFormat, kColour, VK_SAMPLE_COUNT_1_BIT},
        {&Targets::picture,
         kPictureFormat,
         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
         VK_SAMPLE_COUNT_1_BIT},
    };
    Targets targets;
    for (const Wanted& wanted : all) {
        core::Result<gpu::Image> image =
            gpu::Image::create(device, width, height, wanted.format, wanted.usage, wanted.samples);
        if (!image)
            return tl::unexpected(image.error());
        targets.*wanted.image = std::move(*image);
    }
    targets._samples = samples;
    return targets;
}

core::Result<void> Targets::needColours(gpu::Device& device)
{
    if (colours.get() != VK_NULL_HANDLE)
        return {};
    core::Result<gpu::Image> image = gpu::Image::create(
        device,
        extent().width,
        extent().height,
        kColourFormat,
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
        _samples);
    if (!image)
        return tl::unexpected(image.error());
    colours = std::move(*image);
    return {};
}

} // namespace isofront::render

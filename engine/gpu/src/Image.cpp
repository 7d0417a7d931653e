#include "isofront/gpu/Image.h"

#include "isofront/gpu/Check.h"

#include <isofront/core/Assert.h>

#include <utility>

namespace isofront::gpu {

core::Result<Image> Image::create(
    Device& device,
    std::uint32_t width,
    std::uint32_t height,
    VkFormat format,
    VkImageUsageFlags usage,
    VkSampleCountFlagBits samples)
{
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    ISOFRONT_ASSERT(
        width > 0 && height > 0 && width <= device.limits().maxImageDimension2D &&
            height <= device.limits().maxImageDimension2D,
        "an image of " + size + " pixels");
    Image image;
    image._device = &device;
    image._format = format;
    image._extent = {width, height};
    image._usage = usage;
    image._samples = samples;
    const VkImageCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {width, height, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = samples,
        .tiling = VK_IMAGE_TILING_OPTIMAL,
        .usage = usage};
    ISOFRONT_VK(
        vkCreateImage(device.handle(), &info, nullptr, &image._image),
        "create an image of " + size + " pixels");
    VkMemoryRequirements requirements{};
    vkGetImageMemoryRequirements(device.handle(), image._image, &requirements);
    const core::Result<VkDeviceMemory> memory =
        device.allocate(requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (!memory)
        return tl::unexpected(memory.error());
    image._memory = *memory;
    image._allocated = requirements.size;
    ISOFRONT_VK(
        vkBindImageMemory(device.handle(), image._image, image._memory, 0),
        "bind an image to its memory");
    const VkImageViewCreateInfo view{
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image._image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format,
        .subresourceRange = {image.aspect(), 0, 1, 0, 1}};
    ISOFRONT_VK(
        vkCreateImageView(device.handle(), &view, nullptr, &image._view), "create an image view");
    return image;
}

Image::~Image()
{
    if (_view != VK_NULL_HANDLE)
        vkDestroyImageView(_device->handle(), _view, nullptr);
    if (_image != VK_NULL_HANDLE)
        vkDestroyImage(_device->handle(), _image, nullptr);
    if (_memory != VK_NULL_HANDLE)
        _device->free(_memory, _allocated);
}

VkImageAspectFlags Image::aspect() const
{
    const bool depth = _format == VK_FORMAT_D32_SFLOAT || _format == VK_FORMAT_D16_UNORM;
    return depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

void Image::swap(Image& other) noexcept
{
    std::swap(_device, other._device);
    std::swap(_image, other._image);
    std::swap(_view, other._view);
    std::swap(_memory, other._memory);
    std::swap(_allocated, other._allocated);
    std::swap(_format, other._format);
    std::swap(_extent, other._extent);
    std::swap(_usage, other._usage);
    std::swap(_samples, other._samples);
}

VkSampleCountFlags sampleCounts(const Device& device, VkFormat format, VkImageUsageFlags usage)
{
    if (!device.shadesSamples())
        return VK_SAMPLE_COUNT_1_BIT;
    VkImageFormatProperties properties{};
    const VkResult found = vkGetPhysicalDeviceImageFormatProperties(
        device.physical(),
        format,
        VK_IMAGE_TYPE_2D,
        VK_IMAGE_TILING_OPTIMAL,
        usage,
        0,
        &properties);
    if (found != VK_SUCCESS)
        return VK_SAMPLE_COUNT_1_BIT;
    return properties.sampleCounts;
}

} // namespace isofront::gpu

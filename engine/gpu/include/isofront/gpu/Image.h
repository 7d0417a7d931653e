#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>

#include <cstdint>

namespace isofront::gpu {

/// A two-dimensional image of one level, with memory and a view of its own. Move-only; the device
/// must outlive it.
class Image {
public:
    Image() = default;
    /// @param width, height  [px], from 1 to the device's limit (asserted)
    /// @param samples  of each pixel, as sampleCounts has them
    static core::Result<Image> create(
        Device& device,
        std::uint32_t width,
        std::uint32_t height,
        VkFormat format,
        VkImageUsageFlags usage,
        VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT);
    Image(Image&& other) noexcept { swap(other); }
    Image& operator=(Image&& other) noexcept
    {
        swap(other);
        return *this;
    }
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;
    ~Image();

    [[nodiscard]] VkImage get() const { return _image; }
    [[nodiscard]] VkImageView view() const { return _view; }
    [[nodiscard]] VkFormat format() const { return _format; }
    [[nodiscard]] VkExtent2D extent() const { return _extent; }
    [[nodiscard]] VkImageUsageFlags usage() const { return _usage; }
    [[nodiscard]] VkSampleCountFlagBits samples() const { return _samples; }
    /// Depth for depth formats, otherwise colour.
    [[nodiscard]] VkImageAspectFlags aspect() const;

private:
    void swap(Image& other) noexcept;

    Device* _device = nullptr;
    VkImage _image = VK_NULL_HANDLE;
    VkImageView _view = VK_NULL_HANDLE;
    VkDeviceMemory _memory = VK_NULL_HANDLE;
    VkDeviceSize _allocated = 0;
    VkFormat _format = VK_FORMAT_UNDEFINED;
    VkExtent2D _extent{};
    VkImageUsageFlags _usage = 0;
    VkSampleCountFlagBits _samples = VK_SAMPLE_COUNT_1_BIT;
};

/// How many samples a pixel images of a format and use may have on a device, one bit for each
/// number; only one where samples don't lie at Vulkan's standard places, or shaders can't run for
/// each.
VkSampleCountFlags sampleCounts(const Device& device, VkFormat format, VkImageUsageFlags usage);

} // namespace isofront::gpu

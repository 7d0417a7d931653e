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
    static core::Result<Image> create(
        Device& device,
        std::uint32_t width,
        std::uint32_t height,
        VkFormat format,
        VkImageUsageFlags usage);
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
};

} // namespace isofront::gpu

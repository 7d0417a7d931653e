#pragma once

#include <vulkan/vulkan_core.h>

#include <utility>

namespace isofront::gpu {

/// Owns one Vulkan object that a device made. Move-only; empty after a move and by default.
///
/// The device must outlive it, and the GPU must be done with it when it is destroyed.
template <typename T, auto Destroy>
class Handle {
public:
    Handle() = default;
    Handle(VkDevice device, T object) : _device(device), _object(object) {}
    Handle(Handle&& other) noexcept
        : _device(std::exchange(other._device, VK_NULL_HANDLE)),
          _object(std::exchange(other._object, VK_NULL_HANDLE))
    {
    }
    Handle& operator=(Handle&& other) noexcept
    {
        std::swap(_device, other._device);
        std::swap(_object, other._object);
        return *this;
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle()
    {
        if (_object != VK_NULL_HANDLE)
            Destroy(_device, _object, nullptr);
    }

    [[nodiscard]] T get() const { return _object; }
    [[nodiscard]] explicit operator bool() const { return _object != VK_NULL_HANDLE; }

private:
    VkDevice _device = VK_NULL_HANDLE;
    T _object = VK_NULL_HANDLE;
};

using Sampler = Handle<VkSampler, vkDestroySampler>;
using PipelineLayout = Handle<VkPipelineLayout, vkDestroyPipelineLayout>;
using Pipeline = Handle<VkPipeline, vkDestroyPipeline>;
using Semaphore = Handle<VkSemaphore, vkDestroySemaphore>;

} // namespace isofront::gpu

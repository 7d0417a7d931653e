#pragma once

#include "isofront/gpu/DeviceChoice.h"

#include <isofront/core/Result.h>

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isofront::gpu {

/// The link to the Vulkan loader, and the ear for its validation layers.
class Instance {
public:
    static core::Result<std::unique_ptr<Instance>> create(bool validation);
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;
    ~Instance();

    [[nodiscard]] VkInstance handle() const { return _instance; }
    [[nodiscard]] core::Result<std::vector<VkPhysicalDevice>> devices() const;
    [[nodiscard]] std::vector<std::string> messages() const;
    void clearMessages();
    /// Called by the validation layers, on any thread.
    void hear(const char* message);

private:
    Instance() = default;

    VkInstance _instance = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT _messenger = VK_NULL_HANDLE;
    mutable std::mutex _mutex;
    std::vector<std::string> _messages;
};

/// What is to be known of a device before it is opened, with the obstacles to using it.
DeviceDescription describe(VkPhysicalDevice device);

/// The family of queues that can do everything we need; nothing if there is none.
struct QueueFamily {
    std::uint32_t index = 0;
    std::uint32_t timestampBits = 0;
    bool found = false;
};
QueueFamily queueFamilyOf(VkPhysicalDevice device);

} // namespace isofront::gpu

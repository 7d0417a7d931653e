#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/DeviceChoice.h>

#include <vulkan/vulkan_core.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isofront::gpu {

class Instance;

struct DeviceOptions {
    /// Which device, as `chooseDevice` says. Empty: what the environment variable ISOFRONT_DEVICE
    /// says, or else the best one.
    std::string device{};
    /// Checks every call, synchronisation included. Slow: for tests. Needs the package
    /// vulkan-validationlayers.
    bool validation = false;
};

/// A Vulkan 1.3 device with one queue for everything, and the clock of that queue.
///
/// Every submission gets a ticket, a number that grows by one each time; when a ticket is complete,
/// so are all before it. What the GPU may still read is freed or overwritten only after the ticket
/// of its last use.
///
/// Thread: one at a time, except `validationMessages` and `allocatedBytes`.
class Device {
public:
    using Ticket = std::uint64_t;

    /// @return noDevice if there is no device that fits, or no validation layer where it is wanted
    static core::Result<std::unique_ptr<Device>> create(const DeviceOptions& options = {});
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    /// Waits until the GPU is idle.
    ~Device();

    [[nodiscard]] VkDevice handle() const { return _device; }
    [[nodiscard]] VkPhysicalDevice physical() const { return _physical; }
    [[nodiscard]] std::uint32_t queueFamily() const { return _queueFamily; }
    [[nodiscard]] const DeviceDescription& description() const { return _description; }
    [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return _limits; }
    [[nodiscard]] const VkPhysicalDeviceMemoryProperties& memory() const { return _memory; }
    /// True if one indirect call can issue many draws, each with its own first instance.
    [[nodiscard]] bool drawsManyIndirectly() const { return _drawsManyIndirectly; }
    /// True if shaders can take the greatest of 64-bit numbers in buffers, by many threads at once.
    [[nodiscard]] bool hasLongAtomics() const { return _longAtomics; }
    /// True if fragment shaders can write to buffers.
    [[nodiscard]] bool storesFromFragments() const { return _fragmentStores; }
    /// True if fragment shaders can run for each sample of a pixel, and the samples lie at Vulkan's
    /// standard places.
    [[nodiscard]] bool shadesSamples() const { return _samples; }
    /// Whether timestamps can be written to the queue's command buffers.
    [[nodiscard]] bool hasTimestamps() const { return _timestampBits != 0; }
    /// How many of a timestamp's bits count.
    [[nodiscard]] std::uint32_t timestampBits() const { return _timestampBits; }

    /// Hands a recorded command buffer to the queue.
    core::Result<Ticket> submit(VkCommandBuffer commands);
    /// The ticket of the last submission; 0 before the first.
    [[nodiscard]] Ticket submitted() const { return _submitted; }
    /// The last ticket that is complete.
    [[nodiscard]] core::Result<Ticket> completed() const;
    /// Waits until a ticket is complete, at most two minutes.
    [[nodiscard]] core::Result<void> wait(Ticket ticket) const;

    /// What the validation layers have complained about so far, each in one string.
    [[nodiscard]] std::vector<std::string> validationMessages() const;
    /// Forgets the messages so far.
    void clearValidationMessages();

    /// Device memory held by buffers and images now [bytes].
    [[nodiscard]] std::uint64_t allocatedBytes() const { return _allocatedBytes; }
    /// Allocates memory for a resource from the first type that has all the wanted properties.
    /// Counts it; to be given back through `free`.
    core::Result<VkDeviceMemory>
    allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties);
    void free(VkDeviceMemory memory, std::uint64_t bytes);
    /// True if some memory type has all these properties.
    [[nodiscard]] bool hasMemory(VkMemoryPropertyFlags properties) const;

private:
    explicit Device(std::unique_ptr<Instance> instance);
    core::Result<void> open(VkPhysicalDevice physical, DeviceDescription description);

    std::unique_ptr<Instance> _instance;
    VkPhysicalDevice _physical = VK_NULL_HANDLE;
    VkDevice _device = VK_NULL_HANDLE;
    VkQueue _queue = VK_NULL_HANDLE;
    VkSemaphore _timeline = VK_NULL_HANDLE;
    DeviceDescription _description;
    VkPhysicalDeviceLimits _limits{};
    VkPhysicalDeviceMemoryProperties _memory{};
    std::uint32_t _queueFamily = 0;
    std::uint32_t _timestampBits = 0;
    bool _drawsManyIndirectly = false;
    bool _longAtomics = false;
    bool _fragmentStores = false;
    bool _samples = false;
    Ticket _submitted = 0;
    std::atomic<std::uint64_t> _allocatedBytes = 0;
};

} // namespace isofront::gpu

#include "isofront/gpu/Device.h"

#include "Instance.h"
#include "isofront/gpu/Check.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace isofront::gpu {

namespace {

constexpr std::uint64_t kWaitNanoseconds = 120'000'000'000ULL;

std::string wantedDevice(const DeviceOptions& options)
{
    if (!options.device.empty())
        return options.device;
    const char* fromEnvironment = std::getenv("ISOFRONT_DEVICE"); // NOLINT(concurrency-mt-unsafe)
    return fromEnvironment != nullptr ? fromEnvironment : "";
}

} // namespace

Device::Device(std::unique_ptr<Instance> instance) : _instance(std::move(instance)) {}

core::Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options)
{
    core::Result<std::unique_ptr<Instance>> instance = Instance::create(options.validation);
    if (!instance)
        return tl::unexpected(instance.error());
    const core::Result<std::vector<VkPhysicalDevice>> physical = (*instance)->devices();
    if (!physical)
        return tl::unexpected(physical.error());
    std::vector<DeviceDescription> descriptions;
    std::transform(physical->begin(), physical->end(), std::back_inserter(descriptions), describe);
    const core::Result<std::size_t> choice = chooseDevice(descriptions, wantedDevice(options));
    if (!choice)
        return tl::unexpected(choice.error());

    std::unique_ptr<Device> device(new Device(std::move(*instance)));
    const core::Result<void> opened = device->open((*physical)[*choice], descriptions[*choice]);
    if (!opened)
        return tl::unexpected(opened.error());
    return device;
}

core::Result<void> Device::open(VkPhysicalDevice physical, DeviceDescription description)
{
    _physical = physical;
    _description = std::move(description);
    const QueueFamily family = queueFamilyOf(physical);
    _queueFamily = family.index;
    _timestampBits = family.timestampBits;
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(physical, &properties);
    _limits = properties.limits;
    vkGetPhysicalDeviceMemoryProperties(physical, &_memory);

    VkPhysicalDeviceVulkan12Features present12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceFeatures2 allPresent{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &present12};
    vkGetPhysicalDeviceFeatures2(physical, &allPresent);
    const VkPhysicalDeviceFeatures& present = allPresent.features;
    _drawsManyIndirectly =
        present.multiDrawIndirect != VK_FALSE && present.drawIndirectFirstInstance != VK_FALSE;
    _fragmentStores = present.fragmentStoresAndAtomics != VK_FALSE;
    _samples = present.sampleRateShading != VK_FALSE && _limits.standardSampleLocations != VK_FALSE;
    _longAtomics =
        present.shaderInt64 != VK_FALSE && present12.shaderBufferInt64Atomics != VK_FALSE;
    const VkBool32 longAtomics = _longAtomics ? VK_TRUE : VK_FALSE;

    VkPhysicalDeviceVulkan13Features features13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
        .synchronization2 = VK_TRUE,
        .dynamicRendering = VK_TRUE,
        .maintenance4 = VK_TRUE}; // every 1.3 device has it
    VkPhysicalDeviceVulkan12Features features12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .pNext = &features13,
        .shaderBufferInt64Atomics = longAtomics,
        .timelineSemaphore = VK_TRUE};
    const VkPhysicalDeviceFeatures2 features{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
        .pNext = &features12,
        .features = {
            .sampleRateShading = present.sampleRateShading,
            .multiDrawIndirect = present.multiDrawIndirect,
            .drawIndirectFirstInstance = present.drawIndirectFirstInstance,
            .fragmentStoresAndAtomics = present.fragmentStoresAndAtomics,
            .shaderInt64 = longAtomics}};
    const float priority = 1.0F;
    const VkDeviceQueueCreateInfo queue{
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = _queueFamily,
        .queueCount = 1,
        .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .pNext = &features,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue};
    ISOFRONT_VK(vkCreateDevice(physical, &info, nullptr, &_device), "be opened");
    vkGetDeviceQueue(_device, _queueFamily, 0, &_queue);

    const VkSemaphoreTypeCreateInfo timelineType{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
        .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo timeline{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &timelineType};
    ISOFRONT_VK(
        vkCreateSemaphore(_device, &timeline, nullptr, &_timeline), "create a timeline semaphore");
    return {};
}

Device::~Device()
{
    if (_device == VK_NULL_HANDLE)
        return;
    vkDeviceWaitIdle(_device);
    if (_timeline != VK_NULL_HANDLE)
        vkDestroySemaphore(_device, _timeline, nullptr);
    vkDestroyDevice(_device, nullptr);
}

core::Result<Device::Ticket> Device::submit(VkCommandBuffer commands)
{
    const VkCommandBufferSubmitInfo buffer{
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = commands};
    const VkSemaphoreSubmitInfo signal{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
        .semaphore = _timeline,
        .value = _submitted + 1,
        .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    const VkSubmitInfo2 info{
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
        .commandBufferInfoCount = 1,
        .pCommandBufferInfos = &buffer,
        .signalSemaphoreInfoCount = 1,
        .pSignalSemaphoreInfos = &signal};
    ISOFRONT_VK(vkQueueSubmit2(_queue, 1, &info, VK_NULL_HANDLE), "accept work");
    return ++_submitted;
}

core::Result<Device::Ticket> Device::completed() const
{
    Ticket ticket = 0;
    ISOFRONT_VK(vkGetSemaphoreCounterValue(_device, _timeline, &ticket), "tell its progress");
    return ticket;
}

core::Result<void> Device::wait(Ticket ticket) const
{
    ISOFRONT_ASSERT(
        ticket <= _submitted, "waits for ticket " + std::to_string(ticket) + ", not submitted yet");
    const VkSemaphoreWaitInfo info{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
        .semaphoreCount = 1,
        .pSemaphores = &_timeline,
        .pValues = &ticket};
    ISOFRONT_VK(vkWaitSemaphores(_device, &info, kWaitNanoseconds), "finish its work");
    return {};
}

std::vector<std::string> Device::validationMessages() const
{
    return _instance->messages();
}

void Device::clearValidationMessages()
{
    _instance->clearMessages();
}

core::Result<VkDeviceMemory>
Device::allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties)
{
    for (std::uint32_t type = 0; type < _memory.memoryTypeCount; ++type) {
        const bool allowed = (requirements.memoryTypeBits & (1U << type)) != 0;
        const bool fits = (_memory.memoryTypes[type].propertyFlags & properties) == properties;
        if (!allowed || !fits)
            continue;
        const VkMemoryAllocateInfo info{
            .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
            .allocationSize = requirements.size,
            .memoryTypeIndex = type};
        VkDeviceMemory memory = VK_NULL_HANDLE;
        ISOFRONT_VK(
            vkAllocateMemory(_device, &info, nullptr, &memory),
            "allocate " + std::to_string(requirements.size) + " bytes");
        _allocatedBytes += requirements.size;
        return memory;
    }
    return core::failure(
        core::ErrorCode::noDevice,
        "the graphics device has no memory of the kind that is needed; try another device "
        "(ISOFRONT_DEVICE=cpu)");
}

void Device::free(VkDeviceMemory memory, std::uint64_t bytes)
{
    vkFreeMemory(_device, memory, nullptr);
    _allocatedBytes -= bytes;
}

bool Device::hasMemory(VkMemoryPropertyFlags properties) const
{
    for (std::uint32_t type = 0; type < _memory.memoryTypeCount; ++type) {
        if ((_memory.memoryTypes[type].propertyFlags & properties) == properties)
            return true;
    }
    return false;
}

} // namespace isofront::gpu

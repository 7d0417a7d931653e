#include "Instance.h"

#include "isofront/gpu/Check.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isofront::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(
    VkDebugUtilsMessageSeverityFlagBitsEXT,
    VkDebugUtilsMessageTypeFlagsEXT,
    const VkDebugUtilsMessengerCallbackDataEXT* data,
    void* user)
{
    static_cast<Instance*>(user)->hear(data->pMessage);
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messengerInfo(Instance* instance)
{
    return {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = onMessage,
        .pUserData = instance};
}

bool hasLayer(const char* name)
{
    std::uint32_t count = 0;
    if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS)
        return false;
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [&](const VkLayerProperties& layer) {
        return std::strcmp(layer.layerName, name) == 0;
    });
}

std::string versionText(std::uint32_t version)
{
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." +
           std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

DeviceKind kindOf(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return DeviceKind::discrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return DeviceKind::integrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return DeviceKind::virtualised;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return DeviceKind::cpu;
    default:
        return DeviceKind::other;
    }
}

bool drawsDepthOf32Bits(VkPhysicalDevice device)
{
    VkFormatProperties properties{};
    vkGetPhysicalDeviceFormatProperties(device, VK_FORMAT_D32_SFLOAT, &properties);
    constexpr VkFormatFeatureFlags kNeeded =
        VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
    return (properties.optimalTilingFeatures & kNeeded) == kNeeded;
}

void findMissingFeatures(VkPhysicalDevice device, std::vector<std::string>& obstacles)
{
    VkPhysicalDeviceVulkan13Features features13{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features features12{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &features13};
    VkPhysicalDeviceFeatures2 features{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &features12};
    vkGetPhysicalDeviceFeatures2(device, &features);
    const auto require = [&](VkBool32 present, const char* name) {
        if (present == VK_FALSE)
            obstacles.emplace_back(std::string("no ") + name);
    };
    require(features13.dynamicRendering, "dynamic rendering");
    require(features13.synchronization2, "synchronization2");
    require(features12.timelineSemaphore, "timeline semaphores");
}

} // namespace

core::Result<std::unique_ptr<Instance>> Instance::create(bool validation)
{
    std::uint32_t loaderVersion = VK_API_VERSION_1_0;
    vkEnumerateInstanceVersion(&loaderVersion);
    if (loaderVersion < VK_API_VERSION_1_3) {
        return core::failure(
            core::ErrorCode::noDevice,
            "the Vulkan loader is version " + versionText(loaderVersion) +
                ", but 1.3 is needed; install a newer libvulkan1");
    }
    if (validation && !hasLayer(kValidationLayer)) {
        return core::failure(
            core::ErrorCode::noDevice,
            "the Vulkan validation layers are not installed; install vulkan-validationlayers, or "
            "run without validation");
    }

    std::unique_ptr<Instance> instance(new Instance);
    const VkApplicationInfo application{
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .pApplicationName = "isofront",
        .pEngineName = "isofront",
        .apiVersion = VK_API_VERSION_1_3};
    const std::array enabled{VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkDebugUtilsMessengerCreateInfoEXT messenger = messengerInfo(instance.get());
    const VkValidationFeaturesEXT features{
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = &messenger,
        .enabledValidationFeatureCount = static_cast<std::uint32_t>(enabled.size()),
        .pEnabledValidationFeatures = enabled.data()};
    const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    VkInstanceCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    if (validation) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidationLayer;
        info.enabledExtensionCount = 1;
        info.ppEnabledExtensionNames = &extension;
    }
    if (const VkResult result = vkCreateInstance(&info, nullptr, &instance->_instance);
        result != VK_SUCCESS) {
        return core::failure(
            core::ErrorCode::noDevice,
            "Vulkan can't start (" + vulkanError(result, "start").message +
                "); install mesa-vulkan-drivers for a software device");
    }

    if (validation) {
        const auto createMessenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(instance->_instance, "vkCreateDebugUtilsMessengerEXT"));
        ISOFRONT_VK(
            createMessenger(instance->_instance, &messenger, nullptr, &instance->_messenger),
            "listen to the validation layers");
    }
    return instance;
}

Instance::~Instance()
{
    if (_messenger != VK_NULL_HANDLE) {
        const auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(_instance, "vkDestroyDebugUtilsMessengerEXT"));
        destroyMessenger(_instance, _messenger, nullptr);
    }
    if (_instance != VK_NULL_HANDLE)
        vkDestroyInstance(_instance, nullptr);
}

core::Result<std::vector<VkPhysicalDevice>> Instance::devices() const
{
    std::uint32_t count = 0;
    ISOFRONT_VK(vkEnumeratePhysicalDevices(_instance, &count, nullptr), "be listed");
    std::vector<VkPhysicalDevice> devices(count);
    ISOFRONT_VK(vkEnumeratePhysicalDevices(_instance, &count, devices.data()), "be listed");
    devices.resize(count);
    return devices;
}

std::vector<std::string> Instance::messages() const
{
    const std::scoped_lock lock(_mutex);
    return _messages;
}

void Instance::clearMessages()
{
    const std::scoped_lock lock(_mutex);
    _messages.clear();
}

void Instance::hear(const char* message)
{
    const std::scoped_lock lock(_mutex);
    _messages.emplace_back(message);
}

DeviceDescription describe(VkPhysicalDevice device)
{
    VkPhysicalDeviceDriverProperties driver{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver};
    vkGetPhysicalDeviceProperties2(device, &properties);
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(device, &memory);

    DeviceDescription description;
    description.name = properties.properties.deviceName;
    description.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    description.kind = kindOf(properties.properties.deviceType);
    description.apiVersion = versionText(properties.properties.apiVersion);
    for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
        if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
            description.localBytes =
                std::max<std::uint64_t>(description.localBytes, memory.memoryHeaps[i].size);
    }

    if (properties.properties.apiVersion < VK_API_VERSION_1_3) {
        // Features may only be asked for through structures that the version knows.
        description.obstacles.emplace_back("only Vulkan " + description.apiVersion + ", not 1.3");
        return description;
    }
    findMissingFeatures(device, description.obstacles);
    if (!queueFamilyOf(device).found)
        description.obstacles.emplace_back("no graphics queue");
    if (!drawsDepthOf32Bits(device))
        description.obstacles.emplace_back("no 32-bit depth");
    return description;
}

QueueFamily queueFamilyOf(VkPhysicalDevice device)
{
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0)
            return {i, families[i].timestampValidBits, true};
    }
    return {};
}

core::Result<std::vector<DeviceDescription>> availableDevices()
{
    const core::Result<std::unique_ptr<Instance>> instance = Instance::create(false);
    if (!instance)
        return tl::unexpected(instance.error());
    const core::Result<std::vector<VkPhysicalDevice>> devices = (*instance)->devices();
    if (!devices)
        return tl::unexpected(devices.error());
    std::vector<DeviceDescription> descriptions;
    std::transform(devices->begin(), devices->end(), std::back_inserter(descriptions), describe);
    return descriptions;
}

} // namespace isofront::gpu

#include "isofront/gpu/Check.h"

namespace isofront::gpu {

namespace {

const char* nameOf(VkResult result)
{
    switch (result) {
    case VK_NOT_READY:
        return "not ready";
    case VK_TIMEOUT:
        return "timed out";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
        return "initialisation failed";
    case VK_ERROR_DEVICE_LOST:
        return "device lost";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
        return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
        return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return "no driver found";
    case VK_ERROR_TOO_MANY_OBJECTS:
        return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
        return "format not supported";
    default:
        return nullptr;
    }
}

} // namespace

core::Error vulkanError(VkResult result, const std::string& what)
{
    const char* name = nameOf(result);
    const std::string reason =
        name != nullptr ? name : "Vulkan result " + std::to_string(static_cast<int>(result));
    const bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY ||
                        result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
                        result == VK_ERROR_TOO_MANY_OBJECTS;
    if (memory) {
        return {
            core::ErrorCode::resourceLimit,
            "the graphics device can't " + what + ": " + reason +
                "; ask for a smaller picture or a smaller mesh pool"};
    }
    return {
        core::ErrorCode::noDevice,
        "the graphics device can't " + what + ": " + reason +
            "; try another device (ISOFRONT_DEVICE=cpu)"};
}

} // namespace isofront::gpu

#pragma once

#include <isofront/core/Result.h>

#include <vulkan/vulkan_core.h>

#include <string>

namespace isofront::gpu {

/// What a failed Vulkan call means to a user. Lack of memory is a resource limit, all else a device
/// that can't be used (any more).
/// @param what  the thing that was tried, as it stands after "can't", such as "create a buffer"
core::Error vulkanError(VkResult result, const std::string& what);

} // namespace isofront::gpu

/// Leaves the function with an error unless the Vulkan call succeeds.
#define ISOFRONT_VK(call, what)                                                                    \
    do {                                                                                           \
        if (const VkResult isofrontResult = (call); isofrontResult != VK_SUCCESS)                  \
            return tl::unexpected(::isofront::gpu::vulkanError(isofrontResult, what));             \
    } while (false)

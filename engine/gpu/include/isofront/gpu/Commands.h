#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Handle.h>

namespace isofront::gpu {

/// One command buffer that is recorded, submitted and, once its ticket is complete, recorded again.
class Commands {
public:
    Commands() = default;
    static core::Result<Commands> create(Device& device);

    [[nodiscard]] VkCommandBuffer get() const { return _buffer; }
    /// The ticket of its last submission; 0 before the first.
    [[nodiscard]] Device::Ticket ticket() const { return _ticket; }

    /// Waits for its last submission, and starts to record anew.
    core::Result<void> begin();
    /// Ends the recording and submits it.
    core::Result<Device::Ticket> submit();

private:
    Device* _device = nullptr;
    Handle<VkCommandPool, vkDestroyCommandPool> _pool;
    VkCommandBuffer _buffer = VK_NULL_HANDLE;
    Device::Ticket _ticket = 0;
};

} // namespace isofront::gpu

#include "isofront/gpu/Commands.h"

#include "isofront/gpu/Check.h"

namespace isofront::gpu {

core::Result<Commands> Commands::create(Device& device)
{
    Commands commands;
    commands._device = &device;
    const VkCommandPoolCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
        .queueFamilyIndex = device.queueFamily()};
    VkCommandPool pool = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreateCommandPool(device.handle(), &info, nullptr, &pool), "create a command pool");
    commands._pool = {device.handle(), pool};
    const VkCommandBufferAllocateInfo buffer{
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = pool,
        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
        .commandBufferCount = 1};
    ISOFRONT_VK(
        vkAllocateCommandBuffers(device.handle(), &buffer, &commands._buffer),
        "create a command buffer");
    return commands;
}

core::Result<void> Commands::begin()
{
    if (core::Result<void> waited = _device->wait(_ticket); !waited)
        return waited;
    ISOFRONT_VK(vkResetCommandPool(_device->handle(), _pool.get(), 0), "reset a command pool");
    const VkCommandBufferBeginInfo info{
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    ISOFRONT_VK(vkBeginCommandBuffer(_buffer, &info), "record commands");
    return {};
}

core::Result<Device::Ticket> Commands::submit()
{
    ISOFRONT_VK(vkEndCommandBuffer(_buffer), "record commands");
    core::Result<Device::Ticket> ticket = _device->submit(_buffer);
    if (ticket)
        _ticket = *ticket;
    return ticket;
}

} // namespace isofront::gpu

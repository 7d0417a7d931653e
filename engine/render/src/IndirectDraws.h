#pragma once

#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Device.h>

#include <cstddef>

namespace isofront::render {

/// Issues indexed draws from a mapped buffer of commands: by as few calls as the device can take,
/// or one by one.
/// @param first, count  [VkDrawIndexedIndirectCommand]
/// @param indirect      false: one by one
void issueDraws(
    const gpu::Device& device,
    VkCommandBuffer commands,
    const gpu::Buffer& draws,
    std::size_t first,
    std::size_t count,
    bool indirect);

} // namespace isofront::render

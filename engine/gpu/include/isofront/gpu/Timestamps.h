#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Handle.h>

#include <cstdint>
#include <vector>

namespace isofront::gpu {

/// Marks moments on the GPU's clock. Where the device has no such clock, all spans are 0.
class Timestamps {
public:
    Timestamps() = default;
    /// @param capacity  how many marks fit, at least 1
    static core::Result<Timestamps> create(Device& device, std::uint32_t capacity);

    /// Forgets all marks; first thing in a recording, outside of rendering.
    void reset(VkCommandBuffer commands);
    /// Marks when all commands so far are done. At most `capacity` marks after a reset (asserted).
    void mark(VkCommandBuffer commands);
    /// Makes the marks readable; last thing in a recording, outside of rendering.
    void resolve(VkCommandBuffer commands);
    /// The time between each mark and the next [ms], one fewer than marks. Call when the recording
    /// has been carried out.
    [[nodiscard]] std::vector<double> spans() const;

private:
    const Device* _device = nullptr;
    Handle<VkQueryPool, vkDestroyQueryPool> _pool;
    gpu::Buffer _ticks;
    std::uint32_t _capacity = 0;
    std::uint32_t _marks = 0;
};

} // namespace isofront::gpu

#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Handle.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace isofront::gpu {

enum class MemoryKind {
    device,   ///< fast for the GPU; the CPU can't see it
    shared,   ///< fast for the GPU, and mapped; not every device has it (`hasSharedMemory`)
    upload,   ///< mapped, written in order by the CPU and read by the GPU
    readback, ///< mapped, written by the GPU and read by the CPU
};

/// True if the GPU's own memory can be written by the CPU, so that nothing needs staging.
bool hasSharedMemory(const Device& device);

/// A buffer with memory of its own. Move-only; the device must outlive it.
class Buffer {
public:
    Buffer() = default;
    /// @param bytes  its size, at least 1
    static core::Result<Buffer>
    create(Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryKind kind);
    Buffer(Buffer&& other) noexcept { swap(other); }
    Buffer& operator=(Buffer&& other) noexcept
    {
        swap(other);
        return *this;
    }
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;
    ~Buffer();

    [[nodiscard]] VkBuffer get() const { return _buffer; }
    [[nodiscard]] VkDeviceSize bytes() const { return _bytes; }
    /// Its contents, coherent with the GPU; empty if it is not mapped.
    [[nodiscard]] std::span<std::byte> mapped() const { return _mapped; }

private:
    void swap(Buffer& other) noexcept;

    Device* _device = nullptr;
    VkBuffer _buffer = VK_NULL_HANDLE;
    VkDeviceMemory _memory = VK_NULL_HANDLE;
    VkDeviceSize _bytes = 0;
    VkDeviceSize _allocated = 0;
    std::span<std::byte> _mapped;
};

} // namespace isofront::gpu

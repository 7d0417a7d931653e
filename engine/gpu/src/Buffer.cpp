#include "isofront/gpu/Buffer.h"

#include "isofront/gpu/Check.h"

#include <isofront/core/Assert.h>

#include <utility>

namespace isofront::gpu {

namespace {

constexpr VkMemoryPropertyFlags kMapped =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr VkMemoryPropertyFlags kShared = kMapped | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;

VkMemoryPropertyFlags propertiesFor(const Device& device, MemoryKind kind)
{
    constexpr VkMemoryPropertyFlags kCached = kMapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    switch (kind) {
    case MemoryKind::device:
        return VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    case MemoryKind::shared:
        return kShared;
    case MemoryKind::readback:
        return device.hasMemory(kCached) ? kCached : kMapped;
    default:
        return kMapped;
    }
}

} // namespace

bool hasSharedMemory(const Device& device)
{
    // A discrete GPU may offer a small window of such memory; the bulk must not go there.
    return device.hasMemory(kShared) && device.description().kind != DeviceKind::discrete;
}

core::Result<Buffer>
Buffer::create(Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryKind kind)
{
    ISOFRONT_ASSERT(bytes > 0, "a buffer needs a size");
    Buffer buffer;
    buffer._device = &device;
    buffer._bytes = bytes;
    const VkBufferCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
    const std::string what = "create a buffer of " + std::to_string(bytes) + " bytes";
    ISOFRONT_VK(vkCreateBuffer(device.handle(), &info, nullptr, &buffer._buffer), what);
    VkMemoryRequirements requirements{};
    vkGetBufferMemoryRequirements(device.handle(), buffer._buffer, &requirements);
    const core::Result<VkDeviceMemory> memory =
        device.allocate(requirements, propertiesFor(device, kind));
    if (!memory)
        return tl::unexpected(memory.error());
    buffer._memory = *memory;
    buffer._allocated = requirements.size;
    ISOFRONT_VK(
        vkBindBufferMemory(device.handle(), buffer._buffer, buffer._memory, 0),
        "bind a buffer to its memory");
    if (kind != MemoryKind::device) {
        void* data = nullptr;
        ISOFRONT_VK(
            vkMapMemory(device.handle(), buffer._memory, 0, VK_WHOLE_SIZE, 0, &data),
            "map a buffer");
        buffer._mapped = {static_cast<std::byte*>(data), static_cast<std::size_t>(bytes)};
    }
    return buffer;
}

Buffer::~Buffer()
{
    if (_buffer != VK_NULL_HANDLE)
        vkDestroyBuffer(_device->handle(), _buffer, nullptr);
    if (_memory != VK_NULL_HANDLE)
        _device->free(_memory, _allocated);
}

void Buffer::swap(Buffer& other) noexcept
{
    std::swap(_device, other._device);
    std::swap(_buffer, other._buffer);
    std::swap(_memory, other._memory);
    std::swap(_bytes, other._bytes);
    std::swap(_allocated, other._allocated);
    std::swap(_mapped, other._mapped);
}

} // namespace isofront::gpu

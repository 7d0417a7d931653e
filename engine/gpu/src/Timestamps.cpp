#include "isofront/gpu/Timestamps.h"

#include "isofront/gpu/Barriers.h"
#include "isofront/gpu/Check.h"

#include <isofront/core/Assert.h>

#include <cstring>

namespace isofront::gpu {

core::Result<Timestamps> Timestamps::create(Device& device, std::uint32_t capacity)
{
    Timestamps timestamps;
    timestamps._device = &device;
    timestamps._capacity = capacity;
    if (!device.hasTimestamps())
        return timestamps;
    const VkQueryPoolCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
        .queryType = VK_QUERY_TYPE_TIMESTAMP,
        .queryCount = capacity};
    VkQueryPool pool = VK_NULL_HANDLE;
    ISOFRONT_VK(vkCreateQueryPool(device.handle(), &info, nullptr, &pool), "create a query pool");
    timestamps._pool = {device.handle(), pool};
    core::Result<Buffer> ticks = Buffer::create(
        device,
        capacity * sizeof(std::uint64_t),
        VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        MemoryKind::readback);
    if (!ticks)
        return tl::unexpected(ticks.error());
    timestamps._ticks = std::move(*ticks);
    return timestamps;
}

void Timestamps::reset(VkCommandBuffer commands)
{
    _marks = 0;
    if (_pool)
        vkCmdResetQueryPool(commands, _pool.get(), 0, _capacity);
}

void Timestamps::mark(VkCommandBuffer commands)
{
    ISOFRONT_ASSERT(_marks < _capacity, "more marks than " + std::to_string(_capacity));
    if (_pool)
        vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, _pool.get(), _marks);
    ++_marks;
}

void Timestamps::resolve(VkCommandBuffer commands)
{
    if (!_pool || _marks == 0)
        return;
    // Asked for through the queue: some drivers answer vkGetQueryPoolResults only once everything
    // submitted is done, which would keep the CPU from running ahead.
    vkCmdCopyQueryPoolResults(
        commands,
        _pool.get(),
        0,
        _marks,
        _ticks.get(),
        0,
        sizeof(std::uint64_t),
        VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    memoryBarrier(commands, use::kTransferWrite, use::kHostRead);
}

std::vector<double> Timestamps::spans() const
{
    if (_marks < 2)
        return {};
    std::vector<double> spans(_marks - 1, 0.0);
    if (!_pool)
        return spans;
    std::vector<std::uint64_t> ticks(_marks);
    std::memcpy(ticks.data(), _ticks.mapped().data(), ticks.size() * sizeof(std::uint64_t));
    const std::uint32_t bits = _device->timestampBits();
    const std::uint64_t mask = bits >= 64 ? ~0ULL : (1ULL << bits) - 1;
    for (std::size_t i = 0; i < spans.size(); ++i) {
        // The clock may wrap around between two marks.
        const std::uint64_t elapsed = (ticks[i + 1] - ticks[i]) & mask;
        spans[i] = static_cast<double>(elapsed) *
                   static_cast<double>(_device->limits().timestampPeriod) * 1e-6;
    }
    return spans;
}

} // namespace isofront::gpu

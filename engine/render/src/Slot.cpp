#include "Slot.h"

#include "shared/frame.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace isofront::render {

namespace {

/// Of one frame.
constexpr std::size_t kMostPasses = 5;

template <typename T>
std::span<T> mappedAs(const gpu::Buffer& buffer)
{
    return {reinterpret_cast<T*>(buffer.mapped().data()), buffer.mapped().size() / sizeof(T)};
}

/// Makes sure that a buffer has so much room.
core::Result<void>
grow(gpu::Device& device, gpu::Buffer& buffer, std::size_t bytes, VkBufferUsageFlags usage)
{
    if (buffer.bytes() >= bytes)
        return {};
    core::Result<gpu::Buffer> larger =
        gpu::Buffer::create(device, bytes, usage, gpu::MemoryKind::upload);
    if (!larger)
        return tl::unexpected(larger.error());
    buffer = std::move(*larger);
    return {};
}

} // namespace

core::Result<Slot> makeSlot(gpu::Device& device)
{
    core::Result<gpu::Commands> commands = gpu::Commands::create(device);
    if (!commands)
        return tl::unexpected(commands.error());
    core::Result<gpu::Timestamps> timestamps = gpu::Timestamps::create(device, kMostPasses + 1);
    if (!timestamps)
        return tl::unexpected(timestamps.error());
    core::Result<gpu::Buffer> frame = gpu::Buffer::create(
        device, sizeof(shared::Frame), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, gpu::MemoryKind::upload);
    if (!frame)
        return tl::unexpected(frame.error());
    return Slot{
        .commands = std::move(*commands),
        .timestamps = std::move(*timestamps),
        .passes = {},
        .streamed = 0,
        .hasVoxels = false,
        .frame = std::move(*frame),
        .cells = {},
        .draws = {},
        .owners = {}};
}

core::Result<void> reserveDraws(gpu::Device& device, Slot& slot, std::size_t count)
{
    const std::size_t room = std::bit_ceil(std::max<std::size_t>(count, 256));
    if (core::Result<void> grown = grow(
            device,
            slot.cells,
            room * sizeof(shared::DrawnCell),
            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        !grown)
        return grown;
    return grow(
        device,
        slot.draws,
        room * sizeof(VkDrawIndexedIndirectCommand),
        VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
}

core::Result<void> fillOwners(gpu::Device& device, Slot& slot, const HandOver* handOver)
{
    constexpr std::size_t kLeast = 256;
    std::span<const std::uint8_t> blocks;
    if (handOver != nullptr)
        blocks = handOver->blocks();
    const std::size_t bytes = std::bit_ceil(std::max(blocks.size(), kLeast)); // whole words
    if (core::Result<void> grown =
            grow(device, slot.owners, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
        !grown)
        return grown;
    if (!blocks.empty())
        std::memcpy(slot.owners.mapped().data(), blocks.data(), blocks.size());
    return {};
}

std::uint64_t fillDraws(
    const Slot& slot,
    std::span<const StoredCell> cells,
    std::span<const std::uint32_t> pictures,
    std::span<const std::uint32_t> order,
    std::size_t first)
{
    const std::span<shared::DrawnCell> drawn = mappedAs<shared::DrawnCell>(slot.cells);
    const std::span<VkDrawIndexedIndirectCommand> draws =
        mappedAs<VkDrawIndexedIndirectCommand>(slot.draws);
    std::uint64_t triangles = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const StoredCell& cell = cells[order[i]];
        drawn[first + i].lowAndExponent = {
            cell.corner.x,
            cell.corner.y,
            cell.corner.z,
            cell.exponent | pictures[order[i]] << shared::kCellPicturesShift};
        draws[first + i] = {
            .indexCount = cell.indexCount,
            .instanceCount = 1,
            .firstIndex = cell.firstIndex(),
            .vertexOffset = cell.vertexOffset(),
            .firstInstance = static_cast<std::uint32_t>(first + i)};
        triangles += cell.indexCount / 3;
    }
    return triangles;
}

} // namespace isofront::render

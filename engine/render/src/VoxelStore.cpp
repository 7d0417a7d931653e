#include "VoxelStore.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <set>
#include <string>

namespace isofront::render {

namespace {

/// Small chunks share a slab; large ones take several.
constexpr std::uint32_t kSlabBytes = 64U << 10U;
constexpr std::uint32_t kSlabUnits = kSlabBytes / kPoolUnit;

std::size_t bytesOf(const voxels::Chunk& chunk)
{
    return chunk.voxels.size() * sizeof(voxels::Voxel) +
           chunk.colours.size() * sizeof(std::uint32_t);
}

std::uint32_t unitsOf(const voxels::Chunk& chunk)
{
    return static_cast<std::uint32_t>((bytesOf(chunk) + kPoolUnit - 1) / kPoolUnit);
}

PlacedChunk placed(const voxels::Chunk& chunk, gpu::SlabPool::Range range)
{
    std::array<std::uint32_t, 3> low{255, 255, 255};
    std::array<std::uint32_t, 3> high{0, 0, 0};
    for (const voxels::Voxel& voxel : chunk.voxels) {
        const std::array place{voxel.x(), voxel.y(), voxel.z()};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], place[axis]);
            high[axis] = std::max(high[axis], place[axis]);
        }
    }
    const auto count = static_cast<std::uint32_t>(chunk.voxels.size());
    const std::uint32_t firstWord = range.first * (kPoolUnit / 4);
    return {
        .key = chunk.key,
        .firstWord = firstWord,
        .firstColour = chunk.colours.empty() ? 0 : firstWord + 2 * count,
        .voxels = count,
        .low = voxels::packPlace(low[0], low[1], low[2], 0),
        .high = voxels::packPlace(high[0], high[1], high[2], 0)};
}

void copyInto(std::span<std::byte> place, const voxels::Chunk& chunk)
{
    const std::size_t voxelBytes = chunk.voxels.size() * sizeof(voxels::Voxel);
    std::memcpy(place.data(), chunk.voxels.data(), voxelBytes);
    if (!chunk.colours.empty())
        std::memcpy(
            place.data() + voxelBytes,
            chunk.colours.data(),
            chunk.colours.size() * sizeof(std::uint32_t));
}

std::string nameOf(const voxels::ChunkKey& key)
{
    return "chunk " + std::to_string(key.x) + ", " + std::to_string(key.y) + ", " +
           std::to_string(key.z) + " of level " + std::to_string(key.level);
}

} // namespace

VoxelStore::VoxelStore(gpu::Device& device, gpu::Buffer buffer, gpu::SlabPool pool)
    : _device(&device), _buffer(std::move(buffer)), _pool(std::move(pool)), _uploads(device)
{
}

core::Result<VoxelStore>
VoxelStore::create(gpu::Device& device, std::uint64_t bytes, bool forceStaging)
{
    // Words are counted in 32 bits from the pool's start.
    constexpr std::uint64_t kMost = (std::uint64_t{1} << 32U) * sizeof(std::uint32_t);
    bytes = std::min({bytes, std::uint64_t{device.limits().maxStorageBufferRange}, kMost - 1});
    const auto slabs = static_cast<std::uint32_t>(bytes / kSlabBytes);
    if (bytes < std::uint64_t{1} << 20U) {
        return core::failure(
            core::ErrorCode::usage,
            "a voxel pool of " + std::to_string(bytes) +
                " bytes is not possible; use at least 1048576");
    }
    const gpu::MemoryKind kind = forceStaging || !gpu::hasSharedMemory(device)
                                     ? gpu::MemoryKind::device
                                     : gpu::MemoryKind::shared;
    core::Result<gpu::Buffer> buffer = gpu::Buffer::create(
        device,
        std::uint64_t{slabs} * kSlabBytes,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
            VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        kind);
    if (!buffer)
        return tl::unexpected(buffer.error());
    return VoxelStore(device, std::move(*buffer), gpu::SlabPool(slabs, kSlabUnits));
}

core::Result<void> VoxelStore::check(std::span<const voxels::Chunk> chunks) const
{
    std::set<voxels::ChunkKey> keys;
    for (const voxels::Chunk& chunk : chunks) {
        if (_chunks.contains(chunk.key) || !keys.insert(chunk.key).second)
            return core::failure(
                core::ErrorCode::usage,
                nameOf(chunk.key) + " is on the device already; remove it first");
        if (chunk.voxels.empty() || chunk.voxels.size() > std::size_t{1} << 24U ||
            (!chunk.colours.empty() && chunk.colours.size() != chunk.voxels.size()))
            return core::failure(
                core::ErrorCode::badData,
                nameOf(chunk.key) + " has " + std::to_string(chunk.voxels.size()) + " voxels and " +
                    std::to_string(chunk.colours.size()) + " colours, so it can't be shown");
    }
    return {};
}

core::Result<void> VoxelStore::recycle()
{
    if (_retired.empty())
        return {};
    const core::Result<gpu::Device::Ticket> completed = _device->completed();
    if (!completed)
        return tl::unexpected(completed.error());
    while (!_retired.empty() && _retired.front().ticket <= *completed) {
        _pool.release(_retired.front().range);
        _retired.pop_front();
    }
    return {};
}

core::Result<std::vector<gpu::SlabPool::Range>>
VoxelStore::makeRoom(std::span<const voxels::Chunk> chunks)
{
    // The second time when all that was removed is free.
    for (int attempt = 0; attempt < 2; ++attempt) {
        if (attempt == 1) {
            if (core::Result<void> idle = _device->wait(_device->submitted()); !idle)
                return tl::unexpected(idle.error());
        }
        if (core::Result<void> recycled = recycle(); !recycled)
            return tl::unexpected(recycled.error());
        std::vector<gpu::SlabPool::Range> ranges;
        for (const voxels::Chunk& chunk : chunks) {
            const std::optional<gpu::SlabPool::Range> range = _pool.allocate(unitsOf(chunk));
            if (!range)
                break;
            ranges.push_back(*range);
        }
        if (ranges.size() == chunks.size())
            return ranges;
        for (const gpu::SlabPool::Range& range : ranges)
            _pool.release(range);
    }
    return core::failure(
        core::ErrorCode::resourceLimit,
        "the voxels don't fit into the renderer's pool of " + std::to_string(_buffer.bytes()) +
            " bytes; ask for less detail or give it a larger pool");
}

core::Result<std::uint64_t> VoxelStore::add(std::span<const voxels::Chunk> chunks)
{
    if (core::Result<void> sound = check(chunks); !sound)
        return tl::unexpected(sound.error());
    const core::Result<std::vector<gpu::SlabPool::Range>> ranges = makeRoom(chunks);
    if (!ranges)
        return tl::unexpected(ranges.error());
    std::uint64_t bytes = 0;
    for (const voxels::Chunk& chunk : chunks)
        bytes += bytesOf(chunk);
    const auto upload = [&]() -> core::Result<void> {
        core::Result<UploadBatch> batch = _uploads.open(_buffer, bytes);
        if (!batch)
            return tl::unexpected(batch.error());
        for (std::size_t i = 0; i < chunks.size(); ++i) {
            const VkDeviceSize offset = VkDeviceSize{(*ranges)[i].first} * kPoolUnit;
            copyInto(batch->place(offset, bytesOf(chunks[i])), chunks[i]);
        }
        return _uploads.submit(_buffer, *batch, gpu::use::kStorageRead);
    };
    if (core::Result<void> uploaded = upload(); !uploaded) {
        for (const gpu::SlabPool::Range& range : *ranges)
            _pool.release(range);
        return tl::unexpected(uploaded.error());
    }
    for (std::size_t i = 0; i < chunks.size(); ++i)
        _chunks.emplace(
            chunks[i].key,
            StoredChunk{.range = (*ranges)[i], .placed = placed(chunks[i], (*ranges)[i])});
    return bytes;
}

void VoxelStore::remove(std::span<const voxels::ChunkKey> keys)
{
    for (const voxels::ChunkKey& key : keys) {
        const auto found = _chunks.find(key);
        if (found == _chunks.end())
            continue;
        _retired.push_back({_device->submitted(), found->second.range});
        _chunks.erase(found);
    }
}

void VoxelStore::clear()
{
    for (const auto& [key, chunk] : _chunks)
        _retired.push_back({_device->submitted(), chunk.range});
    _chunks.clear();
}

const PlacedChunk* VoxelStore::find(const voxels::ChunkKey& key) const
{
    const auto found = _chunks.find(key);
    return found == _chunks.end() ? nullptr : &found->second.placed;
}

} // namespace isofront::render

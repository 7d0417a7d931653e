#include "VoxelStore.h"

#include <isofront/voxels/ChunkForm.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
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
    return chunk.bytes();
}

std::size_t bytesOf(const VoxelTransition& transition)
{
    return transition.nodes.bytes();
}

template <typename T>
std::vector<std::size_t> bytesOfEach(std::span<const T> parts)
{
    std::vector<std::size_t> bytes;
    bytes.reserve(parts.size());
    for (const T& part : parts)
        bytes.push_back(bytesOf(part));
    return bytes;
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
    voxels::packInto(chunk, place);
}

void copyInto(std::span<std::byte> place, const VoxelTransition& transition)
{
    const voxels::TransitionNodes& nodes = transition.nodes;
    const std::size_t parentBytes = nodes.parents.size() * sizeof(std::uint32_t);
    std::memcpy(place.data(), nodes.parents.data(), parentBytes);
    if (!nodes.redundant.empty())
        std::memcpy(
            place.data() + parentBytes,
            nodes.redundant.data(),
            nodes.redundant.size() * sizeof(std::uint32_t));
}

/// Redundant nodes fill whole voxels of the parent.
void fillParents(PlacedChunk& chunk)
{
    constexpr std::uint32_t kLowest = voxels::packPlace(1, 1, 1, 0);
    chunk.low &= ~kLowest;
    chunk.high |= kLowest;
}

/// What lies where a streamer has placed a chunk.
const voxels::ChunkEntry& shown(const voxels::ChunkDraw& draw, const voxels::ChunkTree& tree)
{
    return draw.standIn == nullptr ? tree[draw.index].entry : *draw.standIn;
}

} // namespace

PlacedChunk placed(const voxels::ChunkDraw& draw, const voxels::ChunkTree& tree)
{
    const voxels::ChunkEntry& entry = shown(draw, tree);
    const auto wordAt = [](std::uint64_t offset) {
        return static_cast<std::uint32_t>(offset / sizeof(std::uint32_t));
    };
    const std::uint32_t firstWord = wordAt(draw.offset);
    PlacedChunk chunk{
        .key = draw.key,
        .firstWord = firstWord,
        .firstColour = entry.coloured ? firstWord + 2 * draw.voxels : 0,
        .voxels = draw.voxels,
        .low = voxels::packPlace(entry.low[0], entry.low[1], entry.low[2], 0),
        .high = voxels::packPlace(entry.high[0], entry.high[1], entry.high[2], 0),
        .occlusionOnly = draw.occlusionOnly,
        .pictures = picturesOf(draw),
        .octants = draw.octants};
    const voxels::ChunkIndex parent = tree[draw.index].parent;
    if (!draw.fades || parent == voxels::kNoChunk)
        return chunk;
    const voxels::ChunkEntry& above = tree[parent].entry;
    chunk.weight = draw.weight;
    chunk.firstParent = wordAt(draw.transitionOffset);
    chunk.redundant = entry.redundant();
    chunk.parentWord = wordAt(draw.parentOffset);
    chunk.parentColour = above.coloured ? chunk.parentWord + 2 * above.voxels : 0;
    fillParents(chunk);
    return chunk;
}

bool isWithin(const voxels::ChunkDraw& draw, const voxels::ChunkTree& tree, std::uint64_t bytes)
{
    const auto fits = [&](std::uint64_t offset, std::uint64_t words) {
        return offset <= bytes && words <= (bytes - offset) / sizeof(std::uint32_t);
    };
    const auto wordsOf = [](const voxels::ChunkEntry& entry) {
        return std::uint64_t{entry.voxels} * (entry.coloured ? 3 : 2) +
               2 * (std::uint64_t{entry.faceSets} + entry.faceAttributes);
    };
    const voxels::ChunkTree::Node& node = tree[draw.index];
    if (!fits(draw.offset, wordsOf(shown(draw, tree))))
        return false;
    if (!draw.fades || node.parent == voxels::kNoChunk)
        return true;
    const std::uint64_t redundant = node.entry.redundant();
    return fits(draw.transitionOffset, node.entry.voxels + 2 * redundant) &&
           fits(draw.parentOffset, wordsOf(tree[node.parent].entry));
}

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
        if (!voxels::hasSoundFaces(chunk))
            return core::failure(
                core::ErrorCode::badData,
                nameOf(chunk.key) + " has face sets that are not in order, or name what is not "
                                    "there, so it can't be shown");
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
VoxelStore::makeRoom(std::span<const std::size_t> bytes)
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
        for (const std::size_t each : bytes) {
            const std::optional<gpu::SlabPool::Range> range =
                _pool.allocate(static_cast<std::uint32_t>((each + kPoolUnit - 1) / kPoolUnit));
            if (!range)
                break;
            ranges.push_back(*range);
        }
        if (ranges.size() == bytes.size())
            return ranges;
        for (const gpu::SlabPool::Range& range : ranges)
            _pool.release(range);
    }
    return core::failure(
        core::ErrorCode::resourceLimit,
        "the voxels don't fit into the renderer's pool of " + std::to_string(_buffer.bytes()) +
            " bytes; ask for less detail or give it a larger pool");
}

template <typename T>
core::Result<std::vector<gpu::SlabPool::Range>> VoxelStore::upload(std::span<const T> parts)
{
    const std::vector<std::size_t> bytes = bytesOfEach(parts);
    core::Result<std::vector<gpu::SlabPool::Range>> ranges = makeRoom(bytes);
    if (!ranges)
        return ranges;
    const auto copy = [&]() -> core::Result<void> {
        core::Result<UploadBatch> batch =
            _uploads.open(_buffer, std::accumulate(bytes.begin(), bytes.end(), std::size_t{0}));
        if (!batch)
            return tl::unexpected(batch.error());
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const VkDeviceSize offset = VkDeviceSize{(*ranges)[i].first} * kPoolUnit;
            copyInto(batch->place(offset, bytes[i]), parts[i]);
        }
        return _uploads.submit(_buffer, *batch, gpu::use::kStorageRead);
    };
    if (core::Result<void> copied = copy(); !copied) {
        for (const gpu::SlabPool::Range& range : *ranges)
            _pool.release(range);
        return tl::unexpected(copied.error());
    }
    return ranges;
}

core::Result<std::uint64_t> VoxelStore::add(std::span<const voxels::Chunk> chunks)
{
    if (_isStreamed) {
        return core::failure(
            core::ErrorCode::usage,
            "the renderer's voxel pool holds streamed chunks; clear its chunks before adding any");
    }
    if (core::Result<void> sound = check(chunks); !sound)
        return tl::unexpected(sound.error());
    const core::Result<std::vector<gpu::SlabPool::Range>> ranges = upload(chunks);
    if (!ranges)
        return tl::unexpected(ranges.error());
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        bytes += bytesOf(chunks[i]);
        _chunks.emplace(
            chunks[i].key,
            StoredChunk{
                .range = (*ranges)[i],
                .placed = placed(chunks[i], (*ranges)[i]),
                .transition = std::nullopt});
    }
    return bytes;
}

core::Result<void> VoxelStore::check(std::span<const VoxelTransition> transitions) const
{
    std::set<voxels::ChunkKey> keys;
    for (const VoxelTransition& transition : transitions) {
        const auto found = _chunks.find(transition.key);
        if (found == _chunks.end())
            return core::failure(
                core::ErrorCode::usage,
                nameOf(transition.key) + " is not on the device; add it before its transition");
        if (found->second.transition || !keys.insert(transition.key).second)
            return core::failure(
                core::ErrorCode::usage,
                "the transition of " + nameOf(transition.key) +
                    " is on the device already; remove the chunk first");
        const std::size_t nodes = found->second.placed.voxels + transition.nodes.redundant.size();
        if (transition.nodes.parents.size() != nodes || nodes > std::size_t{1} << 24U)
            return core::failure(
                core::ErrorCode::badData,
                "a transition with " + std::to_string(transition.nodes.parents.size()) +
                    " parents doesn't fit " + nameOf(transition.key) + ", which needs " +
                    std::to_string(nodes) + "; make it from the same chunk");
    }
    return {};
}

core::Result<std::uint64_t> VoxelStore::add(std::span<const VoxelTransition> transitions)
{
    if (core::Result<void> sound = check(transitions); !sound)
        return tl::unexpected(sound.error());
    const core::Result<std::vector<gpu::SlabPool::Range>> ranges = upload(transitions);
    if (!ranges)
        return tl::unexpected(ranges.error());
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < transitions.size(); ++i) {
        bytes += bytesOf(transitions[i]);
        StoredChunk& chunk = _chunks.at(transitions[i].key);
        chunk.transition = (*ranges)[i];
        chunk.redundant = static_cast<std::uint32_t>(transitions[i].nodes.redundant.size());
        chunk.parents = 0;
        for (const std::uint32_t at : transitions[i].nodes.parents)
            chunk.parents = std::max(chunk.parents, at == 0xffffffffU ? at : at + 1);
    }
    return bytes;
}

void VoxelStore::fade(PlacedChunk& chunk, float weight) const
{
    const auto own = _chunks.find(chunk.key);
    const auto parent = _chunks.find(chunk.key.parent());
    // made from another parent, it would have shaders read beyond this one's voxels
    if (own == _chunks.end() || !own->second.transition || parent == _chunks.end() ||
        own->second.parents > parent->second.placed.voxels)
        return;
    chunk.weight = std::max(weight, 0.0F);
    chunk.firstParent = own->second.transition->first * (kPoolUnit / 4);
    chunk.redundant = own->second.redundant;
    chunk.parentWord = parent->second.placed.firstWord;
    chunk.parentColour = parent->second.placed.firstColour;
    fillParents(chunk);
}

void VoxelStore::retire(const StoredChunk& chunk)
{
    _retired.push_back({_device->submitted(), chunk.range});
    if (chunk.transition)
        _retired.push_back({_device->submitted(), *chunk.transition});
}

core::Result<std::uint64_t> VoxelStore::apply(const voxels::ChunkFrame& frame)
{
    const auto fits = [&](std::uint64_t offset, std::uint64_t bytes) {
        return bytes <= _buffer.bytes() && offset <= _buffer.bytes() - bytes;
    };
    std::uint64_t bytes = 0;
    bool sound = _chunks.empty();
    for (const voxels::ChunkUpload& upload : frame.uploads) {
        sound = sound && fits(upload.offset, upload.data.size());
        bytes += upload.data.size();
    }
    for (const voxels::ChunkMove& move : frame.moves)
        sound = sound && fits(move.from, move.bytes) && fits(move.to, move.bytes);
    if (!sound) {
        return core::failure(
            core::ErrorCode::usage,
            "the streamed chunks don't fit the renderer's voxel pool of " +
                std::to_string(_buffer.bytes()) +
                " bytes; make the streamer's cache no larger, and add no chunks besides");
    }
    if (!_isStreamed) {
        // A streamer knows what its own frames read, but not those before it.
        if (core::Result<void> cleared = clear(); !cleared)
            return tl::unexpected(cleared.error());
        _isStreamed = true;
    }
    core::Result<UploadBatch> batch = _uploads.open(_buffer, bytes);
    if (!batch)
        return tl::unexpected(batch.error());
    for (const voxels::ChunkUpload& upload : frame.uploads) {
        if (!upload.data.empty())
            std::memcpy(
                batch->place(upload.offset, upload.data.size()).data(),
                upload.data.data(),
                upload.data.size());
    }
    for (const voxels::ChunkMove& move : frame.moves)
        batch->move(move.from, move.to, move.bytes);
    if (core::Result<void> submitted = _uploads.submit(_buffer, *batch, gpu::use::kStorageRead);
        !submitted)
        return tl::unexpected(submitted.error());
    return bytes;
}

void VoxelStore::remove(std::span<const voxels::ChunkKey> keys)
{
    for (const voxels::ChunkKey& key : keys) {
        const auto found = _chunks.find(key);
        if (found == _chunks.end())
            continue;
        retire(found->second);
        _chunks.erase(found);
    }
}

core::Result<void> VoxelStore::clear()
{
    for (const auto& [key, chunk] : _chunks)
        retire(chunk);
    _chunks.clear();
    _isStreamed = false;
    if (core::Result<void> idle = _device->wait(_device->submitted()); !idle)
        return idle;
    return recycle();
}

const PlacedChunk* VoxelStore::find(const voxels::ChunkKey& key) const
{
    const auto found = _chunks.find(key);
    return found == _chunks.end() ? nullptr : &found->second.placed;
}

} // namespace isofront::render

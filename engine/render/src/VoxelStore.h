#pragma once

#include "Uploads.h"
#include "isofront/render/Voxels.h"
#include "shared/transition.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/SlabPool.h>
#include <isofront/voxels/Chunk.h>
#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/ChunkTree.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace isofront::render {

/// A chunk that lies in the pool, which is counted in words of 4 bytes.
struct PlacedChunk {
    voxels::ChunkKey key;
    std::uint32_t firstWord = 0;   ///< of its voxels
    std::uint32_t firstColour = 0; ///< word of its first colour; 0 if it has none
    std::uint32_t voxels = 0;
    /// The least and greatest places of its voxels along each axis, packed as their places are.
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    bool occlusionOnly = false; ///< as VoxelDraw says
    std::uint32_t pictures = shared::kInBoth;
    std::uint8_t octants = 0xff; ///< as voxels::ChunkDraw says
    // For weights below 1:
    float weight = 1;               ///< as VoxelDraw says
    std::uint32_t firstParent = 0;  ///< word of its nodes' parents; its redundant nodes follow
    std::uint32_t redundant = 0;    ///< number of these
    std::uint32_t parentWord = 0;   ///< of the parent chunk's voxels
    std::uint32_t parentColour = 0; ///< word of the parent chunk's first colour; 0 if it has none
};

/// The pictures that a draw is part of, as shared/transition.h names them.
template <typename Draw>
std::uint32_t picturesOf(const Draw& draw)
{
    return (draw.inFormer ? shared::kInFormer : 0) | (draw.inPresent ? shared::kInPresent : 0);
}

/// Of a chunk that a streamer has placed. Not sound if it doesn't lie in the pool.
PlacedChunk placed(const voxels::ChunkDraw& draw, const voxels::ChunkTree& tree);
/// Whether all that drawing it reads lies in a pool of so many bytes.
bool isWithin(const voxels::ChunkDraw& draw, const voxels::ChunkTree& tree, std::uint64_t bytes);

/// What chunks lie at multiples of [bytes].
inline constexpr std::uint32_t kPoolUnit = 16;

/// The chunks on the GPU, in one buffer.
///
/// Memory that a submitted frame may read is used again only when that frame is complete.
class VoxelStore {
public:
    /// @param bytes  at least a mebibyte; no more is taken than shaders can see at once
    static core::Result<VoxelStore>
    create(gpu::Device& device, std::uint64_t bytes, bool forceStaging);

    /// Adds all chunks, or on failure none. Returns how many bytes that took.
    core::Result<std::uint64_t> add(std::span<const voxels::Chunk> chunks);
    /// Adds all transitions, or on failure none; their chunks are there. Returns how many bytes
    /// that took.
    core::Result<std::uint64_t> add(std::span<const VoxelTransition> transitions);
    /// Readies a chunk to be drawn with a weight; leaves it as it is if its transition or its
    /// parent isn't there.
    void fade(PlacedChunk& chunk, float weight) const;
    /// Makes the copies of a streamed frame. Returns how many bytes were uploaded. Usage if it
    /// leaves the pool, or if chunks were added. The first waits for the frames in flight.
    core::Result<std::uint64_t> apply(const voxels::ChunkFrame& frame);
    /// Forgets chunks; those that aren't there are passed over.
    void remove(std::span<const voxels::ChunkKey> keys);
    /// Forgets all chunks, added or streamed. Waits for the frames in flight.
    core::Result<void> clear();

    /// Null if it isn't there.
    [[nodiscard]] const PlacedChunk* find(const voxels::ChunkKey& key) const;
    [[nodiscard]] std::size_t size() const { return _chunks.size(); }
    [[nodiscard]] const gpu::Buffer& buffer() const { return _buffer; }
    [[nodiscard]] std::uint64_t usedBytes() const
    {
        return std::uint64_t{_pool.used()} * kPoolUnit;
    }

private:
    VoxelStore(gpu::Device& device, gpu::Buffer buffer, gpu::SlabPool pool);
    core::Result<void> check(std::span<const voxels::Chunk> chunks) const;
    [[nodiscard]] core::Result<void> check(std::span<const VoxelTransition> transitions) const;
    /// Ranges of so many bytes each.
    core::Result<std::vector<gpu::SlabPool::Range>> makeRoom(std::span<const std::size_t> bytes);
    core::Result<void> recycle();

    struct StoredChunk {
        gpu::SlabPool::Range range; ///< [kPoolUnit bytes]
        PlacedChunk placed;
        std::optional<gpu::SlabPool::Range> transition;
        std::uint32_t redundant = 0; ///< nodes of it
        std::uint32_t parents = 0;   ///< that it takes its parent to have, at least
    };
    /// Finds room for all of them and copies them there, or on failure none.
    template <typename T>
    core::Result<std::vector<gpu::SlabPool::Range>> upload(std::span<const T> parts);
    void retire(const StoredChunk& chunk);

    struct Retired {
        gpu::Device::Ticket ticket = 0;
        gpu::SlabPool::Range range;
    };

    gpu::Device* _device;
    gpu::Buffer _buffer;
    gpu::SlabPool _pool;
    Uploads _uploads;
    std::map<voxels::ChunkKey, StoredChunk> _chunks;
    std::deque<Retired> _retired; ///< in the order of their tickets
    bool _isStreamed = false;     ///< a streamer says what lies where in the pool
};

} // namespace isofront::render

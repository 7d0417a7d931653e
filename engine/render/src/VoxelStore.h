#pragma once

#include "Uploads.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/SlabPool.h>
#include <isofront/voxels/Chunk.h>

#include <cstdint>
#include <deque>
#include <map>
#include <span>

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
};

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
    /// Forgets chunks; those that aren't there are passed over.
    void remove(std::span<const voxels::ChunkKey> keys);
    void clear();

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
    core::Result<std::vector<gpu::SlabPool::Range>> makeRoom(std::span<const voxels::Chunk> chunks);
    core::Result<void> recycle();

    struct StoredChunk {
        gpu::SlabPool::Range range; ///< [kPoolUnit bytes]
        PlacedChunk placed;
    };
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
};

} // namespace isofront::render

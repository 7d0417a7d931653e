#pragma once

#include "ChunkOccupancy.h"

#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace isofront::voxels {

/// A chunk that rays can go through.
struct LoadedChunk {
    explicit LoadedChunk(Chunk loaded) : chunk(std::move(loaded)), occupancy(chunk.voxels) {}

    Chunk chunk;
    ChunkOccupancy occupancy;

    [[nodiscard]] std::size_t bytes() const { return chunk.bytes() + occupancy.bytes(); }
};

/// Reads chunks when they are first wanted and keeps those that were wanted last.
///
/// Thread: any number at once; a chunk that several want is read once.
class ChunkCache {
public:
    /// @param keys  the chunks that may be asked for, by index
    ChunkCache(const ChunkStore& store, std::vector<ChunkKey> keys, std::size_t mostBytes);

    core::Result<std::shared_ptr<const LoadedChunk>> get(std::uint32_t index);

    struct Statistics {
        std::uint64_t loads = 0;
        std::size_t bytes = 0;
        std::size_t treeBytes = 0;
    };
    [[nodiscard]] Statistics statistics() const;

private:
    struct Entry {
        std::shared_ptr<const LoadedChunk> chunk; ///< null while it is read
        std::list<std::uint32_t>::iterator age;   ///< valid once it is read
    };
    void evict();

    const ChunkStore& _store;
    std::vector<ChunkKey> _keys;
    std::size_t _mostBytes;
    mutable std::mutex _mutex;
    std::condition_variable _read;
    std::unordered_map<std::uint32_t, Entry> _entries;
    std::list<std::uint32_t> _ages; ///< most recently wanted first
    Statistics _statistics;
};

} // namespace isofront::voxels

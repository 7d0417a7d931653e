#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/Chunk.h>

#include <optional>

namespace isofront::voxels {

/// What finished chunks are given to.
class ChunkSink {
public:
    ChunkSink() = default;
    ChunkSink(const ChunkSink&) = delete;
    ChunkSink& operator=(const ChunkSink&) = delete;
    virtual ~ChunkSink() = default;

    /// Takes a chunk that is not empty; each key comes once. Children come before their parents.
    /// Called by one thread at a time, in an order that does not depend on threads.
    /// @return why it can't; then nothing more comes
    virtual std::optional<core::Error> put(Chunk chunk) = 0;
};

} // namespace isofront::voxels

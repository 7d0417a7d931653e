#include "ChunkCache.h"

#include <new>
#include <optional>

namespace isofront::voxels {

ChunkCache::ChunkCache(const ChunkStore& store, std::vector<ChunkKey> keys, std::size_t mostBytes)
    : _store(store), _keys(std::move(keys)), _mostBytes(mostBytes)
{
}

core::Result<std::shared_ptr<const LoadedChunk>> ChunkCache::get(std::uint32_t index)
{
    std::unique_lock lock(_mutex);
    for (auto found = _entries.find(index); found != _entries.end(); found = _entries.find(index)) {
        if (found->second.chunk) {
            _ages.splice(_ages.begin(), _ages, found->second.age);
            return found->second.chunk;
        }
        _read.wait(lock); // another thread reads it
    }
    _entries.emplace(index, Entry{});
    lock.unlock();
    core::Result<std::optional<Chunk>> stored;
    std::shared_ptr<const LoadedChunk> loaded;
    try {
        stored = _store.get(_keys[index]);
        if (stored && *stored)
            loaded = std::make_shared<const LoadedChunk>(std::move(**stored));
    } catch (const std::bad_alloc&) {
        // others wait for this chunk: they have to be told
        stored = core::failure(
            core::ErrorCode::resourceLimit,
            nameOf(_keys[index]) + " doesn't fit in memory; use fewer threads or a smaller cache");
    }
    lock.lock();
    _read.notify_all();
    if (!loaded) {
        _entries.erase(index);
        if (!stored)
            return tl::unexpected(stored.error());
        return core::failure(
            core::ErrorCode::badData,
            nameOf(_keys[index]) + " is named by the store, but not there: make the model again");
    }
    ++_statistics.loads;
    _statistics.bytes += loaded->bytes();
    _statistics.treeBytes += loaded->occupancy.bytes();
    _ages.push_front(index);
    _entries[index] = {loaded, _ages.begin()};
    evict();
    return loaded;
}

void ChunkCache::evict()
{
    while (_statistics.bytes > _mostBytes && _ages.size() > 1) {
        const auto oldest = _entries.find(_ages.back());
        _statistics.bytes -= oldest->second.chunk->bytes();
        _statistics.treeBytes -= oldest->second.chunk->occupancy.bytes();
        _entries.erase(oldest);
        _ages.pop_back();
    }
}

ChunkCache::Statistics ChunkCache::statistics() const
{
    const std::lock_guard lock(_mutex);
    return _statistics;
}

} // namespace isofront::voxels

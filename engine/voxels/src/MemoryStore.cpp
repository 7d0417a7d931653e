#include <isofront/voxels/ChunkStore.h>

#include <map>
#include <tuple>

namespace isofront::voxels {

namespace {

/// Orders keys by level, then by z, y and x.
struct KeyOrder {
    bool operator()(const ChunkKey& a, const ChunkKey& b) const
    {
        return std::tie(a.level, a.z, a.y, a.x) < std::tie(b.level, b.z, b.y, b.x);
    }
};

class MemoryStore : public ChunkStore {
public:
    std::optional<core::Error> put(Chunk chunk) override
    {
        const ChunkKey key = chunk.key;
        _directory.push_back(entryOf(chunk));
        _chunks.insert_or_assign(key, std::move(chunk));
        return std::nullopt;
    }
    std::optional<core::Error> finish(const StoredModel& model) override
    {
        _model = model;
        return std::nullopt;
    }
    [[nodiscard]] const StoredModel& model() const override { return _model; }
    [[nodiscard]] std::vector<ChunkKey> keys() const override
    {
        std::vector<ChunkKey> keys;
        keys.reserve(_chunks.size());
        for (const auto& [key, chunk] : _chunks)
            keys.push_back(key);
        return keys;
    }
    [[nodiscard]] core::Result<std::vector<ChunkEntry>> directory() const override
    {
        return _directory;
    }
    [[nodiscard]] core::Result<std::optional<Chunk>> get(const ChunkKey& key) const override
    {
        const auto found = _chunks.find(key);
        return found == _chunks.end() ? std::nullopt : std::optional(found->second);
    }

private:
    std::map<ChunkKey, Chunk, KeyOrder> _chunks;
    std::vector<ChunkEntry> _directory;
    StoredModel _model;
};

} // namespace

std::unique_ptr<ChunkStore> memoryStore()
{
    return std::make_unique<MemoryStore>();
}

} // namespace isofront::voxels

#include "ChunkLoader.h"

#include "ChunkCodec.h"
#include "StandIn.h"
#include "isofront/voxels/LevelTransition.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace isofront::voxels {

namespace {

/// Parents that stay while their children are loaded: as many as a few workers may be in.
constexpr std::size_t kParentsKept = 4;

} // namespace

std::uint64_t transitionOffset(const ChunkForm& form, const ChunkEntry& entry)
{
    constexpr std::uint64_t kWord = sizeof(std::uint32_t);
    return (form.bytes(entry) + kWord - 1) / kWord * kWord;
}

std::uint64_t transitionBytes(const ChunkEntry& entry)
{
    return (entry.voxels + 2 * std::uint64_t{entry.redundant()}) * sizeof(std::uint32_t);
}

ChunkLoader::ChunkLoader(
    std::shared_ptr<const ChunkStore> store,
    const ChunkTree& tree,
    std::span<const std::uint64_t> bytes,
    ChunkForm form,
    bool transitions,
    std::shared_ptr<core::Jobs> jobs)
    : _store(std::move(store)), _tree(tree), _bytes(bytes), _form(std::move(form)),
      _transitions(transitions), _jobs(std::move(jobs))
{
}

ChunkLoader::~ChunkLoader()
{
    std::unique_lock lock(_mutex);
    _wanted.clear();
    _changed.wait(lock, [this] { return _workers == 0; });
}

void ChunkLoader::want(const std::vector<ChunkIndex>& chunks, std::uint64_t room, bool mayExceed)
{
    std::size_t starting = 0;
    {
        const std::lock_guard lock(_mutex);
        _room = room;
        _mayExceed = mayExceed;
        _held = 0;
        for (const ChunkIndex chunk : _running)
            _held += _bytes[chunk];
        for (const Loaded& loaded : _loaded)
            _held += _bytes[loaded.index];
        _wanted.clear();
        for (const ChunkIndex chunk : chunks)
            if (!_running.contains(chunk) &&
                std::ranges::find(_loaded, chunk, &Loaded::index) == _loaded.end())
                _wanted.push_back(chunk);
        const std::size_t useful = std::min(_jobs->concurrency(), _wanted.size());
        if (useful > _workers)
            starting = useful - _workers;
        _workers += starting;
    }
    // the list is short (StreamingSettings::hostBytes), so that workers don't stay for long
    for (std::size_t i = 0; i < starting; ++i)
        _jobs->submit([this] { work(); });
}

std::vector<ChunkLoader::Loaded> ChunkLoader::take()
{
    const std::lock_guard lock(_mutex);
    return std::exchange(_loaded, {});
}

void ChunkLoader::wait()
{
    std::unique_lock lock(_mutex);
    _changed.wait(lock, [this] { return !_loaded.empty() || _workers == 0; });
}

/// For the next chunk. What was taken since the last call of want is still there.
bool ChunkLoader::hasRoom() const
{
    return _held + _bytes[_wanted.front()] <= _room || (_mayExceed && _held == 0);
}

void ChunkLoader::work()
{
    std::unique_lock lock(_mutex);
    while (!_wanted.empty() && hasRoom()) {
        const ChunkIndex index = _wanted.front();
        _wanted.pop_front();
        _running.insert(index);
        _held += _bytes[index];
        lock.unlock();
        Loaded loaded = load(index);
        lock.lock();
        _running.erase(index);
        _loaded.push_back(std::move(loaded));
        _changed.notify_all();
    }
    --_workers;
    // under the lock: once it is let go this loader may be gone
    _changed.notify_all();
}

core::Result<Chunk> ChunkLoader::read(ChunkIndex index) const
{
    const ChunkEntry& entry = _tree[index].entry;
    auto chunk = _store->get(entry.key);
    if (!chunk)
        return tl::unexpected(chunk.error());
    // the directory has said how much room there is to be
    if (!*chunk || entryOf(**chunk) != entry)
        return core::failure(
            core::ErrorCode::badData,
            _store->place() + ": " + nameOf(entry.key) +
                (*chunk ? " is damaged: it is not what the directory says" : " is missing"));
    return std::move(**chunk);
}

ChunkLoader::Loaded ChunkLoader::load(ChunkIndex index)
{
    Loaded loaded;
    loaded.index = index;
    const core::Result<Chunk> chunk = read(index);
    if (!chunk) {
        loaded.error = chunk.error();
        standIn(loaded);
        return loaded;
    }
    const ChunkEntry& entry = _tree[index].entry;
    const std::uint64_t own = _form.bytes(entry);
    const bool fades = _transitions && _tree[index].parent != kNoChunk;
    const std::uint64_t behind = fades ? transitionOffset(_form, entry) : own;
    auto data =
        std::make_shared<std::vector<std::byte>>(behind + (fades ? transitionBytes(entry) : 0));
    _form.pack(*chunk, std::span(*data).first(own));
    loaded.hasTransition = fades && addTransition(index, *chunk, std::span(*data).subspan(behind));
    loaded.data = std::move(data);
    return loaded;
}

void ChunkLoader::standIn(Loaded& loaded)
{
    const ChunkIndex index = loaded.index;
    for (ChunkIndex at = _tree[index].parent; at != kNoChunk; at = _tree[at].parent) {
        const std::shared_ptr<const Chunk> above = parent(at);
        if (!above)
            continue;
        const Chunk chunk = standInFor(_tree[index].entry.key, *above);
        const ChunkEntry entry = entryOf(chunk);
        // a directory that doesn't fit its chunks could say anything
        if (chunk.voxels.empty() || _form.bytes(entry) > _bytes[index])
            continue;
        auto data = std::make_shared<std::vector<std::byte>>(_form.bytes(entry));
        _form.pack(chunk, *data);
        loaded.data = std::move(data);
        loaded.standIn = entry;
        return;
    }
}

std::shared_ptr<const Chunk> ChunkLoader::parent(ChunkIndex index)
{
    {
        const std::lock_guard lock(_mutex);
        const auto found = std::ranges::find(_parents, index, &Parent::index);
        if (found != _parents.end())
            return found->chunk;
    }
    auto chunk = read(index);
    if (!chunk)
        return nullptr; // named when it is itself wanted
    auto kept = std::make_shared<const Chunk>(std::move(*chunk));
    const std::lock_guard lock(_mutex);
    _parents.push_back({index, kept});
    if (_parents.size() > kParentsKept)
        _parents.pop_front();
    return kept;
}

bool ChunkLoader::addTransition(ChunkIndex index, const Chunk& chunk, std::span<std::byte> data)
{
    const std::shared_ptr<const Chunk> above = parent(_tree[index].parent);
    const auto nodes = above ? transitionNodes(chunk, *above) : TransitionNodes();
    if (!nodes || nodes->bytes() != data.size())
        return false;
    const std::size_t parents = nodes->parents.size() * sizeof(std::uint32_t);
    std::memcpy(data.data(), nodes->parents.data(), parents);
    if (!nodes->redundant.empty())
        std::memcpy(data.data() + parents, nodes->redundant.data(), data.size() - parents);
    return true;
}

} // namespace isofront::voxels

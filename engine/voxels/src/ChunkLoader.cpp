#include "ChunkLoader.h"

#include "ChunkCodec.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace isofront::voxels {

ChunkLoader::ChunkLoader(
    std::shared_ptr<const ChunkStore> store,
    const ChunkTree& tree,
    ChunkForm form,
    std::shared_ptr<core::Jobs> jobs)
    : _store(std::move(store)), _tree(tree), _form(std::move(form)), _jobs(std::move(jobs))
{
}

ChunkLoader::~ChunkLoader()
{
    std::unique_lock lock(_mutex);
    _wanted.clear();
    _changed.wait(lock, [this] { return _workers == 0; });
}

void ChunkLoader::want(const std::vector<ChunkIndex>& chunks)
{
    std::size_t starting = 0;
    {
        const std::lock_guard lock(_mutex);
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

void ChunkLoader::work()
{
    std::unique_lock lock(_mutex);
    while (!_wanted.empty()) {
        const ChunkIndex index = _wanted.front();
        _wanted.pop_front();
        _running.insert(index);
        lock.unlock();
        auto data = load(index);
        lock.lock();
        _running.erase(index);
        _loaded.push_back({index, std::move(data)});
        _changed.notify_all();
    }
    --_workers;
    // under the lock: once it is let go this loader may be gone
    _changed.notify_all();
}

core::Result<std::shared_ptr<const std::vector<std::byte>>>
ChunkLoader::load(ChunkIndex index) const
{
    const ChunkEntry& entry = _tree[index].entry;
    const auto fail = [&](const char* why) {
        return core::failure(
            core::ErrorCode::badData,
            _store->model().name + ": " + nameOf(entry.key) + " is damaged: " + why);
    };
    const auto chunk = _store->get(entry.key);
    if (!chunk)
        return tl::unexpected(chunk.error());
    if (!*chunk)
        return fail("it is missing");
    // the directory has said how much room there is to be
    if (entryOf(**chunk) != entry)
        return fail("it is not what the directory says");
    auto data = std::make_shared<std::vector<std::byte>>(_form.bytes(entry));
    _form.pack(**chunk, *data);
    return data;
}

ChunkForm standardForm()
{
    ChunkForm form;
    form.bytes = [](const ChunkEntry& entry) {
        return entry.voxels *
               std::uint64_t{sizeof(Voxel) + (entry.coloured ? sizeof(std::uint32_t) : 0)};
    };
    form.pack = [](const Chunk& chunk, std::span<std::byte> data) {
        const std::vector<std::uint8_t> faces = cappedFaces(chunk);
        for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
            Voxel voxel = chunk.voxels[i];
            voxel.place = packPlace(voxel.x(), voxel.y(), voxel.z(), faces[i]);
            std::memcpy(data.data() + i * sizeof(Voxel), &voxel, sizeof(Voxel));
        }
        if (!chunk.colours.empty())
            std::memcpy(
                data.data() + chunk.voxels.size() * sizeof(Voxel),
                chunk.colours.data(),
                chunk.colours.size() * sizeof(std::uint32_t));
    };
    return form;
}

} // namespace isofront::voxels

#include "isofront/surface/SharedCells.h"

#include "CellCache.h"

#include <isofront/hierarchy/Diamond.h>

#include <atomic>
#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace isofront::surface {

namespace {

/// Names a mesh among those of all settings that are in use.
struct SharedKey {
    MeshKey mesh;
    std::size_t settings = 0; ///< all but the isovalue, by number

    bool operator==(const SharedKey&) const = default;
};

struct SharedKeyHash {
    std::size_t operator()(const SharedKey& key) const
    {
        return core::hashCombined(MeshKeyHash{}(key.mesh), key.settings);
    }
};

/// A mesh that is counted for as long as anybody has it.
class LiveMesh {
public:
    LiveMesh(extractor::CellMesh&& itsMesh, std::shared_ptr<std::atomic<std::size_t>> total)
        : mesh(std::move(itsMesh)), _bytes(mesh.bytes()), _total(std::move(total))
    {
        _total->fetch_add(_bytes, std::memory_order_relaxed);
    }
    LiveMesh(const LiveMesh&) = delete;
    LiveMesh& operator=(const LiveMesh&) = delete;
    ~LiveMesh() { _total->fetch_sub(_bytes, std::memory_order_relaxed); }

    const extractor::CellMesh mesh;

private:
    const std::size_t _bytes;
    const std::shared_ptr<std::atomic<std::size_t>> _total; ///< outlives who counts
};

} // namespace

class SharedCells::Impl {
public:
    explicit Impl(std::size_t capacity) : _capacity(capacity) {}

    CellMeshPointer extract(
        const extractor::CellExtractor& extractor,
        const hierarchy::CellId& id,
        const std::atomic<bool>* cancelled)
    {
        std::unique_lock lock(_mutex);
        // one zero: both signs are equal, and must have one hash
        const SharedKey key{
            {id, extractor.settings().isovalue + 0.0}, numberOf(extractor.settings())};
        while (true) {
            const auto found = _entries.find(key);
            if (found == _entries.end())
                break;
            if (found->second.mesh) {
                _uses.splice(_uses.begin(), _uses, found->second.use);
                ++_stats.shared;
                return found->second.mesh;
            }
            // whoever extracts it is running and waits for nobody, so this ends; if it is taken
            // back there, the next who wakes does it
            _changed.wait(lock);
            if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed))
                return nullptr;
        }
        _entries.try_emplace(key);
        lock.unlock();
        CellMeshPointer mesh;
        try {
            auto extracted = extractor.extract(hierarchy::tetrahedronOf(id), nullptr, cancelled);
            if (extracted)
                mesh = counted(std::move(*extracted));
        } catch (...) {
            lock.lock();
            _entries.erase(key);
            _changed.notify_all();
            throw;
        }
        lock.lock();
        if (mesh) {
            Entry& entry = _entries.at(key);
            entry.mesh = mesh;
            entry.use = _uses.insert(_uses.begin(), key);
            _stats.bytes += bytesOf(*mesh);
            ++_stats.extracted;
            shrink();
        } else {
            _entries.erase(key);
        }
        _changed.notify_all();
        return mesh;
    }

    void setCapacity(std::size_t bytes)
    {
        const std::lock_guard lock(_mutex);
        _capacity = bytes;
        shrink();
    }

    [[nodiscard]] Stats stats() const
    {
        const std::lock_guard lock(_mutex);
        Stats result = _stats;
        result.cells = _uses.size();
        result.liveBytes = _liveBytes->load(std::memory_order_relaxed);
        return result;
    }

private:
    struct Entry {
        CellMeshPointer mesh; ///< null while somebody extracts it
        std::list<SharedKey>::iterator use = {};
    };

    /// There are as many as there are kinds of surfaces: hardly ever more than one.
    std::size_t numberOf(extractor::ExtractionSettings settings)
    {
        settings.isovalue = 0;
        for (std::size_t i = 0; i < _settings.size(); ++i)
            if (_settings[i] == settings)
                return i;
        _settings.push_back(settings);
        return _settings.size() - 1;
    }

    [[nodiscard]] CellMeshPointer counted(extractor::CellMesh&& mesh) const
    {
        auto live = std::make_shared<LiveMesh>(std::move(mesh), _liveBytes);
        const extractor::CellMesh* itsMesh = &live->mesh;
        return {std::move(live), itsMesh};
    }

    static std::size_t bytesOf(const extractor::CellMesh& mesh)
    {
        // a node of the list and one of the map beside the mesh itself
        return mesh.bytes() + 2 * sizeof(SharedKey) + sizeof(Entry) + 8 * sizeof(void*);
    }

    void shrink() // holding the lock
    {
        while (_stats.bytes > _capacity) {
            const auto last = _entries.find(_uses.back());
            _stats.bytes -= bytesOf(*last->second.mesh);
            _entries.erase(last);
            _uses.pop_back();
        }
    }

    mutable std::mutex _mutex;
    std::condition_variable _changed; ///< an extraction has ended
    std::size_t _capacity;
    std::unordered_map<SharedKey, Entry, SharedKeyHash> _entries;
    std::list<SharedKey> _uses; ///< of entries with meshes, the most recently used first
    std::vector<extractor::ExtractionSettings> _settings;
    std::shared_ptr<std::atomic<std::size_t>> _liveBytes =
        std::make_shared<std::atomic<std::size_t>>(0);
    Stats _stats;
};

SharedCells::SharedCells(std::size_t capacityBytes) : _impl(std::make_unique<Impl>(capacityBytes))
{
}

SharedCells::~SharedCells() = default;

CellMeshPointer SharedCells::extract(
    const extractor::CellExtractor& extractor,
    const hierarchy::CellId& id,
    const std::atomic<bool>* cancelled)
{
    return _impl->extract(extractor, id, cancelled);
}

void SharedCells::setCapacity(std::size_t bytes)
{
    _impl->setCapacity(bytes);
}

SharedCells::Stats SharedCells::stats() const
{
    return _impl->stats();
}

CellMeshPointer extractShared(
    const extractor::CellExtractor& extractor,
    SharedCells* shared,
    const hierarchy::CellId& id,
    const std::atomic<bool>* cancelled)
{
    if (shared != nullptr)
        return shared->extract(extractor, id, cancelled);
    auto mesh = extractor.extract(hierarchy::tetrahedronOf(id), nullptr, cancelled);
    return mesh ? std::make_shared<const extractor::CellMesh>(std::move(*mesh)) : nullptr;
}

} // namespace isofront::surface

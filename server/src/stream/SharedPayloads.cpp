#include "SharedPayloads.h"

#include <list>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace isofront::server {

class SharedPayloads::Impl {
public:
    using Mesh = extractor::CellMesh;

    explicit Impl(std::size_t capacity) : _capacity(capacity) {}

    std::shared_ptr<const CellPayload> encoded(const std::shared_ptr<const Mesh>& mesh)
    {
        {
            const std::lock_guard lock(_mutex);
            const auto found = _entries.find(mesh.get());
            // another mesh may lie where one lay
            if (found != _entries.end() && found->second.mesh.lock() == mesh) {
                _uses.splice(_uses.begin(), _uses, found->second.use);
                ++_stats.shared;
                return found->second.payload;
            }
        }
        // Two may do it at once: it takes less than to wait for each other.
        auto payload = std::make_shared<const CellPayload>(encodeCell(*mesh));
        const std::lock_guard lock(_mutex);
        ++_stats.encoded;
        const auto [entry, isNew] = _entries.try_emplace(mesh.get());
        if (isNew) {
            entry->second.use = _uses.insert(_uses.begin(), mesh.get());
        } else {
            _stats.bytes -= bytesOf(entry->second);
            _uses.splice(_uses.begin(), _uses, entry->second.use);
        }
        entry->second.mesh = mesh;
        entry->second.payload = payload;
        _stats.bytes += bytesOf(entry->second);
        while (_stats.bytes > _capacity) {
            const auto last = _entries.find(_uses.back());
            _stats.bytes -= bytesOf(last->second);
            _entries.erase(last);
            _uses.pop_back();
        }
        return payload;
    }

    [[nodiscard]] Stats stats() const
    {
        const std::lock_guard lock(_mutex);
        return _stats;
    }

private:
    struct Entry {
        std::weak_ptr<const Mesh> mesh;
        std::shared_ptr<const CellPayload> payload;
        std::list<const Mesh*>::iterator use = {};
    };

    static std::size_t bytesOf(const Entry& entry)
    {
        // the payload, a node of the map and one of the list, and what is left of a mesh that has
        // gone but whose block is still named here
        return entry.payload->bytes.size() + sizeof(CellPayload) + sizeof(Entry) + sizeof(Mesh) +
               12 * sizeof(void*);
    }

    mutable std::mutex _mutex;
    const std::size_t _capacity;
    std::unordered_map<const Mesh*, Entry> _entries;
    std::list<const Mesh*> _uses; ///< the most recently used first
    Stats _stats;
};

SharedPayloads::SharedPayloads(std::size_t capacityBytes)
    : _impl(std::make_unique<Impl>(capacityBytes))
{
}

SharedPayloads::~SharedPayloads() = default;

std::shared_ptr<const CellPayload>
SharedPayloads::encoded(const std::shared_ptr<const extractor::CellMesh>& mesh)
{
    return _impl->encoded(mesh);
}

SharedPayloads::Stats SharedPayloads::stats() const
{
    return _impl->stats();
}

} // namespace isofront::server

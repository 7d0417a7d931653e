#include "CellCache.h"

#include <utility>

namespace isofront::surface {

std::size_t CellCache::bytesOf(const Entry& entry)
{
    // a node of the list and one of the map beside the mesh itself
    return entry.mesh->bytes() + sizeof(Entry) + 8 * sizeof(void*);
}

void CellCache::insert(const hierarchy::CellId& id, CellMeshPointer mesh)
{
    take(id);
    _entries.push_front({id, std::move(mesh)});
    _found[id] = _entries.begin();
    _bytes += bytesOf(_entries.front());
    while (_bytes > _capacity) {
        _bytes -= bytesOf(_entries.back());
        _found.erase(_entries.back().id);
        _entries.pop_back();
    }
}

CellMeshPointer CellCache::take(const hierarchy::CellId& id)
{
    const auto found = _found.find(id);
    if (found == _found.end())
        return nullptr;
    const auto entry = found->second;
    _bytes -= bytesOf(*entry);
    CellMeshPointer mesh = entry->mesh;
    _entries.erase(entry);
    _found.erase(found);
    return mesh;
}

} // namespace isofront::surface

#include "CellCache.h"

#include <utility>

namespace isofront::surface {

const CellMeshPointer& meshOfEmptyCell(bool provedEmpty)
{
    static const auto emptyMesh = [](bool proved) {
        extractor::CellMesh mesh;
        mesh.stats.provedEmpty = proved;
        return std::make_shared<const extractor::CellMesh>(std::move(mesh));
    };
    static const CellMeshPointer kEmpty = emptyMesh(false);
    static const CellMeshPointer kProvedEmpty = emptyMesh(true);
    return provedEmpty ? kProvedEmpty : kEmpty;
}

std::size_t CellCache::bytesOf(const Entry& entry)
{
    // a node of the list and one of the map beside the mesh itself
    return entry.mesh->bytes() + sizeof(Entry) + 8 * sizeof(void*);
}

void CellCache::insert(const MeshKey& key, CellMeshPointer mesh)
{
    take(key);
    _entries.push_front({key, std::move(mesh)});
    _found[key] = _entries.begin();
    _bytes += bytesOf(_entries.front());
    shrink();
}

CellMeshPointer CellCache::find(const MeshKey& key) const
{
    const auto found = _found.find(key);
    return found == _found.end() ? nullptr : found->second->mesh;
}

void CellCache::setCapacity(std::size_t bytes)
{
    _capacity = bytes;
    shrink();
}

void CellCache::shrink()
{
    while (_bytes > _capacity) {
        _bytes -= bytesOf(_entries.back());
        _found.erase(_entries.back().key);
        _entries.pop_back();
    }
}

CellMeshPointer CellCache::take(const MeshKey& key)
{
    const auto found = _found.find(key);
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

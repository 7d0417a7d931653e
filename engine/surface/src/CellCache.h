#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/hierarchy/CellId.h>

#include <cstddef>
#include <list>
#include <memory>
#include <unordered_map>

namespace isofront::surface {

using CellMeshPointer = std::shared_ptr<const extractor::CellMesh>;

/// Meshes of cells that are not shown now but may be again, the least recently used let go first
/// when their bytes exceed a bound.
///
/// Thread: one at a time.
class CellCache {
public:
    explicit CellCache(std::size_t capacityBytes) : _capacity(capacityBytes) {}

    void insert(const hierarchy::CellId& id, CellMeshPointer mesh);
    /// Hands the mesh over and forgets it; null if it isn't here.
    CellMeshPointer take(const hierarchy::CellId& id);

    [[nodiscard]] std::size_t bytes() const { return _bytes; }

private:
    struct Entry {
        hierarchy::CellId id;
        CellMeshPointer mesh;
    };

    static std::size_t bytesOf(const Entry& entry);

    std::size_t _capacity;
    std::size_t _bytes = 0;
    std::list<Entry> _entries; ///< the most recently used first
    std::unordered_map<hierarchy::CellId, std::list<Entry>::iterator, hierarchy::CellIdHash> _found;
};

} // namespace isofront::surface

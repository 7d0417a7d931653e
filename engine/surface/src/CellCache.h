#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/hierarchy/CellId.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>

namespace isofront::surface {

using CellMeshPointer = std::shared_ptr<const extractor::CellMesh>;

/// Names a mesh: a cell has one for each isovalue.
struct MeshKey {
    hierarchy::CellId cell;
    double isovalue = 0;

    bool operator==(const MeshKey&) const = default;
};

struct MeshKeyHash {
    std::size_t operator()(const MeshKey& key) const
    {
        return core::hashCombined(
            hierarchy::CellIdHash{}(key.cell), std::bit_cast<std::uint64_t>(key.isovalue));
    }
};

/// What stands for a cell that has been found to have no triangles: the same mesh for all.
/// @param provedEmpty  by bounds, so that it was never sampled
const CellMeshPointer& meshOfEmptyCell(bool provedEmpty);

/// Meshes of cells that are not shown now but may be again, the least recently used let go first
/// when their bytes exceed a bound.
///
/// Thread: one at a time.
class CellCache {
public:
    explicit CellCache(std::size_t capacityBytes) : _capacity(capacityBytes) {}

    void insert(const MeshKey& key, CellMeshPointer mesh);
    /// Hands the mesh over and forgets it; null if it isn't here.
    CellMeshPointer take(const MeshKey& key);

    /// The mesh, if it is here, which stays; null otherwise. Any number of threads while nobody
    /// else calls.
    [[nodiscard]] CellMeshPointer find(const MeshKey& key) const;
    /// Lets go of the least recently used until the rest fits.
    void setCapacity(std::size_t bytes);

    [[nodiscard]] std::size_t bytes() const { return _bytes; }

private:
    struct Entry {
        MeshKey key;
        CellMeshPointer mesh;
    };

    static std::size_t bytesOf(const Entry& entry);
    void shrink();

    std::size_t _capacity;
    std::size_t _bytes = 0;
    std::list<Entry> _entries; ///< the most recently used first
    std::unordered_map<MeshKey, std::list<Entry>::iterator, MeshKeyHash> _found;
};

} // namespace isofront::surface

#pragma once

#include "CellCache.h"
#include "isofront/surface/Delta.h"

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isofront::surface {

/// Collects what a series of splits and merges adds up to: a cell that came and went is not
/// mentioned, and those that replace one another share a step.
///
/// Thread: one at a time.
class DeltaBuilder {
public:
    /// What follows belongs to the split or merge of this diamond.
    void begin(const hierarchy::LatticePoint& diamond);
    /// @param mesh  null if the cell has no triangles
    void remove(const CellId& id, const CellMeshPointer& mesh);
    void add(const CellId& id, CellMeshPointer mesh);

    /// Leaves nothing behind. Steps in the order of their diamonds, cells of each by their names.
    Delta build(std::uint64_t version, double isovalue);

private:
    /// Steps that replace each other's cells are joined into trees; a root's diamond names them.
    struct Step {
        hierarchy::LatticePoint diamond;
        int level = 0;
        std::size_t parent = 0;
    };
    struct Entry {
        CellMeshPointer mesh;
        std::size_t step = 0;
    };

    std::size_t rootOf(std::size_t step);
    void join(std::size_t a, std::size_t b);

    std::vector<Step> _steps;
    std::unordered_map<CellId, Entry, CellIdHash> _removed;
    std::unordered_map<CellId, Entry, CellIdHash> _added;
};

} // namespace isofront::surface

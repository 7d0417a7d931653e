#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/hierarchy/CellId.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace isofront::surface {

using hierarchy::CellId;
using hierarchy::CellIdHash;

/// A cell that has a surface in it.
class ShownCell {
public:
    ShownCell(CellId cellId, std::shared_ptr<const extractor::CellMesh> cellMesh)
        : id(cellId), _mesh(std::move(cellMesh))
    {
    }
    CellId id;
    /// Never null, never without triangles.
    [[nodiscard]] const std::shared_ptr<const extractor::CellMesh>& mesh() const { return _mesh; }

private:
    std::shared_ptr<const extractor::CellMesh> _mesh;
};

/// One step from a crack-free mesh to the next: take away what is removed, add what is added, and
/// show nothing in between. Cells without triangles are not mentioned.
struct Delta {
    std::uint64_t version = 0; ///< counts the deltas of a surface that changed something
    std::vector<CellId> removed;
    std::vector<ShownCell> added;

    [[nodiscard]] bool isEmpty() const { return removed.empty() && added.empty(); }
};

} // namespace isofront::surface

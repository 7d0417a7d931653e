#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/hierarchy/LatticePoint.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace isofront::surface {

/// Names a cell for as long as the domain exists: the centre of its longest edge, and which of the
/// tetrahedra around that edge it is.
struct CellId {
    hierarchy::LatticePoint spine;
    std::uint8_t index = 0;

    auto operator<=>(const CellId&) const = default;
};

struct CellIdHash {
    std::size_t operator()(const CellId& id) const
    {
        return core::hashCombined(hierarchy::LatticePointHash{}(id.spine), id.index);
    }
};

/// A cell that has a surface in it.
class ShownCell {
public:
    ShownCell(CellId cellId, std::shared_ptr<const extractor::CellMesh> cellMesh)
        : id(cellId),
          _mesh(std::move(cellMesh))
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

#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/hierarchy/CellId.h>

#include <cstddef>
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

/// A part of a delta: what covers one part of space before and after it.
struct DeltaStep {
    hierarchy::LatticePoint diamond; ///< the coarsest that was split or merged here
    std::size_t removed = 0;         ///< so many cells of Delta::removed belong to it
    std::size_t added = 0;           ///< and so many of Delta::added
};

/// One step from a crack-free mesh to the next: take away what is removed, then add what is added,
/// and show nothing in between. Cells without triangles are not mentioned. A cell may be in both
/// lists, with another mesh.
struct Delta {
    std::uint64_t version = 0; ///< counts the deltas of a surface that changed something
    double isovalue = 0;       ///< of everything that is shown from this delta on [field units]
    std::vector<CellId> removed;
    std::vector<ShownCell> added;
    /// The same by diamonds, for who fades from one to the other: the first step has the first
    /// `removed` cells and the first `added`, the second those after them, and so on.
    std::vector<DeltaStep> steps;

    [[nodiscard]] bool isEmpty() const { return removed.empty() && added.empty(); }
};

} // namespace isofront::surface

#pragma once

#include <isofront/core/FlatMap.h>
#include <isofront/hierarchy/CellId.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/hierarchy/Diamond.h>

#include <cstddef>
#include <vector>

namespace isofront::hierarchy {

/// A diamond and which of its tetrahedra are cells: a bit for each index.
struct FrontDiamond {
    LatticePoint centre;
    std::uint8_t cells = 0;
};

/// A conforming set of cells that tile the domain: the leaves of the bisection hierarchy.
///
/// Diamonds are split and merged whole, parents before children, so that at every moment each face
/// of a cell belongs to exactly two cells, or to one at the domain's border. Which front results
/// from a set of splits doesn't depend on their order.
///
/// Cost: a split or a merge takes constant time, and `refine` up to about 29 splits a level.
/// Thread: one at a time.
class Front {
public:
    /// The six cells of the root.
    Front();

    [[nodiscard]] bool isSplit(const LatticePoint& diamond) const;
    /// True if all tetrahedra of the diamond are cells of the front.
    [[nodiscard]] bool isComplete(const LatticePoint& diamond) const;
    /// True if some tetrahedron of the diamond is a cell of the front, or it is split.
    [[nodiscard]] bool isKnown(const LatticePoint& diamond) const;
    [[nodiscard]] bool hasCell(const CellId& id) const;
    /// How a diamond stands on the front; neither split nor with cells if it isn't known.
    [[nodiscard]] DiamondState stateOf(const LatticePoint& diamond) const;
    /// True if the diamond is split and none of its children is.
    [[nodiscard]] bool isMergeable(const LatticePoint& diamond) const;

    /// Halves the tetrahedra of a complete diamond above the deepest level (both asserted).
    void split(const LatticePoint& diamond);
    /// Undoes a split of a mergeable diamond (asserted).
    void merge(const LatticePoint& diamond);
    /// Splits a diamond and all that must be split before it, ancestors first.
    /// @return what was split, in that order; empty if the diamond was split already
    std::vector<LatticePoint> refine(const LatticePoint& diamond);
    /// What `refine` would split, in that order.
    [[nodiscard]] std::vector<LatticePoint> closureOf(const LatticePoint& diamond) const;

    [[nodiscard]] std::size_t cellCount() const { return _cellCount; }
    [[nodiscard]] std::size_t splitCount() const { return _splitCount; }
    /// Memory held, about [bytes].
    [[nodiscard]] std::size_t bytes() const;

    /// Calls `visit(id, tetrahedron)` for each cell, in no promised order.
    template <typename Visit>
    void forEachCell(const Visit& visit) const
    {
        _nodes.forEach([&](const Nodes::Entry& entry) {
            const auto& [centre, node] = entry;
            if (node.present == 0)
                return;
            const DiamondTetrahedra all = tetrahedraOf(Diamond(centre));
            for (std::size_t i = 0; i < all.size(); ++i)
                if ((unsigned{node.present} >> all.index(i) & 1U) != 0)
                    visit(CellId{centre, all.index(i)}, all.tetrahedron(i));
        });
    }
    /// The diamonds that have cells, in no promised order.
    [[nodiscard]] std::vector<FrontDiamond> diamondsWithCells() const;
    /// The diamonds that have cells or are split, in no promised order.
    [[nodiscard]] std::vector<LatticePoint> diamonds() const;
    /// Calls `visit(centre)` for each diamond that has cells or is split, in no promised order.
    template <typename Visit>
    void forEachDiamond(const Visit& visit) const
    {
        _nodes.forEach([&](const Nodes::Entry& entry) { visit(entry.first); });
    }

    /// The cells are the same.
    bool operator==(const Front& other) const;

private:
    struct Node {
        std::uint8_t present = 0; ///< a bit for each tetrahedron that is a cell
        bool split = false;

        bool operator==(const Node&) const = default;
    };
    using Nodes = core::FlatMap<LatticePoint, Node, LatticePointHash>;

    void add(const CellId& id);
    void remove(const CellId& id);

    Nodes _nodes{kNoLatticePoint};
    std::size_t _cellCount = 0;
    std::size_t _splitCount = 0;
};

} // namespace isofront::hierarchy

#pragma once

#include <isofront/hierarchy/LatticePoint.h>

#include <compare>

namespace isofront::hierarchy {

/// Names a cell for as long as the domain exists: the centre of its longest edge, and which of the
/// tetrahedra around that edge it is.
struct CellId {
    LatticePoint spine;
    std::uint8_t index = 0;

    auto operator<=>(const CellId&) const = default;
};

struct CellIdHash {
    std::size_t operator()(const CellId& id) const
    {
        return core::hashCombined(LatticePointHash{}(id.spine), id.index);
    }
};

} // namespace isofront::hierarchy

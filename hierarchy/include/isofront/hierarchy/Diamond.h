#pragma once

#include <isofront/hierarchy/CellId.h>
#include <isofront/hierarchy/LatticePoint.h>
#include <isofront/hierarchy/Tetrahedron.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isofront::hierarchy {

/// The diamond of level 0, whose tetrahedra fill the domain.
inline constexpr LatticePoint kRootDiamond{kLatticeEdge / 2, kLatticeEdge / 2, kLatticeEdge / 2};

/// All tetrahedra that share one longest edge, the spine. A diamond is named by its centre, and all
/// else follows from the bits of the centre's coordinates.
///
/// Source: K. Weiss and L. De Floriani, "Simplex and diamond hierarchies: models and applications"
/// (2011). Differs: coordinates may reach the far border of the domain, so 32 bits hold 31 levels.
struct Diamond {
    explicit Diamond(const LatticePoint& diamondCentre);

    LatticePoint centre;
    int level = 0;              ///< of its tetrahedra
    std::uint32_t halfEdge = 0; ///< h [lattice units]: half the edge of the cubes of this level
    std::array<bool, 3> odd{};  ///< axes along which the spine runs: 3 - class of them
    LatticePoint spineBegin;    ///< corner 0 of each tetrahedron
    LatticePoint spineFinish;   ///< the other end of the spine

    [[nodiscard]] int congruenceClass() const { return level % 3; }
    /// Radius of the sphere around the centre that holds all tetrahedra [lattice units].
    [[nodiscard]] double radius() const;
};

/// A few lattice points, at most eight.
class LatticePoints {
public:
    void push(const LatticePoint& point) { _points[_count++] = point; }
    [[nodiscard]] std::size_t size() const { return _count; }
    [[nodiscard]] const LatticePoint* begin() const { return _points.data(); }
    [[nodiscard]] const LatticePoint* end() const { return _points.data() + _count; }

private:
    std::array<LatticePoint, 8> _points{};
    std::size_t _count = 0;
};

/// The diamonds that must be split before this one is complete, by their centres: 3, 2 or 4 inside
/// the domain by class, fewer at its border, none for the root.
LatticePoints parentsOf(const Diamond& diamond);

/// The diamonds to which the halves of this one's tetrahedra belong: 6, 4 or 8 inside the domain,
/// fewer at its border. Not for the deepest level (asserted).
LatticePoints childrenOf(const Diamond& diamond);

/// The tetrahedra of a diamond, each with the index that names it for good.
class DiamondTetrahedra {
public:
    void push(std::uint8_t index, const Tetrahedron& tetrahedron)
    {
        _index[_count] = index;
        _tetrahedra[_count++] = tetrahedron;
    }
    [[nodiscard]] std::size_t size() const { return _count; }
    [[nodiscard]] std::uint8_t index(std::size_t i) const { return _index[i]; }
    [[nodiscard]] const Tetrahedron& tetrahedron(std::size_t i) const { return _tetrahedra[i]; }
    /// A bit for each index that occurs.
    [[nodiscard]] std::uint8_t mask() const;

private:
    std::array<std::uint8_t, 8> _index{};
    std::array<Tetrahedron, 8> _tetrahedra{};
    std::size_t _count = 0;
};

/// The tetrahedra around a diamond's spine: 6, 4 or 8 inside the domain by class; 4, 2 or fewer at
/// its border.
DiamondTetrahedra tetrahedraOf(const Diamond& diamond);

/// Names a tetrahedron by its spine, and finds it again.
CellId cellIdOf(const Tetrahedron& tetrahedron);
Tetrahedron tetrahedronOf(const CellId& id);

} // namespace isofront::hierarchy

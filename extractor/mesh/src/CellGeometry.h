#pragma once

#include "isofront/extractor/VolumeMesh.h"

#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/Tetrahedron.h>

#include <array>
#include <cstddef>

namespace isofront::extractor {

/// What a cell's corners determine, in forms that every cell around a shared face, edge or corner
/// derives alike.
struct CellGeometry {
    CellGeometry(
        const hierarchy::Tetrahedron& cell, const hierarchy::Domain& domain, int latticeSize);

    /// The nearest point of the grid that a feature defines to a point in sample units, of which
    /// the lattice unit holds `denominator`.
    [[nodiscard]] hierarchy::GridPoint
    snapped(const glm::dvec3& p, FeatureMask feature, std::uint32_t denominator) const;

    /// The tetrahedron's corners in lexicographic order of their coordinates: whatever is summed in
    /// floating point is summed in this order.
    std::array<std::size_t, 4> sorted{};
    /// Filter radius along the edge between sorted corners 01, 02, 03, 12, 13, 23 [field].
    std::array<double, 6> edgeRadius{};
    /// By feature: vertices on it are snapped to multiples of 2^this grid units.
    std::array<int, 16> snapExponent{};
    /// By feature: how many of these multiples a lattice unit is.
    std::array<double, 16> unitsPerLatticeUnit{};
    int cellExponent = 0; ///< the smallest of them
    bool mirrored = false;
    hierarchy::LatticePoint low;
    hierarchy::LatticePoint high;
};

} // namespace isofront::extractor

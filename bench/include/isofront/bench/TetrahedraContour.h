#pragma once

#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/TriangleMesh.h>

#include <cstddef>

namespace isofront::bench {

struct TetrahedraMesh {
    surface::TriangleMesh mesh;
    std::size_t tetrahedra = 0; ///< that were looked at: their field's bounds allow a surface
    std::size_t samples = 0;
    std::size_t hierarchyNodes = 0; ///< tetrahedra of all levels on the way there
};

/// The surface straight from the tetrahedra of the bisection hierarchy at one level, one or two
/// triangles each: what cells with a lattice of hexahedra are an answer to.
///
/// Source: B. Gregorski, M. Duchaineau, P. Lindstrom, V. Pascucci, K. Joy, "Interactive
/// view-dependent rendering of large isosurfaces" (2002), for the contour. Differs: one level
/// everywhere, and each edge's vertex is shared.
TetrahedraMesh marchingTetrahedra(
    const fields::Field& field, double isovalue, const hierarchy::Domain& domain, int level);

} // namespace isofront::bench

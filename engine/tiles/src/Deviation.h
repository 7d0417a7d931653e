#pragma once

#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/TriangleMesh.h>

#include <cstdint>
#include <span>

namespace isofront::tiles {

/// How far the middles of triangles are from the unfiltered surface, at most, by the field's value
/// and slope there [world]. Triangles in the domain's walls or those of the data are left out: no
/// value says where those are.
/// @param step  of the lattice [field]; no distance counts as more than one
double largestDeviation(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    double isovalue,
    const surface::TriangleMesh& mesh,
    std::span<const std::uint32_t> triangles,
    double step);

} // namespace isofront::tiles

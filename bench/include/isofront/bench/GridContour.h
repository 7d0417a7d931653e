#pragma once

#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/TriangleMesh.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace isofront::bench {

/// A field on a regular grid: what methods on grids begin with.
struct GridSamples {
    glm::dvec3 origin{0.0};     ///< of the first point [field]
    double spacing = 1;         ///< [field]
    std::array<int, 3> count{}; ///< points along each axis
    std::vector<float> values;  ///< x fastest, then y
};

/// Samples the domain's cube with so many cells along each axis, unfiltered.
GridSamples sampledGrid(const fields::Field& field, const hierarchy::Domain& domain, int cells);

/// Plain marching cubes on a regular grid: each sample is a corner of a cube, each crossing a
/// vertex where linear interpolation puts it. The yardstick for everything else.
///
/// Source: W. Lorensen and H. Cline, "Marching cubes" (1987). Differs: the table is
/// extractor::MarchingCubesTable, whose ambiguous sides agree between neighbours.
/// @param field  for normals: its gradient at the vertices; null leaves them out
surface::TriangleMesh marchingCubes(
    const GridSamples& grid,
    double isovalue,
    const hierarchy::Domain& domain,
    const fields::Field* field);

/// Unit normals of a mesh's vertices, down the field, unfiltered.
void setNormals(
    surface::TriangleMesh& mesh, const fields::Field& field, const hierarchy::Domain& domain);

} // namespace isofront::bench

#pragma once

#include "CellFrame.h"
#include "CellGeometry.h"
#include "RoughMesh.h"
#include "Samples.h"
#include "VertexMoves.h"
#include "isofront/extractor/CellExtractor.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::extractor {

// Triangles whose corners lie on a curved surface lie all on its inner side: a mesh of a ball is
// too small. Moving the corners out by the right share of that makes the mean square of the
// distance about four times smaller.

/// What balancing reuses from cell to cell.
struct BalanceScratch {
    std::vector<double> height, target, diagonal, rest;
    std::vector<std::uint16_t> chosen;
    std::vector<glm::dvec3> normal;
};

/// Slides border vertices along their lattice edges, so that they lie above the surface by an
/// eighth of its mean curvature times the mean squared length of the edges that meet at such a
/// vertex. That length comes from the size of the face or edge of the tetrahedron that the vertex
/// lies on, the curvature from gradients half a lattice edge away from the vertex on four sides:
/// all of it is the same in every cell that has the vertex. A vertex stays on its lattice edge,
/// 1/64 away from the ends, so the topology can't change, and it moves by a quarter of it at most.
void balanceBorders(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const hierarchy::Tetrahedron& cell,
    const CellGeometry& geometry,
    const VolumeMesh& volumeMesh,
    const Samples& samples,
    RoughMesh& mesh,
    PointColumns& points,
    BalanceScratch& scratch);

/// Moves the free vertices along their normals to where the mean squared distance of the triangles
/// from the surface is least: the surface over a triangle is taken as the quadratic that its
/// corners' normals tell, and the linear system is that of its projection to the mesh.
/// @param normals   unit normals of all vertices
/// @param axisStep  [cell units]; no vertex moves by more than a quarter
void balanceInside(
    const RoughMesh& mesh,
    const std::vector<glm::dvec3>& normals,
    double axisStep,
    VertexMoves& moves,
    BalanceScratch& scratch);

} // namespace isofront::extractor

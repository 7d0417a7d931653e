#pragma once

#include "CellFrame.h"
#include "RoughMesh.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// What aligning edges reuses from cell to cell.
struct AlignmentScratch {
    std::vector<glm::dvec3> position;
    std::vector<std::uint32_t> firstCorner; ///< by vertex
    std::vector<std::uint32_t> nextCorner;  ///< of the same vertex
    std::vector<std::uint8_t> changed;      ///< by triangle, in this round
    std::vector<std::uint8_t> changedBefore;
};

/// Replaces the edge between two triangles by the other diagonal of their quadrangle wherever that
/// brings them nearer to the surface, as the vertices' normals tell it: edges then run along the
/// directions in which the surface bends least. Vertices stay where they are.
///
/// Triangles at caps stay as they are, and no new edge joins two border vertices of one face, since
/// the neighbour's mesh may have an edge between the same two.
///
/// Source: N. Dyn, D. Levin and S. Rippa, "Data dependent triangulations for piecewise linear
/// interpolation" (1990). Differs: the criterion is the integral of the squared error of the
/// quadratic surface that the normals tell; where the surface is flat, that of a slightly round
/// one, which prefers compact triangles.
///
/// @param normals   unit normals of all vertices
/// @param axisStep  of the cell's level [cell units]
void alignEdges(
    RoughMesh& mesh,
    const CellFrame& frame,
    const std::vector<glm::dvec3>& normals,
    double axisStep,
    AlignmentScratch& scratch);

} // namespace isofront::extractor

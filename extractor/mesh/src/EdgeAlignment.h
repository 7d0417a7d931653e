#pragma once

#include "CellFrame.h"
#include "RoughMesh.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// What aligning edges reuses from cell to cell.
struct AlignmentScratch {
    static constexpr std::uint32_t kNone = 0xffffffffU;

    /// What a side of a triangle adds to its error.
    struct Side {
        double bend = 0;    ///< how much the normal turns along it, times its length [cell units]
        double squared = 0; ///< its length [cell units]
        double turn = 0;    ///< the squared difference of its ends' normals
    };

    std::vector<glm::dvec3> position;
    std::vector<std::uint32_t> firstCorner; ///< by vertex
    // by corner, for the side from its vertex to the next one's
    std::vector<std::uint32_t> nextCorner; ///< of the same vertex
    std::vector<std::uint32_t> across;     ///< the corner of the same side in the other triangle
    std::vector<Side> side;
    std::vector<std::uint8_t> waiting; ///< in the queue
    std::vector<double> error;         ///< by triangle
    std::vector<std::uint32_t> queue;
};

/// Replaces the edge between two triangles by the other diagonal of their quadrangle wherever that
/// brings them nearer to the surface, as the vertices' normals tell it: edges then run along the
/// directions in which the surface bends least. Vertices stay where they are.
///
/// Triangles at caps stay as they are, and no new edge joins two border vertices of one face, since
/// the neighbour's mesh may have an edge between the same two.
///
/// Source: N. Dyn, D. Levin and S. Rippa, "Data dependent triangulations for piecewise linear
/// interpolation" (1990). Differs: the criterion is the squared error at the middles of the sides,
/// by the quadratic surface that the normals tell, times the area. The exact integral over the
/// triangle has their sum squared, too; that gains nothing in error and makes more slivers. To the
/// quadratic surface is added a slightly round one, which prefers compact triangles where the
/// surface is flat, and more so where normals turn so much that they tell little.
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

#pragma once

#include "RoughMesh.h"
#include "VertexMoves.h"
#include "isofront/extractor/CellExtractor.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// What smoothing reuses from cell to cell.
struct SmoothingScratch {
    std::vector<glm::dvec3> sum;
    std::vector<std::uint16_t> neighbours;
};

/// Evens out the triangles inside a cell without shrinking what they enclose: each pass moves every
/// free vertex half of the way to the middle of its neighbours, and then a little more away from
/// the middle of those. All vertices move at once, so their order doesn't matter.
///
/// Source: G. Taubin, "A signal processing approach to fair surface design" (1995). Differs: border
/// vertices stay, so that cells still fit together.
void smooth(const RoughMesh& mesh, int iterations, VertexMoves& moves, SmoothingScratch& scratch);

/// Brings the free vertices back to the surface: one Newton step along the gradient at each one's
/// filter radius, of at most half of the axis step. Where the field gives no usable gradient, a
/// vertex goes nowhere.
/// @param axisStep  of the cell's level [field]
void reproject(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& mesh,
    const CellFrame& frame,
    double axisStep,
    VertexMoves& moves,
    PointColumns& points);

} // namespace isofront::extractor

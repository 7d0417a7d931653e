#pragma once

#include "RoughMesh.h"
#include "isofront/extractor/CellExtractor.h"

namespace isofront::extractor {

/// Fills in CellStats::errorRms and errorMax: the distance of triangles' centres, at most 128 of
/// them, from the unfiltered field's surface, by one Newton step. Caps are exact and left out.
/// @param rough  of a cell with at least one triangle
void estimateError(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& rough,
    PointColumns& points,
    CellMesh& mesh);

} // namespace isofront::extractor

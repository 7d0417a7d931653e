#pragma once

#include "isofront/bench/DistanceMeasure.h"
#include "isofront/bench/Table.h"
#include "isofront/bench/Timing.h"
#include "isofront/bench/Topology.h"

#include <vector>

namespace isofront::bench {

/// The columns that most tables of meshes share: step, triangles, time, errors, topology.
void appendFigureColumns(Table& table);

/// What belongs under those columns, for a mesh.
/// @param step  of its lattice [world]
/// @param edge  of the domain [world]
Topology appendFigures(
    std::vector<Cell>& row,
    const surface::TriangleMesh& mesh,
    double step,
    double edge,
    const Timing& timing,
    const DistanceMeasure& measure);

} // namespace isofront::bench

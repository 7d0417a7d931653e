#include "Figures.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

namespace isofront::bench {

namespace {

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 20> text{};
    (void)std::snprintf(
        text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

} // namespace

void appendFigureColumns(Table& table)
{
    const std::vector<Column> columns = {
        {"step", "edge", "lattice step, as a share of the domain's edge"},
        {"triangles", "", "triangles"},
        {"cpu", "ms", "processor time, sampling to normals, one thread"},
        {"runs", "", "timed runs"},
        {"error", "edge", "root mean square distance, the larger of both ways"},
        {"rms", "steps", "mesh to surface, root mean square"},
        {"p99", "steps", "mesh to surface, 99 % below"},
        {"max", "steps", "mesh to surface, greatest"},
        {"back_rms", "steps", "surface to mesh, root mean square"},
        {"back_p99", "steps", "surface to mesh, 99 % below"},
        {"back_max", "steps", "surface to mesh, greatest"},
        {"normal", "deg", "angle of normals, root mean square"},
        {"normal_p99", "deg", "angle of normals, 99 % below"},
        {"components", "", "parts of the mesh"},
        {"missed", "", "parts of the surface without mesh"},
        {"euler", "", "Euler number"},
        {"quality", "", "mean triangle quality, 1 is equilateral"},
        {"slivers", "%", "triangles of quality below 0.2"},
        {"six", "%", "inner vertices with six triangles"},
        {"constant", "", "rms [edge] times triangles: constant for methods of second order"},
        {"lost", "%", "samples without surface in reach"},
        {"checksum", "", "of positions and indices"}};
    table.columns.insert(table.columns.end(), columns.begin(), columns.end());
}

Topology appendFigures(
    std::vector<Cell>& row,
    const surface::TriangleMesh& mesh,
    double step,
    double edge,
    const Timing& timing,
    const DistanceMeasure& measure)
{
    const SurfaceError error = measure.of(mesh, step);
    Topology topology = topologyOf(mesh);
    const std::size_t triangles = mesh.indices.size() / 3;
    const double perStep = 1 / step;
    const std::vector<Cell> cells = {
        step / edge,
        count(triangles),
        1e3 * timing.least,
        count(timing.runs),
        std::max(error.toSurface.rms, error.toMesh.rms) / edge,
        error.toSurface.rms * perStep,
        error.toSurface.p99 * perStep,
        error.toSurface.max * perStep,
        error.toMesh.rms * perStep,
        error.toMesh.p99 * perStep,
        error.toMesh.max * perStep,
        error.normal.rms,
        error.normal.p99,
        count(topology.components),
        count(error.missedComponents),
        count(topology.euler),
        topology.quality,
        100.0 * static_cast<double>(topology.slivers) /
            static_cast<double>(std::max<std::size_t>(triangles, 1)),
        100 * topology.sixShare,
        error.toSurface.rms / edge * static_cast<double>(triangles),
        100 * error.lostShare,
        hexadecimal(checksumOf(mesh))};
    row.insert(row.end(), cells.begin(), cells.end());
    return topology;
}

} // namespace isofront::bench

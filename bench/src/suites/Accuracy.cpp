// After Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with View-Dependent Level of
// Detail and Applications", Fig. 17: error over triangles at uniform detail, for cells, marching
// cubes and the tetrahedra of the hierarchy.

#include "Figures.h"
#include "Subjects.h"
#include "Suites.h"
#include "isofront/bench/GridContour.h"
#include "isofront/bench/Peers.h"
#include "isofront/bench/TetrahedraContour.h"
#include "isofront/bench/Topology.h"

#include <isofront/hierarchy/Criterion.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace isofront::bench {

namespace {

Table errorTable()
{
    Table table{
        "errors",
        "Error, time and topology of each method at each step",
        {{"field", "", "what is meshed"}, {"method", "", "how: cells of lattice size n are ours"}},
        {},
        {}};
    appendFigureColumns(table);
    return table;
}

struct Meshed {
    surface::TriangleMesh mesh;
    double step = 0; ///< [world]
    Timing timing;
};

struct Method {
    std::string name;
    std::function<Meshed(const Subject&, int stepsPerEdge)> mesh;
};

Method cellsMethod(int latticeSize)
{
    return {
        "cells n=" + std::to_string(latticeSize),
        [latticeSize](const Subject& subject, int stepsPerEdge) {
            const int level = levelForShare(1.0 / stepsPerEdge, latticeSize);
            CellsMesh cells =
                cellsMesh(subject, settingsFor(subject, latticeSize, level), level, 5);
            return Meshed{std::move(cells.extracted.mesh), cells.step, cells.timing};
        }};
}

Meshed byGrid(const Subject& subject, int stepsPerEdge)
{
    Meshed meshed;
    meshed.step = subject.domain.edge / stepsPerEdge;
    meshed.timing = timed([&] {
        const GridSamples grid = sampledGrid(*subject.field, subject.domain, stepsPerEdge);
        meshed.mesh = marchingCubes(grid, subject.isovalue, subject.domain, subject.field.get());
    });
    return meshed;
}

Method peerMethod(const GridPeer& peer)
{
    return {peer.name, [&peer](const Subject& subject, int stepsPerEdge) {
                Meshed meshed;
                meshed.step = subject.domain.edge / stepsPerEdge;
                meshed.timing = timed([&] {
                    const GridSamples grid =
                        sampledGrid(*subject.field, subject.domain, stepsPerEdge);
                    meshed.mesh = peer.mesh(grid, subject.isovalue);
                });
                return meshed;
            }};
}

Meshed byTetrahedra(const Subject& subject, int stepsPerEdge)
{
    Meshed meshed;
    int level = 0;
    while (1 << (level / 3) < stepsPerEdge)
        level += 3;
    meshed.step = subject.domain.edge / (1 << (level / 3));
    meshed.timing = timed([&] {
        meshed.mesh =
            marchingTetrahedra(*subject.field, subject.isovalue, subject.domain, level).mesh;
    });
    return meshed;
}

std::vector<Method> methods()
{
    std::vector<Method> all = {
        cellsMethod(4),
        cellsMethod(8),
        cellsMethod(16),
        {"marching cubes", byGrid},
        {"tetrahedra", byTetrahedra}};
    for (const GridPeer& peer : gridPeers())
        all.push_back(peerMethod(peer));
    return all;
}

/// Slope of the line of least squares through the logarithms of one curve.
double slopeOf(const Table& table, const std::string& field, const std::string& method)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        if (table.word(row, "field") != field || table.word(row, "method") != method)
            continue;
        const double a = std::log(table.number(row, "triangles"));
        const double b = std::log(table.number(row, "error"));
        n += 1;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    const double spread = n * xx - x * x;
    return n > 1 && spread > 0 ? (n * xy - x * y) / spread
                               : std::numeric_limits<double>::quiet_NaN();
}

/// A plane askew to the lattice: what is flat has no error, so only the mesh itself counts.
Table flatTable(const Context& context)
{
    Table table{
        "flat",
        "The mesh of a plane (Fig. 6): cells of hexahedra against tetrahedra",
        {{"method", "", "how"},
         {"step", "edge", "lattice step, as a share of the domain's edge"},
         {"triangles", "", "triangles"},
         {"valence", "", "mean number of triangles around an inner vertex"},
         {"six", "%", "inner vertices with six triangles, the best"},
         {"quality", "", "mean triangle quality, 1 is equilateral"},
         {"slivers", "%", "triangles of quality below 0.2"}},
        {},
        {}};
    const Subject subject = planeSubject();
    for (const Method& method : methods()) {
        const Meshed meshed = method.mesh(subject, context.pick(32, 128));
        const Topology topology = topologyOf(meshed.mesh);
        const auto triangles = static_cast<double>(meshed.mesh.indices.size() / 3);
        table.add(
            {method.name,
             meshed.step / subject.domain.edge,
             count(meshed.mesh.indices.size() / 3),
             topology.meanValence,
             100 * topology.sixShare,
             topology.quality,
             100 * static_cast<double>(topology.slivers) / std::max(triangles, 1.0)});
    }
    return table;
}

} // namespace

SuiteResult runAccuracy(const Context& context)
{
    SuiteResult result;
    Table errors = errorTable();
    std::vector<Subject> subjects = {sphereSubject(), gyroidSubject(), canyonSubject()};
    if (context.isFull())
        subjects.insert(subjects.begin() + 1, {steepSubject(), torusSubject()});
    const std::vector<int> resolutions = context.pick<std::vector<int>>({16, 32}, {32, 64, 128});
    for (const Subject& subject : subjects) {
        const DistanceMeasure measure = measureFor(
            context,
            subject,
            context.pick(1.0 / 64, 1.0 / 256),
            context.pick<std::size_t>(2000, 20000));
        for (const Method& method : methods())
            for (const int resolution : resolutions) {
                if (context.isStopped())
                    return result;
                context.say(
                    subject.name + ", " + method.name + ", 1/" + std::to_string(resolution));
                const Meshed meshed = method.mesh(subject, resolution);
                std::vector<Cell> row{subject.name, method.name};
                const Topology topology = appendFigures(
                    row, meshed.mesh, meshed.step, subject.domain.edge, meshed.timing, measure);
                errors.add(std::move(row));
                if (subject.name == "sphere" || subject.name == "torus") {
                    const long wanted = subject.name == "sphere" ? 2 : 0;
                    result.check(
                        subject.name + " by " + method.name + " has its topology",
                        topology.euler == wanted && topology.openEdges == 0,
                        "Euler number " + std::to_string(topology.euler));
                }
            }
        for (const char* const over : {"triangles", "cpu"})
            errors.plots.push_back(
                {subject.name + "-" + over,
                 subject.name + ": error over " +
                     (std::string(over) == "cpu" ? "time" : "triangles"),
                 over,
                 "error",
                 "method",
                 "field",
                 subject.name,
                 true,
                 true,
                 subject.isSmooth && std::string(over) == "triangles" ? std::vector<double>{-1}
                                                                      : std::vector<double>{}});
    }
    Table slopes{
        "slopes",
        "How fast the error falls: slope of log error over log triangles (-1 is second order)",
        {{"field", "", ""}, {"method", "", ""}, {"slope", "", "of the error over triangles"}},
        {},
        {}};
    for (const Subject& subject : subjects)
        for (const Method& method : methods()) {
            const double slope = slopeOf(errors, subject.name, method.name);
            slopes.add({subject.name, method.name, slope});
            if (subject.name == "sphere" && method.name == "marching cubes")
                result.check(
                    "marching cubes is of second order on the sphere",
                    std::abs(slope + 1) < 0.1,
                    "slope " + textOf(slope));
        }
    result.tables = {std::move(errors), std::move(slopes), flatTable(context)};
    return result;
}

} // namespace isofront::bench

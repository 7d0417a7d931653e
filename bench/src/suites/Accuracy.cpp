// After Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with View-Dependent Level of
// Detail and Applications", Fig. 17: error over triangles at uniform detail, for cells, marching
// cubes and the tetrahedra of the hierarchy. And what better triangles make of it: how many
// triangles each way takes for the same error as marching cubes on a plain grid.

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
#include <utility>

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
    /// Timed so many times at most.
    std::function<Meshed(const Subject&, int stepsPerEdge, std::size_t runs)> mesh;
};

Method cellsMethod(int latticeSize, const std::string& how = "", const Polish& polish = {})
{
    return {
        "cells n=" + std::to_string(latticeSize) + (how.empty() ? "" : ", " + how),
        [latticeSize, polish](const Subject& subject, int stepsPerEdge, std::size_t runs) {
            const int level = levelForShare(1.0 / stepsPerEdge, latticeSize);
            auto settings = settingsFor(subject, latticeSize, level);
            if (polish)
                polish(settings);
            CellsMesh cells = cellsMesh(subject, settings, level, runs);
            return Meshed{std::move(cells.extracted.mesh), cells.step, cells.timing};
        }};
}

Meshed byGrid(const Subject& subject, int stepsPerEdge, std::size_t runs)
{
    Meshed meshed;
    meshed.step = subject.domain.edge / stepsPerEdge;
    meshed.timing = timed(
        [&] {
            const GridSamples grid = sampledGrid(*subject.field, subject.domain, stepsPerEdge);
            meshed.mesh =
                marchingCubes(grid, subject.isovalue, subject.domain, subject.field.get());
        },
        runs);
    return meshed;
}

Method peerMethod(const GridPeer& peer)
{
    return {peer.name, [&peer](const Subject& subject, int stepsPerEdge, std::size_t runs) {
                Meshed meshed;
                meshed.step = subject.domain.edge / stepsPerEdge;
                meshed.timing = timed(
                    [&] {
                        const GridSamples grid =
                            sampledGrid(*subject.field, subject.domain, stepsPerEdge);
                        meshed.mesh = peer.mesh(grid, subject.isovalue);
                    },
                    runs);
                return meshed;
            }};
}

Meshed byTetrahedra(const Subject& subject, int stepsPerEdge, std::size_t runs)
{
    Meshed meshed;
    int level = 0;
    while (1 << (level / 3) < stepsPerEdge)
        level += 3;
    meshed.step = subject.domain.edge / (1 << (level / 3));
    meshed.timing = timed(
        [&] {
            meshed.mesh =
                marchingTetrahedra(*subject.field, subject.isovalue, subject.domain, level).mesh;
        },
        runs);
    return meshed;
}

bool isAdaptive(const GridPeer& peer)
{
    return peer.name.find("adaptive") != std::string::npos;
}

/// One resolution everywhere, triangles as they are contoured.
std::vector<Method> methods()
{
    std::vector<Method> all = {
        {"marching cubes", byGrid},
        cellsMethod(4),
        cellsMethod(8),
        cellsMethod(16),
        {"tetrahedra", byTetrahedra}};
    for (const GridPeer& peer : gridPeers())
        if (!isAdaptive(peer))
            all.push_back(peerMethod(peer));
    return all;
}

const char* const kGood = "good";
const char* const kBest = "best";
const char* const kNothingRemoved = "best, nothing removed";
const char* const kForLand = "best, simplified to 0.2";

/// Better triangles.
std::vector<Method> betterMethods()
{
    std::vector<Method> all = {
        cellsMethod(4, kGood, goodTriangles()),
        cellsMethod(4, kBest, bestTriangles()),
        cellsMethod(8, kNothingRemoved, bestTriangles(0)),
        cellsMethod(8, kBest, bestTriangles()),
        cellsMethod(8, kForLand, bestTriangles(0.2))};
    for (const GridPeer& peer : gridPeers())
        if (isAdaptive(peer))
            all.push_back(peerMethod(peer));
    return all;
}

/// How many triangles marching cubes takes for each error, between what was measured and beyond.
class GridCurve {
public:
    /// Finer and finer.
    void add(double error, double triangles)
    {
        _points.emplace_back(std::log(error), std::log(triangles));
    }
    [[nodiscard]] double trianglesFor(double error) const
    {
        const double at = std::log(error);
        std::size_t i = 0;
        while (i + 2 < _points.size() && at < _points[i + 1].first)
            ++i;
        const auto& [nearError, near] = _points[i];
        const auto& [farError, far] = _points[i + 1];
        return std::exp(near + (at - nearError) / (farError - nearError) * (far - near));
    }

private:
    std::vector<std::pair<double, double>> _points; ///< logarithms
};

/// What is promised of the ratio of triangles to those of marching cubes.
void checkRatios(const Context& context, SuiteResult& result, const Table& table, int finest)
{
    const auto hold = [&](const std::string& field, const std::string& method, double most) {
        for (std::size_t row = 0; row < table.rows.size(); ++row)
            if (table.word(row, "field") == field && table.word(row, "method") == method &&
                table.number(row, "resolution") == finest)
                result.check(
                    field + " by " + method + " takes at most " + textOf(most) +
                        " of marching cubes' triangles for the same error",
                    table.number(row, "ratio") <= most,
                    textOf(table.number(row, "ratio")));
    };
    // the gyroid wants more than eight steps a period
    for (const char* const field :
         context.pick<std::vector<const char*>>({"sphere"}, {"sphere", "torus", "gyroid"})) {
        hold(field, std::string("cells n=4, ") + kGood, 1.6);
        hold(field, std::string("cells n=4, ") + kBest, 1.0);
        hold(field, std::string("cells n=8, ") + kNothingRemoved, 1.1);
    }
    hold("canyon", std::string("cells n=8, ") + kForLand, 0.45);
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
        const Meshed meshed = method.mesh(subject, context.pick(32, 128), context.runs());
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
    Table better{
        "better",
        "Triangles that each way takes, over those of marching cubes for the same error",
        {{"field", "", "what is meshed"},
         {"method", "", "how: cells of lattice size n are ours"},
         {"resolution", "", "steps along the domain's edge"},
         {"ratio", "", "triangles over those of marching cubes with the same error"}},
        {},
        {}};
    appendFigureColumns(better);
    std::vector<Subject> subjects = {sphereSubject(), gyroidSubject(), canyonSubject()};
    if (context.isFull())
        subjects.insert(subjects.begin() + 1, {steepSubject(), torusSubject()});
    const std::vector<int> resolutions = context.pick<std::vector<int>>({16, 32}, {32, 64, 128});
    for (const Subject& subject : subjects) {
        const DistanceMeasure measure = measureFor(
            context,
            subject,
            context.pick(1.0 / 64, 1.0 / 256),
            context.pick<std::size_t>(500, 20000));
        GridCurve grid;
        const auto measured = [&](const Method& method, int resolution) {
            context.say(subject.name + ", " + method.name + ", 1/" + std::to_string(resolution));
            const Meshed meshed = method.mesh(subject, resolution, context.runs());
            std::vector<Cell> row;
            const Topology topology = appendFigures(
                row, meshed.mesh, meshed.step, subject.domain.edge, meshed.timing, measure);
            if (subject.name == "sphere" || subject.name == "torus") {
                const long wanted = subject.name == "sphere" ? 2 : 0;
                result.check(
                    subject.name + " by " + method.name + " has its topology",
                    topology.euler == wanted && topology.openEdges == 0,
                    "Euler number " + std::to_string(topology.euler));
            }
            return row;
        };
        const auto enter =
            [&](const std::string& method, int resolution, const std::vector<Cell>& figures) {
                std::vector<Cell> row{subject.name, method, count(resolution), 1.0};
                row.insert(row.end(), figures.begin(), figures.end());
                better.add(std::move(row));
                const std::size_t at = better.rows.size() - 1;
                const double triangles = better.number(at, "triangles");
                const double error = better.number(at, "error");
                if (method == "marching cubes")
                    grid.add(error, triangles);
                else
                    better.rows[at][better.column("ratio")] = triangles / grid.trianglesFor(error);
            };
        const auto isInBoth = [](const std::string& name) {
            return name == "marching cubes" || name == "cells n=4";
        };
        for (const Method& method : methods()) {
            std::vector<int> all = resolutions;
            if (method.name == "marching cubes") // the others' errors must lie between its own
                all.push_back(2 * resolutions.back());
            for (const int resolution : all) {
                if (context.isStopped())
                    return result;
                const std::vector<Cell> figures = measured(method, resolution);
                if (isInBoth(method.name))
                    enter(method.name, resolution, figures);
                std::vector<Cell> row{subject.name, method.name};
                row.insert(row.end(), figures.begin(), figures.end());
                if (resolution <= resolutions.back())
                    errors.add(std::move(row));
            }
        }
        for (const Method& method : betterMethods())
            for (const int resolution : resolutions) {
                if (context.isStopped())
                    return result;
                enter(method.name, resolution, measured(method, resolution));
            }
        const std::vector<double> guides =
            subject.isSmooth ? std::vector<double>{-1} : std::vector<double>{};
        for (const bool byTime : {false, true})
            errors.plots.push_back(
                {subject.name + (byTime ? "-cpu" : "-triangles"),
                 subject.name + ": error over " + (byTime ? "time" : "triangles"),
                 byTime ? "cpu" : "triangles",
                 "error",
                 "method",
                 "field",
                 subject.name,
                 true,
                 true,
                 byTime ? std::vector<double>{} : guides});
        better.plots.push_back(
            {subject.name + "-better",
             subject.name + ": error over triangles, with better triangles",
             "triangles",
             "error",
             "method",
             "field",
             subject.name,
             true,
             true,
             guides});
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
    checkRatios(context, result, better, resolutions.back());
    result.tables = {std::move(errors), std::move(better), std::move(slopes), flatTable(context)};
    return result;
}

} // namespace isofront::bench

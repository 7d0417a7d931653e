// After Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with View-Dependent Level of
// Detail and Applications", Table 1 and Fig. 16: where the time in a cell goes, and the order of
// its triangles.

#include "Subjects.h"
#include "Suites.h"

#include <isofront/core/Hash.h>
#include <isofront/extractor/MarchingCubesTable.h>
#include <isofront/extractor/VolumeMesh.h>
#include <isofront/fields/Procedural.h>
#include <isofront/hierarchy/Tetrahedron.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

using extractor::CellExtractor;
using extractor::CellTrace;
using extractor::VolumeMesh;
using hierarchy::Tetrahedron;

/// All tetrahedra of a level, or those of them that `isWanted` keeps with their ancestors.
void visitLevel(
    const Tetrahedron& tetrahedron,
    int level,
    const std::function<bool(const Tetrahedron&)>& isWanted,
    const std::function<void(const Tetrahedron&)>& visit)
{
    if (!isWanted(tetrahedron))
        return;
    if (tetrahedron.level == level) {
        visit(tetrahedron);
        return;
    }
    for (const Tetrahedron& half : tetrahedron.bisected())
        visitLevel(half, level, isWanted, visit);
}

core::Box boxOf(const hierarchy::Domain& domain, const Tetrahedron& tetrahedron)
{
    return {
        domain.fieldFromLattice(tetrahedron.low()), domain.fieldFromLattice(tetrahedron.high())};
}

/// Cells with a surface, evenly spread over those there are.
std::vector<Tetrahedron>
cellsWithSurface(const CellExtractor& extractor, int level, std::size_t most)
{
    std::vector<Tetrahedron> all;
    for (const Tetrahedron& root : hierarchy::rootTetrahedra())
        visitLevel(
            root,
            level,
            [&](const Tetrahedron& t) {
                return !extractor.provesEmpty(boxOf(extractor.domain(), t));
            },
            [&](const Tetrahedron& t) { all.push_back(t); });
    std::vector<Tetrahedron> found;
    // a stride that has no divisor in common with the order of bisection
    for (std::size_t i = 0; i < all.size() && found.size() < most; ++i) {
        const Tetrahedron& cell = all[i * 7919 % all.size()];
        if (const auto mesh = extractor.extract(cell); mesh && mesh->triangleCount() > 0)
            found.push_back(cell);
    }
    return found;
}

} // namespace

SuiteResult runStages(const Context& context)
{
    Table table{
        "stages",
        "Time of one cell with a surface by stage",
        {{"field", "", "what is meshed"},
         {"lattice", "", "n"},
         {"meshes", "", "as contoured, or smoothed once and simplified to 5 % of a step"},
         {"cells", "", "measured"},
         {"triangles", "", "a cell"},
         {"total", "us", "processor time of a cell"},
         {"sampling", "%", "of the time: points and the field"},
         {"contouring", "%", "of the time: marching cubes, snapping, borders"},
         {"smoothing", "%", "of the time"},
         {"simplifying", "%", "of the time"},
         {"normals", "%", "of the time: gradients at the vertices"},
         {"samples_per_second", "M/s", "of the field, over the time of sampling"}},
        {},
        {}};
    SuiteResult result;
    struct Stages {
        double sample = 0, contour = 0, smooth = 0, simplify = 0, normal = 0;
        [[nodiscard]] double sum() const
        {
            return std::max(sample + contour + smooth + simplify + normal, 1e-12);
        }
    };
    for (const Subject& subject : {sphereSubject(), gyroidSubject(), canyonSubject()})
        for (const int n : {4, 8, 16})
            for (const bool isFinished : {false, true}) {
                if (context.isStopped())
                    return result;
                context.say(subject.name + ", n = " + std::to_string(n));
                const int level = levelForShare(1.0 / 64, n);
                extractor::ExtractionSettings settings = settingsFor(subject, n, level);
                if (isFinished) {
                    settings.smoothIterations = 1;
                    settings.simplifyError = 0.05;
                }
                const CellExtractor extractor(subject.field, subject.domain, settings);
                const auto cells = cellsWithSurface(
                    extractor,
                    level,
                    context.pick<std::size_t>(16384, 262144) / std::size_t(n * n * n));
                Stages least;
                std::uint64_t triangles = 0;
                std::uint64_t samples = 0;
                const Timing timing = timed([&] {
                    Stages now;
                    triangles = samples = 0;
                    for (const Tetrahedron& cell : cells) {
                        CellTrace trace;
                        const auto mesh = extractor.extract(cell, &trace);
                        triangles += mesh->triangleCount();
                        samples += mesh->stats.samples;
                        now.sample += trace.sampleSeconds;
                        now.contour += trace.contourSeconds;
                        now.smooth += trace.smoothSeconds;
                        now.simplify += trace.simplifySeconds;
                        now.normal += trace.normalSeconds;
                    }
                    // traces go by the clock: the run that was disturbed least tells the shares
                    if (least.sample == 0 || now.sum() < least.sum())
                        least = now;
                });
                const auto number = static_cast<double>(std::max<std::size_t>(cells.size(), 1));
                const double percent = 100 / least.sum();
                const double sampling = timing.least * least.sample / least.sum();
                table.add(
                    {subject.name,
                     std::to_string(n),
                     std::string(isFinished ? "smoothed, simplified" : "as contoured"),
                     count(cells.size()),
                     static_cast<double>(triangles) / number,
                     1e6 * timing.least / number,
                     percent * least.sample,
                     percent * least.contour,
                     percent * least.smooth,
                     percent * least.simplify,
                     percent * least.normal,
                     1e-6 * static_cast<double>(samples) / std::max(sampling, 1e-12)});
                result.check(
                    "every cell of the " + subject.name +
                        " that is timed has triangles, n = " + std::to_string(n),
                    !cells.empty() && triangles >= cells.size(),
                    std::to_string(cells.size()) + " cells");
            }
    result.tables = {std::move(table)};
    return result;
}

namespace {

/// How many vertices a cache that holds the last ones used has to fetch, a triangle.
double missesPerTriangle(const std::vector<std::uint32_t>& indices, std::size_t cacheSize)
{
    std::vector<std::uint32_t> cache;
    std::size_t next = 0;
    std::size_t misses = 0;
    for (const std::uint32_t index : indices) {
        if (std::ranges::find(cache, index) != cache.end())
            continue;
        ++misses;
        if (cache.size() < cacheSize)
            cache.push_back(index);
        else
            cache[next] = index;
        next = (next + 1) % cacheSize;
    }
    return indices.empty()
               ? 0
               : static_cast<double>(misses) / (static_cast<double>(indices.size()) / 3);
}

/// The places of a volume mesh's hexahedra if they stood in rows: block by block, x fastest.
std::vector<std::size_t> rowOrder(const VolumeMesh& volume)
{
    const auto n = static_cast<std::uint32_t>(volume.latticeSize());
    // a block's axes, as in VolumeMesh: its own corner, then the corners that x, y and z run to
    constexpr std::array<std::array<std::size_t, 4>, 4> kAxes{
        {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}}};
    std::vector<std::size_t> order(volume.hexahedra.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // the low corner of a hexahedron by its exact weights
    std::map<std::pair<std::size_t, std::array<std::uint32_t, 4>>, std::size_t> placeOf;
    std::size_t place = 0;
    for (std::size_t block = 0; block < 4; ++block)
        for (std::uint32_t z = 0; z < n; ++z)
            for (std::uint32_t y = 0; y < n; ++y)
                for (std::uint32_t x = 0; x < n; ++x) {
                    std::array<std::uint32_t, 4> weights{};
                    for (unsigned m = 0; m < 8; ++m) {
                        const std::uint32_t factor = ((m & 1U) != 0 ? x : n - x) *
                                                     ((m & 2U) != 0 ? y : n - y) *
                                                     ((m & 4U) != 0 ? z : n - z);
                        const unsigned corners = 1 + (m & 1U) + (m >> 1U & 1U) + (m >> 2U & 1U);
                        for (unsigned i = 0; i < 4; ++i)
                            if (i == 0 || (m >> (i - 1) & 1U) != 0)
                                weights[kAxes[block][i]] += factor * (12 / corners);
                    }
                    placeOf[{block, weights}] = place++;
                }
    std::vector<std::size_t> places(order.size());
    const std::size_t blockSize = std::size_t{n} * n * n;
    for (std::size_t h = 0; h < order.size(); ++h)
        places[h] = placeOf.at({h / blockSize, volume.weights[volume.hexahedra[h].vertex[0]]});
    std::ranges::sort(order, {}, [&](std::size_t h) { return places[h]; });
    return order;
}

} // namespace

SuiteResult runHilbert(const Context& context)
{
    Table table{
        "order",
        "Vertices fetched for each triangle, by the order of hexahedra",
        {{"field", "", "what is meshed"},
         {"lattice", "", "n"},
         {"order", "", "of the hexahedra in a cell"},
         {"cells", "", "with a surface"},
         {"triangles", "", "of them"},
         {"fetched_16", "", "vertices a triangle with a cache of 16"},
         {"fetched_32", "", "vertices a triangle with a cache of 32"}},
        {},
        {}};
    SuiteResult result;
    const auto& cubes = extractor::MarchingCubesTable::instance();
    for (const Subject& subject : {sphereSubject(), gyroidSubject(), canyonSubject()})
        for (const int n : {8, 16}) {
            if (context.isStopped())
                return result;
            context.say(subject.name + ", n = " + std::to_string(n));
            const VolumeMesh& volume = VolumeMesh::ofSize(n);
            const int level = levelForShare(1.0 / 64, n);
            const CellExtractor extractor(
                subject.field, subject.domain, settingsFor(subject, n, level));
            const auto cells =
                cellsWithSurface(extractor, level, context.pick<std::size_t>(40, 400));
            std::vector<std::size_t> hilbert(volume.hexahedra.size());
            std::iota(hilbert.begin(), hilbert.end(), std::size_t{0});
            std::vector<std::size_t> shuffled = hilbert;
            std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(1));
            const std::vector<std::pair<std::string, std::vector<std::size_t>>> orders = {
                {"Hilbert", hilbert}, {"rows", rowOrder(volume)}, {"random", shuffled}};
            std::vector<double> fetched;
            std::vector<std::size_t> made;
            std::size_t ours = 0;
            for (const auto& [name, order] : orders) {
                double misses16 = 0, misses32 = 0;
                std::size_t triangles = 0;
                ours = 0;
                for (const Tetrahedron& cell : cells) {
                    const std::size_t points = volume.vertexCount();
                    std::vector<double> x(points), y(points), z(points);
                    std::vector<float> values(points);
                    for (std::size_t v = 0; v < points; ++v) {
                        glm::dvec3 p(0.0);
                        for (std::size_t i = 0; i < 4; ++i)
                            p += double(volume.weights[v][i]) / double(volume.denominator()) *
                                 subject.domain.fieldFromLattice(cell.corner[i]);
                        x[v] = p.x;
                        y[v] = p.y;
                        z[v] = p.z;
                    }
                    subject.field->sample({x, y, z}, values);
                    std::vector<std::uint32_t> indices; // of lattice edges: a vertex each
                    for (const std::size_t h : order) {
                        const extractor::Hexahedron& hexahedron = volume.hexahedra[h];
                        unsigned configuration = 0;
                        for (unsigned m = 0; m < 8; ++m)
                            if (double(values[hexahedron.vertex[m]]) >= subject.isovalue)
                                configuration |= 1U << m;
                        const auto& shape = cubes[static_cast<std::uint8_t>(configuration)];
                        for (std::size_t t = 0; t < shape.triangles; ++t)
                            for (const std::uint8_t edge : shape.edge[t])
                                indices.push_back(hexahedron.edge[edge]);
                    }
                    const auto number = static_cast<double>(indices.size() / 3);
                    misses16 += number * missesPerTriangle(indices, 16);
                    misses32 += number * missesPerTriangle(indices, 32);
                    triangles += indices.size() / 3;
                    ours += extractor.extract(cell)->triangleCount();
                }
                const auto all = static_cast<double>(std::max<std::size_t>(triangles, 1));
                table.add(
                    {subject.name,
                     std::to_string(n),
                     name,
                     count(cells.size()),
                     count(triangles),
                     misses16 / all,
                     misses32 / all});
                fetched.push_back(misses16 / all);
                made.push_back(triangles);
            }
            const std::string what = subject.name + ", n = " + std::to_string(n);
            result.check(
                "every order makes the triangles of the product, " + what,
                std::ranges::count(made, ours) == 3,
                std::to_string(ours));
            result.check(
                "Hilbert order fetches least, " + what,
                fetched[0] < fetched[1] && fetched[1] < fetched[2],
                textOf(fetched[0]) + ", " + textOf(fetched[1]) + ", " + textOf(fetched[2]));
        }
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runBounds(const Context& context)
{
    Table table{
        "bounds",
        "Cells that hold no surface, and those of them that are proved to",
        {{"source", "", "procedural source"},
         {"lattice", "", "n"},
         {"level", "", "of the cells"},
         {"cells", "", "of the whole domain"},
         {"empty", "", "without a triangle"},
         {"proved", "", "of them by bounds"},
         {"share", "%", "of the empty ones that are proved"},
         {"with", "ms", "processor time of all cells, bounds used"},
         {"without", "ms", "processor time of all cells, every one sampled"}},
        {},
        {{"share",
          "Share of empty cells that are proved empty",
          "level",
          "share",
          "source",
          "",
          "",
          false,
          false,
          {}}}};
    SuiteResult result;
    constexpr int kLattice = 4;
    std::vector<std::pair<std::string, std::map<std::string, std::string>>> sources;
    for (const auto& description : fields::proceduralSources())
        if (description.name != "terrain")
            sources.push_back({description.name, {}});
    for (const char* const preset : {"alpine", "canyon", "islands"})
        sources.push_back({"terrain", {{"preset", preset}}});
    for (const auto& [name, parameters] : sources) {
        const auto made = fields::makeProcedural(name, parameters);
        if (!made)
            continue;
        const std::string title =
            parameters.empty() ? name : name + " " + parameters.begin()->second;
        for (const int level : context.pick<std::vector<int>>({6, 9}, {6, 9, 12})) {
            if (context.isStopped())
                return result;
            context.say(title + ", level " + std::to_string(level));
            const hierarchy::Domain domain{made->domain.low, made->domain.size().x};
            extractor::ExtractionSettings settings;
            settings.latticeSize = kLattice;
            settings.isovalue = made->isovalue;
            settings.cornerRadius = domain.edge / 1e4;
            const CellExtractor skipping(made->field, domain, settings);
            settings.skipEmptyCells = false;
            const CellExtractor sampling(made->field, domain, settings);
            std::vector<Tetrahedron> cells;
            for (const Tetrahedron& root : hierarchy::rootTetrahedra())
                visitLevel(
                    root,
                    level,
                    [](const Tetrahedron&) { return true; },
                    [&](const Tetrahedron& cell) { cells.push_back(cell); });
            std::vector<char> proved(cells.size(), 0);
            std::vector<char> empty(cells.size(), 0);
            const auto runAll = [&](const CellExtractor& extractor, std::vector<char>& facts) {
                return timed(
                    [&] {
                        context.jobs->parallelFor((cells.size() + 63) / 64, [&](std::size_t b) {
                            for (std::size_t i = b * 64; i < std::min(cells.size(), b * 64 + 64);
                                 ++i) {
                                const auto mesh = extractor.extract(cells[i]);
                                facts[i] = &extractor == &skipping
                                               ? char(mesh->stats.provedEmpty)
                                               : char(mesh->triangleCount() == 0);
                            }
                        });
                    },
                    1);
            };
            const Timing with = runAll(skipping, proved);
            const Timing without = runAll(sampling, empty);
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < cells.size(); ++i)
                wrong += proved[i] != 0 && empty[i] == 0 ? 1U : 0U;
            const auto emptyCells = std::ranges::count(empty, char{1});
            const auto provedCells = std::ranges::count(proved, char{1});
            table.add(
                {title,
                 std::to_string(kLattice),
                 count(level),
                 count(cells.size()),
                 count(emptyCells),
                 count(provedCells),
                 emptyCells > 0 ? 100.0 * double(provedCells) / double(emptyCells) : std::nan(""),
                 1e3 * with.least,
                 1e3 * without.least});
            result.check(
                "no cell with a surface is proved empty, " + title + " at level " +
                    std::to_string(level),
                wrong == 0,
                std::to_string(wrong) + " of " + std::to_string(cells.size()));
        }
    }
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench

// How soon the whole surface of a view is there at another isovalue, and whether a frame waits.

#include "Scans.h"
#include "Suites.h"

#include <isofront/hierarchy/Diamond.h>
#include <isofront/surface/Surface.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace isofront::bench {

namespace {

using Clock = std::chrono::steady_clock;
using Cells = std::map<surface::CellId, std::shared_ptr<const extractor::CellMesh>>;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void show(const surface::Delta& delta, Cells& cells)
{
    for (const surface::CellId& id : delta.removed)
        cells.erase(id);
    for (const surface::ShownCell& cell : delta.added)
        cells[cell.id] = cell.mesh();
}

bool isSame(const extractor::CellMesh& a, const extractor::CellMesh& b)
{
    return a.vertices == b.vertices && a.indices == b.indices && a.low == b.low &&
           a.exponent == b.exponent;
}

bool areSame(const Cells& a, const Cells& b)
{
    return std::ranges::equal(a, b, [](const auto& one, const auto& other) {
        return one.first == other.first && isSame(*one.second, *other.second);
    });
}

surface::SurfaceOptions optionsFor(const OpenScan& scan, double isovalue, double filter)
{
    surface::SurfaceOptions options;
    options.extraction = scan.settings(isovalue, filter);
    options.pixelError = 1;
    options.maxLevel = scan.nativeLevel + 6;
    return options;
}

/// Frames in which nothing happens, in which a surface does all that the last change has left.
void rest(surface::Surface& surface, const hierarchy::View& view, Cells& cells)
{
    constexpr int kFrames = 30;
    for (int frame = 0; frame < kFrames || !surface.isSettled(); ++frame)
        show(surface.update(view, {.milliseconds = 2}), cells);
}

/// One change, as a host that draws sees it.
struct Change {
    double seconds = 0;   ///< until the delta was there
    double processor = 0; ///< time of all threads, meanwhile [s]
    double longest = 0;   ///< call of update, meanwhile [s]
    std::uint64_t retested = 0;
    std::uint64_t empty = 0;
    std::uint64_t extracted = 0;
    std::uint64_t cached = 0;
};

Change
changed(surface::Surface& surface, const hierarchy::View& view, double isovalue, Cells& cells)
{
    const surface::SurfaceStats before = surface.stats();
    Change change;
    const std::clock_t processor = std::clock();
    const auto start = Clock::now();
    surface.setIsovalue(isovalue);
    for (;;) {
        const auto call = Clock::now();
        const surface::Delta delta = surface.update(view, {.milliseconds = 2});
        change.longest = std::max(change.longest, secondsSince(call));
        if (!delta.isEmpty()) {
            change.seconds = secondsSince(start);
            change.processor = double(std::clock() - processor) / CLOCKS_PER_SEC;
            show(delta, cells);
            break;
        }
        std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    const surface::SurfaceStats after = surface.stats();
    change.empty = after.cellsSkipped - before.cellsSkipped;
    change.extracted = after.cellsExtracted - before.cellsExtracted;
    change.cached = after.cellsFromCache - before.cellsFromCache;
    change.retested = change.empty + change.extracted + change.cached;
    return change;
}

double median(std::vector<double> values)
{
    std::ranges::sort(values);
    return values[values.size() / 2];
}

} // namespace

SuiteResult runIsovalue(const Context& context)
{
    SuiteResult result;
    Table table{
        "isovalue",
        "Another isovalue for all of a view, to one pixel at 1280 x 720",
        {{"source", "", "what is seen"},
         {"filter", "", "strength of the low-pass filter"},
         {"threads", "", "at work beside the one that draws"},
         {"meshes", "", "new: no such isovalue was shown before; kept: of one that was"},
         {"from", "", "isovalue"},
         {"to", "", "isovalue"},
         {"before", "", "triangles"},
         {"after", "", "triangles"},
         {"least", "ms", "until the whole new surface was there"},
         {"median", "ms", "the same, of all changes"},
         {"cpu", "ms", "least processor time, all threads together"},
         {"longest", "ms", "that a call of update took meanwhile"},
         {"cells", "", "of the front that were asked about"},
         {"empty", "", "of them proved empty by bounds, not sampled"},
         {"extracted", "", "of them"},
         {"cached", "", "of them, as they were shown before"},
         {"runs", "", "changes"}},
        {},
        {}};
    const std::vector<Scan> scans =
        context.isFull()
            ? std::vector<
                  Scan>{{"engine", "engine_256x256x128_u8.nrrd", 110}, {"cranium", "cranium_ct_256x256x108_i16.nrrd", 300}}
            : std::vector<Scan>{{"silicium", "silicium_104x40x40_u8.nrrd", 128}};
    const int runs = context.pick(3, 7);
    for (const OpenScan& scan : opened(context, scans))
        for (const double filter : {0.0, extractor::ExtractionSettings().filterStrength})
            for (const std::size_t threads : {1U, 2U}) {
                if (context.isStopped())
                    return result;
                context.say(scan.name + ", " + std::to_string(threads) + " threads");
                const hierarchy::View view = scan.view();
                const auto jobs = std::shared_ptr<core::Jobs>(
                    core::makeJobs(core::JobsBackend::automatic, threads));
                surface::Surface surface(
                    scan.volume.field, scan.domain, optionsFor(scan, scan.isovalue, filter), jobs);
                const auto fieldValue = [&](double value) {
                    return volume::fieldIsovalue(scan.volume, value);
                };
                Cells cells;
                show(surface.settle(view), cells);
                const std::string where = scan.name + (filter > 0 ? ", filtered" : ", unfiltered") +
                                          ", " + std::to_string(threads) + " threads";
                // there by other units each time, and back to what is kept
                for (const bool kept : {false, true}) {
                    std::vector<double> seconds;
                    double processor = std::numeric_limits<double>::infinity();
                    double longest = 0;
                    std::size_t before = 0;
                    std::size_t after = 0;
                    Change last;
                    double to = 0;
                    for (int run = 0; run < runs; ++run) {
                        if (context.isStopped())
                            return result;
                        to = kept && run % 2 == 0 ? scan.isovalue
                                                  : scan.isovalue + 1 + (kept ? 0 : run);
                        rest(surface, view, cells);
                        before = surface.stats().triangles;
                        last = changed(surface, view, fieldValue(to), cells);
                        after = surface.stats().triangles;
                        seconds.push_back(last.seconds);
                        processor = std::min(processor, last.processor);
                        longest = std::max(longest, last.longest);
                    }
                    table.add(
                        {scan.name,
                         filter,
                         count(threads),
                         std::string(kept ? "kept" : "new"),
                         scan.isovalue,
                         to,
                         count(before),
                         count(after),
                         1e3 * *std::ranges::min_element(seconds),
                         1e3 * median(seconds),
                         1e3 * processor,
                         1e3 * longest,
                         count(last.retested),
                         count(last.empty),
                         count(last.extracted),
                         count(last.cached),
                         count(seconds.size())});
                    const extractor::CellExtractor alone(
                        scan.volume.field, scan.domain, scan.settings(to, filter));
                    std::size_t wrong = 0;
                    for (const auto& [id, mesh] : cells) {
                        const auto own = alone.extract(hierarchy::tetrahedronOf(id));
                        wrong += own && isSame(*own, *mesh) ? 0U : 1U;
                    }
                    result.check(
                        where + ": each cell is as if it were extracted alone",
                        wrong == 0 && !cells.empty(),
                        std::to_string(wrong) + " of " + std::to_string(cells.size()) + " differ");
                    show(surface.settle(view), cells);
                    Cells fresh;
                    surface::Surface other(
                        scan.volume.field, scan.domain, optionsFor(scan, to, filter), jobs);
                    show(other.settle(view), fresh);
                    result.check(
                        where + ": it ends as a surface that never had another isovalue",
                        areSame(cells, fresh),
                        std::to_string(cells.size()) + " and " + std::to_string(fresh.size()) +
                            " cells");
                }
            }
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench

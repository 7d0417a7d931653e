// How fast whole volumes and single cells become triangles, against VTK's flying edges in the same
// run.

#include "FlyingEdges.h"
#include "Scans.h"
#include "Suites.h"
#include "isofront/bench/Timing.h"
#include "isofront/bench/Topology.h"

#include <isofront/extractor/CellExtractor.h>
#include <isofront/fields/Noise.h>
#include <isofront/hierarchy/Diamond.h>
#include <isofront/surface/MeshExtraction.h>

#include <hwy/targets.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isofront::bench {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A number out of /proc/self/status [bytes]; NaN where there is none.
double statusBytes(const std::string& entry)
{
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with(entry + ":"))
            return 1024 * std::strtod(line.c_str() + entry.size() + 1, nullptr);
    return kUnknown;
}

struct Extracted {
    Timing timing;
    surface::ExtractedMesh mesh;
    double extraMebibytes = kUnknown; ///< the most held beyond input and output
};

/// Of two timings of the same work, what each of its numbers was at best.
Timing better(const Timing& a, const Timing& b)
{
    if (a.runs == 0)
        return b;
    Timing best = a;
    best.least = std::min(a.least, b.least);
    best.wall = std::min(a.wall, b.wall);
    best.runs += b.runs;
    return best;
}

double outputBytes(const surface::TriangleMesh& mesh)
{
    return static_cast<double>(
        mesh.positions.size() * sizeof(glm::dvec3) + mesh.normals.size() * sizeof(glm::vec3) +
        mesh.indices.size() * sizeof(std::uint32_t));
}

/// @param between  called before each timed run: a peer, so that both see the same machine
Extracted extracted(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    const surface::MeshExtractionOptions& options,
    std::size_t threads,
    std::size_t runs,
    const std::function<void()>& between)
{
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, threads);
    Extracted result;
    const auto work = [&] {
        result.mesh = {};
        auto mesh = surface::extractMesh(extractor, *jobs, options);
        if (mesh)
            result.mesh = std::move(*mesh);
    };
    // what earlier work has left with the allocator goes back to the system, and the system's mark
    // of the most memory held is set back
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;
    const double before = statusBytes("VmRSS");
    work();
    result.extraMebibytes =
        (statusBytes("VmHWM") - before - outputBytes(result.mesh.mesh)) / (1 << 20U);
    for (std::size_t run = 0; run < runs; ++run) {
        between();
        result.mesh.mesh = {};
        result.timing = better(result.timing, timed(work, 1));
    }
    return result;
}

std::optional<FlyingEdgesResult>
best(const std::optional<FlyingEdgesResult>& a, const std::optional<FlyingEdgesResult>& b)
{
    if (!a || !b)
        return a ? a : b;
    return FlyingEdgesResult{better(a->timing, b->timing), a->triangles};
}

/// A view in large cells, whose many inner vertices are removed up to a tenth of a lattice step,
/// with the least error in pixels that leaves no more triangles than so many.
std::optional<Extracted> decimated(
    const OpenScan& scan,
    double filter,
    std::size_t maxTriangles,
    surface::MeshExtractionOptions options,
    std::size_t threads,
    std::size_t runs)
{
    extractor::ExtractionSettings settings = scan.settings(scan.isovalue, filter);
    // four times the lattice has its step six levels earlier
    options.detail.level = std::max(0, options.detail.level - 6);
    settings.latticeSize *= 4;
    settings.simplifyError = 0.1;
    const auto extractor = extractorFor(scan, settings);
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, threads);
    options.maxTriangles = maxTriangles;
    const auto found = surface::extractMesh(extractor, *jobs, options);
    if (!found)
        return std::nullopt;
    options.maxTriangles = 0; // finding the error is not what is timed
    options.detail = found->detail;
    return extracted(extractor, options, threads, runs, [] {});
}

std::vector<Column> speedColumns()
{
    return {
        {"volume", "", "what is meshed"},
        {"isovalue", "", "at which value"},
        {"method", "", "cells are ours"},
        {"threads", "", "at work"},
        {"triangles", "", "triangles"},
        {"cpu", "ms", "least processor time, all threads together"},
        {"wall", "ms", "least time by the clock"},
        {"each", "ns", "processor time for each triangle"},
        {"ratio", "", "to flying edges on as many threads, for each triangle"},
        {"speedup", "", "by the clock, over one thread"},
        {"extra", "MiB", "most memory beyond input and output"},
        {"runs", "", "timed"}};
}

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 20> text{};
    (void)std::snprintf(
        text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

} // namespace

SuiteResult runExtract(const Context& context)
{
    SuiteResult result;
    Table table{
        "extract", "Whole volumes at their own spacing, with normals", speedColumns(), {}, {}};
    const std::vector<Scan> scans =
        context.isFull()
            ? std::vector<
                  Scan>{{"engine", "engine_256x256x128_u8.nrrd", 110}, {"brain", "ch2better_301x370x316_u8.nii.gz", 60}}
            : std::vector<Scan>{{"silicium", "silicium_104x40x40_u8.nrrd", 128}};
    const auto runs = context.pick<std::size_t>(3, 7);
    for (const OpenScan& scan : opened(context, scans)) {
        surface::MeshExtractionOptions options;
        options.detail.level = scan.nativeLevel;
        std::string checksum;
        std::array<double, 3> ours{};
        std::array<double, 3> theirs{};
        for (const std::size_t threads : {1U, 2U}) {
            if (context.isStopped())
                return result;
            context.say(scan.name + ", " + std::to_string(threads) + " threads");
            FlyingEdges flyingEdges(scan.volume);
            std::optional<FlyingEdgesResult> peer;
            const Extracted own = extracted(
                extractorFor(scan, scan.settings(scan.isovalue, 0)), options, threads, runs, [&] {
                    peer = best(peer, flyingEdges.run(scan.isovalue, threads));
                });
            const auto triangles = own.mesh.mesh.indices.size() / 3;
            const double each = own.timing.least / static_cast<double>(triangles);
            double peerEach = kUnknown;
            if (peer) {
                peerEach = peer->timing.least / static_cast<double>(peer->triangles);
                theirs[threads] = peer->timing.wall;
                table.add(
                    {scan.name,
                     scan.isovalue,
                     "flying edges",
                     count(threads),
                     count(peer->triangles),
                     1e3 * peer->timing.least,
                     1e3 * peer->timing.wall,
                     1e9 * peerEach,
                     1.0,
                     theirs[1] / theirs[threads],
                     kUnknown,
                     count(peer->timing.runs)});
            }
            ours[threads] = own.timing.wall;
            table.add(
                {scan.name,
                 scan.isovalue,
                 "cells",
                 count(threads),
                 count(triangles),
                 1e3 * own.timing.least,
                 1e3 * own.timing.wall,
                 1e9 * each,
                 each / peerEach,
                 ours[1] / ours[threads],
                 own.extraMebibytes,
                 count(own.timing.runs)});
            const std::string sum = hexadecimal(checksumOf(own.mesh.mesh));
            if (threads > 1)
                result.check(
                    scan.name + " is the same mesh on one thread and on two",
                    sum == checksum,
                    checksum + " and " + sum);
            checksum = sum;
            result.check(scan.name + " has triangles", triangles > 0, std::to_string(triangles));
        }
    }
    result.tables.push_back(std::move(table));

    Table cells{
        "cell",
        "One cell of six-octave noise, n = 16, by instruction set",
        {{"set", "", "instruction set"},
         {"cpu", "ms", "least time of a cell, one thread"},
         {"sample", "ms", "of it: placing and sampling"},
         {"contour", "ms", "of it: finding triangles"},
         {"normals", "ms", "of it: normals"},
         {"samples", "", "of the field"},
         {"triangles", "", "triangles"},
         {"runs", "", "timed"}},
        {},
        {}};
    fields::NoiseSettings noise;
    noise.wavelength = 0.5;
    extractor::ExtractionSettings settings;
    settings.latticeSize = 16;
    settings.filterStrength = 0;
    settings.skipEmptyCells = false;
    const extractor::CellExtractor extractor(fields::fractalNoise(noise), {}, settings);
    const hierarchy::Tetrahedron cell = hierarchy::rootTetrahedra()[0];
    std::optional<std::vector<extractor::CellVertex>> first;
    for (const auto target : hwy::SupportedAndGeneratedTargets()) {
        if (context.isStopped())
            return result;
        context.say(std::string("a cell with ") + hwy::TargetName(target));
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(target);
        extractor::CellMesh mesh;
        extractor::CellTrace least;
        least.sampleSeconds = least.contourSeconds = least.normalSeconds = 1;
        const Timing timing = timed(
            [&] {
                extractor::CellTrace trace;
                extractor.extractInto(cell, mesh, &trace);
                least.sampleSeconds = std::min(least.sampleSeconds, trace.sampleSeconds);
                least.contourSeconds = std::min(least.contourSeconds, trace.contourSeconds);
                least.normalSeconds = std::min(least.normalSeconds, trace.normalSeconds);
            },
            context.pick<std::size_t>(50, 1000),
            1);
        cells.add(
            {std::string(hwy::TargetName(target)),
             1e3 * timing.least,
             1e3 * least.sampleSeconds,
             1e3 * least.contourSeconds,
             1e3 * least.normalSeconds,
             count(mesh.stats.samples),
             count(mesh.triangleCount()),
             count(timing.runs)});
        if (!first)
            first = mesh.vertices;
        result.check(
            std::string("the cell has the same vertices with ") + hwy::TargetName(target),
            mesh.vertices == *first && !mesh.vertices.empty(),
            std::to_string(mesh.vertices.size()) + " vertices");
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    result.tables.push_back(std::move(cells));
    return result;
}

SuiteResult runView(const Context& context)
{
    SuiteResult result;
    std::vector<Column> columns = speedColumns();
    columns.insert(columns.begin() + 3, {"filter", "", "strength of the low-pass filter"});
    columns.insert(columns.begin() + 4, {"pixels", "px", "error of the mesh before decimation"});
    Table table{
        "view", "What one view needs, to one pixel at 1280 x 720, and the whole", columns, {}, {}};
    const std::vector<Scan> scans =
        context.isFull()
            ? std::vector<
                  Scan>{{"engine", "engine_256x256x128_u8.nrrd", 110}, {"cranium", "cranium_ct_256x256x108_i16.nrrd", 300}, {"bonsai", "bonsai_256x256x256_u8.nrrd", 30}}
            : std::vector<Scan>{{"silicium", "silicium_104x40x40_u8.nrrd", 128}};
    const auto runs = context.pick<std::size_t>(3, 7);
    for (const OpenScan& scan : opened(context, scans)) {
        surface::MeshExtractionOptions options;
        options.detail.kind = surface::Detail::Kind::view;
        options.detail.level = scan.nativeLevel + 6;
        options.detail.pixelError = 1;
        options.detail.view = scan.view();
        for (const std::size_t threads : {1U, 2U}) {
            if (context.isStopped())
                return result;
            context.say(scan.name + ", " + std::to_string(threads) + " threads");
            FlyingEdges flyingEdges(scan.volume);
            for (const double filter : {0.0, extractor::ExtractionSettings().filterStrength}) {
                std::optional<FlyingEdgesResult> peer;
                const Extracted own = extracted(
                    extractorFor(scan, scan.settings(scan.isovalue, filter)),
                    options,
                    threads,
                    runs,
                    [&] { peer = best(peer, flyingEdges.run(scan.isovalue, threads)); });
                if (peer)
                    table.add(
                        {scan.name,
                         scan.isovalue,
                         "flying edges: all of it",
                         kUnknown,
                         kUnknown,
                         count(threads),
                         count(peer->triangles),
                         1e3 * peer->timing.least,
                         1e3 * peer->timing.wall,
                         1e9 * peer->timing.least / static_cast<double>(peer->triangles),
                         1.0,
                         kUnknown,
                         kUnknown,
                         count(peer->timing.runs)});
                const auto triangles = own.mesh.mesh.indices.size() / 3;
                table.add(
                    {scan.name,
                     scan.isovalue,
                     "cells: for the view",
                     filter,
                     options.detail.pixelError,
                     count(threads),
                     count(triangles),
                     1e3 * own.timing.least,
                     1e3 * own.timing.wall,
                     1e9 * own.timing.least / static_cast<double>(triangles),
                     peer ? own.timing.least / peer->timing.least : kUnknown,
                     kUnknown,
                     own.extraMebibytes,
                     count(own.timing.runs)});
                result.check(
                    scan.name + " has triangles in view", triangles > 0, std::to_string(triangles));

                const std::size_t tenth = (peer ? peer->triangles : triangles) / 10;
                const auto fewer = decimated(scan, filter, tenth, options, threads, runs);
                if (!fewer)
                    continue;
                const auto left = fewer->mesh.mesh.indices.size() / 3;
                table.add(
                    {scan.name,
                     scan.isovalue,
                     "cells: decimated to a tenth",
                     filter,
                     fewer->mesh.detail.pixelError,
                     count(threads),
                     count(left),
                     1e3 * fewer->timing.least,
                     1e3 * fewer->timing.wall,
                     1e9 * fewer->timing.least / static_cast<double>(left),
                     peer ? fewer->timing.least / peer->timing.least : kUnknown,
                     kUnknown,
                     fewer->extraMebibytes,
                     count(fewer->timing.runs)});
                result.check(
                    scan.name + " decimated has at most a tenth of the triangles",
                    left > 0 && left <= tenth,
                    std::to_string(left) + " of at most " + std::to_string(tenth));
            }
        }
    }
    table.columns[table.column("ratio")].meaning = "to flying edges on as many threads, whole time";
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench

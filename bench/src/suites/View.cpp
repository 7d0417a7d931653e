// After Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with View-Dependent Level of
// Detail and Applications", section 3.1 and Fig. 13: detail for a viewer, and how it grows with
// the domain.

#include "Subjects.h"
#include "Suites.h"

#include <isofront/fields/Terrain.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/surface/Surface.h>
#include <isofront/surface/SurfaceCriterion.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace isofront::bench {

namespace {

struct Scene {
    std::shared_ptr<const fields::Field> field;
    hierarchy::Domain domain;
    hierarchy::View view;
};

/// The canyon as `fly` shows it first.
Scene canyonScene(int width, int height)
{
    const auto preset = fields::terrainPreset("canyon");
    Scene scene;
    scene.field = fields::terrain(*preset, 7, 1);
    scene.domain = {preset->box.low, preset->box.size().x};
    const auto over = [&](const glm::dvec2& at) {
        return glm::dvec3(
            at, fields::surfaceHeight(*scene.field, preset->box, at.x, at.y) + preset->clearance);
    };
    scene.view.eye = over(preset->start);
    scene.view.forward = over(preset->lookAt) - scene.view.eye;
    scene.view.width = width;
    scene.view.height = height;
    return scene;
}

surface::ExtractedMesh meshFor(
    const Scene& scene,
    int latticeSize,
    double filterStrength,
    double pixelError,
    core::Jobs& jobs,
    Timing* timing)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = latticeSize;
    settings.filterStrength = filterStrength;
    constexpr int kFinest = 45; // below a millimetre at 16 km
    settings.cornerRadius = 2 * hierarchy::axisStep(kFinest, latticeSize) * scene.domain.edge;
    surface::MeshExtractionOptions options;
    options.detail.kind = surface::Detail::Kind::view;
    options.detail.view = scene.view;
    options.detail.pixelError = pixelError;
    options.detail.level = kFinest;
    const auto extractor =
        std::make_shared<const extractor::CellExtractor>(scene.field, scene.domain, settings);
    surface::ExtractedMesh result;
    const Timing taken = timed(
        [&] {
            if (auto mesh = surface::extractMesh(extractor, jobs, options))
                result = std::move(*mesh);
        },
        1);
    if (timing != nullptr)
        *timing = taken;
    return result;
}

} // namespace

SuiteResult runPixelError(const Context& context)
{
    Table table{
        "pixels",
        "The error that is asked for, and that which is seen",
        {{"filter", "", "strength of the filter"},
         {"lattice", "", "n"},
         {"series", "", "both"},
         {"asked", "px", "pixel error asked for"},
         {"seen_rms", "px", "error that is seen, root mean square, the larger of both ways"},
         {"rms", "px", "mesh to surface, root mean square"},
         {"seen_p99", "px", "mesh to surface, 99 % below"},
         {"seen_max", "px", "mesh to surface, greatest"},
         {"back_p99", "px", "surface to mesh, 99 % below"},
         {"triangles", "", "triangles, in all directions"},
         {"cells", "", "of the front"},
         {"cpu", "ms", "processor time, all threads together"}},
        {},
        {{"seen",
          "Error seen over error asked for",
          "asked",
          "seen_rms",
          "series",
          "",
          "",
          true,
          true,
          {1}},
         {"triangles",
          "Triangles over error seen",
          "triangles",
          "seen_rms",
          "series",
          "",
          "",
          true,
          true,
          {-0.5}},
         {"cpu", "Time over error seen", "cpu", "seen_rms", "series", "", "", true, true, {}}}};
    SuiteResult result;
    const Scene scene = context.isFull() ? canyonScene(640, 360) : canyonScene(160, 90);
    const double reach = 400;
    const TrueSurface surface(scene.field, 0);
    context.say("the reference");
    const core::Box everywhere = scene.domain.fieldBox();
    const std::size_t samples = context.pick<std::size_t>(4000, 20000);
    const double finePixels = 1.0;
    const surface::ExtractedMesh fine = meshFor(scene, 8, 0, finePixels, *context.jobs, nullptr);
    const DistanceMeasure measure(
        surface,
        seenOf(
            referenceOf(
                surface,
                fine.mesh,
                reach,
                everywhere,
                samples,
                *context.jobs,
                pixelDensity(scene.view)),
            fine.mesh,
            scene.view,
            finePixels / surface::kErrorPerStep,
            *context.jobs),
        everywhere,
        reach,
        samples,
        context.jobs);
    const std::vector<double> asked =
        context.pick<std::vector<double>>({2, 8}, {2, 3, 4, 6, 8, 16});
    for (const int n : context.pick<std::vector<int>>({8}, {8, 16}))
        for (const double filter : {0.0, 0.5, 1.0}) {
            double before = 0;
            for (const double pixels : asked) {
                if (context.isStopped())
                    return result;
                const std::string series =
                    "n = " + std::to_string(n) +
                    (filter > 0 ? ", filter " + textOf(filter) : ", unfiltered");
                context.say(series + ", " + textOf(pixels) + " px");
                Timing timing;
                const surface::ExtractedMesh mesh =
                    meshFor(scene, n, filter, pixels, *context.jobs, &timing);
                const SurfaceError error =
                    measure.of(mesh.mesh, scene.view, pixels / surface::kErrorPerStep);
                const double seen = std::max(error.toSurface.rms, error.toMesh.rms);
                // One stray point of a few thousand can rule a root mean square.
                const double nearlyAll = std::max(error.toSurface.p99, error.toMesh.p99);
                table.add(
                    {textOf(filter),
                     std::to_string(n),
                     series,
                     pixels,
                     seen,
                     error.toSurface.rms,
                     error.toSurface.p99,
                     error.toSurface.max,
                     error.toMesh.p99,
                     count(mesh.mesh.indices.size() / 3),
                     count(mesh.cells),
                     1e3 * timing.least});
                if (pixels == asked.back() && n == 8 && filter == 0)
                    result.check(
                        "asking for less shows more error, " + series,
                        nearlyAll > before,
                        textOf(before) + " to " + textOf(nearlyAll) + " px");
                if (pixels == asked.front())
                    before = nearlyAll;
            }
        }
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runGrowth(const Context& context)
{
    Table table{
        "growth",
        "The domain doubles, the detail at the viewer stays",
        {{"way", "", "with level of detail, or the finest everywhere"},
         {"edge", "km", "edge of the domain"},
         {"cells", "", "of the front"},
         {"shown", "", "cells with triangles"},
         {"triangles", "", "triangles"},
         {"mesh_memory", "MiB", "of the meshes"},
         {"front_memory", "MiB", "of the fronts"},
         {"cpu", "ms", "processor time, all threads together"}},
        {},
        {}};
    for (const auto& [column, title] :
         {std::pair{"triangles", "Triangles"}, std::pair{"mesh_memory", "Memory of meshes"}})
        table.plots.push_back(
            {column,
             std::string(title) + " over the size of the domain",
             "edge",
             column,
             "way",
             "",
             "",
             true,
             true,
             {}});
    constexpr double kLeast = 512; // [m]
    constexpr int kLattice = 8;
    // 512 m / (2 n 2^(level / 3)): 2 m for full, 4 m for quick
    const int leastLevel = context.pick(9, 12);
    const double pixelError = context.pick(8.0, 4.0);
    const int doublings = context.pick(3, 6);
    const int withoutDetail = context.pick(1, 2);
    const auto preset = fields::terrainPreset("canyon");
    const auto field = fields::terrain(*preset, 7, 1);
    hierarchy::View view;
    view.eye = glm::dvec3(
        preset->start,
        fields::surfaceHeight(*field, preset->box, preset->start.x, preset->start.y) + 100);
    SuiteResult result;
    std::vector<double> withDetail;
    for (int doubling = 0; doubling <= doublings; ++doubling) {
        if (context.isStopped())
            return result;
        const double edge = std::ldexp(kLeast, doubling);
        const int level = leastLevel + 3 * doubling;
        const hierarchy::Domain domain{view.eye - glm::dvec3(0.49 * edge), edge};
        context.say("edge " + textOf(edge) + " m");
        extractor::ExtractionSettings settings;
        settings.latticeSize = kLattice;
        settings.cornerRadius = 2 * hierarchy::axisStep(level, kLattice) * edge;
        surface::SurfaceOptions options;
        options.extraction = settings;
        options.pixelError = pixelError;
        options.maxLevel = level;
        surface::SurfaceStats stats;
        const Timing timing = timed(
            [&] {
                surface::Surface live(field, domain, options, context.jobs);
                (void)live.settle(view);
                stats = live.stats();
            },
            1);
        constexpr double kMebi = 1024 * 1024;
        table.add(
            {std::string("with level of detail"),
             edge / 1000,
             count(stats.frontCells),
             count(stats.shownCells),
             count(stats.triangles),
             static_cast<double>(stats.meshBytes) / kMebi,
             static_cast<double>(stats.hierarchyBytes) / kMebi,
             1e3 * timing.least});
        withDetail.push_back(static_cast<double>(stats.triangles));
    }
    for (int doubling = 0; doubling <= withoutDetail; ++doubling) {
        if (context.isStopped())
            return result;
        const double edge = std::ldexp(kLeast, doubling);
        const int level = leastLevel + 3 * doubling;
        context.say("without level of detail, edge " + textOf(edge) + " m");
        const Subject subject{
            "canyon", field, {view.eye - glm::dvec3(0.49 * edge), edge}, 0, false};
        const CellsMesh cells = cellsMesh(subject, settingsFor(subject, kLattice, level), level, 1);
        const auto& mesh = cells.extracted.mesh;
        table.add(
            {std::string("finest everywhere"),
             edge / 1000,
             count(cells.extracted.cells),
             count(cells.extracted.cells - cells.extracted.cellsSkipped),
             count(mesh.indices.size() / 3),
             static_cast<double>(mesh.positions.size() * 12 + mesh.indices.size() * 2) / 1048576,
             std::nan(""),
             1e3 * cells.timing.least});
    }
    // a doubling adds about as much each time, where the whole grows fourfold without level of
    // detail
    const std::size_t last = withDetail.size() - 1;
    result.check(
        "with level of detail a doubling of the domain adds less than half again",
        withDetail[last] < 1.5 * withDetail[last - 1],
        textOf(withDetail[last - 1]) + " to " + textOf(withDetail[last]) + " triangles");
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench

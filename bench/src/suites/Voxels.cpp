// How fast meshes become surface voxels, and what those take.

#include "../PeerModule.h"
#include "Subjects.h"
#include "Suites.h"
#include "isofront/bench/Timing.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/voxels/Voxelization.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

/// Adds up what chunks take, and keeps none.
class CountedChunks : public voxels::ChunkSink {
public:
    std::optional<core::Error> put(voxels::Chunk chunk) override
    {
        _bytes += chunk.bytes();
        return std::nullopt;
    }
    [[nodiscard]] std::size_t bytes() const { return _bytes; }

private:
    std::size_t _bytes = 0;
};

voxels::TriangleModel modelOf(const surface::TriangleMesh& mesh)
{
    voxels::TriangleModel model;
    model.positions.assign(mesh.positions.begin(), mesh.positions.end());
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
        model.triangles.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
    return model;
}

double areaOf(const voxels::TriangleModel& model)
{
    double area = 0;
    for (const auto& t : model.triangles) {
        const glm::dvec3& a = model.positions[t[0]];
        area += 0.5 * glm::length(glm::cross(model.positions[t[1]] - a, model.positions[t[2]] - a));
    }
    return area;
}

std::vector<std::pair<std::string, voxels::TriangleModel>> modelsFor(const Context& context)
{
    std::vector<std::pair<std::string, voxels::TriangleModel>> models;
    const int level = levelForShare(1.0 / context.pick(32, 64), 4);
    for (const Subject& subject : {torusSubject(), gyroidSubject()})
        models.emplace_back(
            subject.name,
            modelOf(cellsMesh(subject, settingsFor(subject, 4, level), level).extracted.mesh));
    if (!context.isFull())
        return models;
    for (const auto& folder : context.dataFolders) {
        const auto file = folder.parent_path() / "meshes" / "stanford_dragon_871k.ply.gz";
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored))
            continue;
        if (auto read = exchange::readModel(file))
            models.emplace_back("dragon", std::move(*read));
        break;
    }
    return models;
}

} // namespace

SuiteResult runVoxels(const Context& context)
{
    Table table{
        "voxels",
        "Meshes as surface voxels, on one thread",
        {{"model", "", ""},
         {"triangles", "", ""},
         {"resolution", "voxels", "along the longest edge"},
         {"method", "", "six-separating or all that are touched; or OpenVDB's distances"},
         {"voxels", "", "of the finest level"},
         {"cpu", "ms", "processor time of all of it"},
         {"triangle_rate", "M/s", "triangles over all of it"},
         {"raster_rate", "M/s", "triangles over the time that makes the finest level"},
         {"reduce_rate", "M/s", "voxels over the time that makes coarser levels of them"},
         {"size", "MiB", "all levels of detail; OpenVDB's tree"},
         {"bytes_per_voxel", "", "size over voxels of the finest level"}},
        {},
        {}};
    SuiteResult result;
    constexpr double kMega = 1e-6;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    const std::size_t runs = context.pick<std::size_t>(1, 5);
    const auto resolutions = context.pick<std::vector<std::uint32_t>>({100}, {512, 1024, 2048});
    for (const auto& [name, model] : modelsFor(context)) {
        const double area = areaOf(model);
        const double triangles = static_cast<double>(model.triangles.size()) * kMega;
        for (const std::uint32_t resolution : resolutions) {
            if (context.isStopped())
                return result;
            context.say(name + " at " + std::to_string(resolution));
            const auto add = [&](const std::string& method,
                                 std::uint64_t voxels,
                                 std::size_t bytes,
                                 const Timing& timing,
                                 double rasterRate,
                                 double reduceRate) {
                table.add(
                    {name,
                     count(model.triangles.size()),
                     count(resolution),
                     method,
                     count(voxels),
                     1e3 * timing.least,
                     triangles / std::max(timing.least, 1e-9),
                     rasterRate,
                     reduceRate,
                     static_cast<double>(bytes) / (1U << 20U),
                     static_cast<double>(bytes) /
                         static_cast<double>(std::max<std::uint64_t>(voxels, 1))});
            };
            voxels::VoxelLattice lattice;
            for (const auto separability :
                 {voxels::Separability::six, voxels::Separability::conservative}) {
                const bool isSix = separability == voxels::Separability::six;
                voxels::VoxelizationReport report;
                std::size_t bytes = 0;
                double raster = 1e9;
                double reduce = 1e9;
                const Timing timing = timed(
                    [&] {
                        CountedChunks sink;
                        const auto made =
                            voxels::voxelize(model, {resolution, separability}, sink, *jobs);
                        if (!made)
                            return;
                        report = *made;
                        bytes = sink.bytes();
                        raster = std::min(raster, report.rasterSeconds);
                        reduce = std::min(reduce, report.reduceSeconds);
                    },
                    runs,
                    10);
                // all but those of the coarsest chunk are reduced; it is the least part of them
                add(isSix ? "six-separating" : "all touched",
                    report.voxels,
                    bytes,
                    timing,
                    triangles / std::max(raster, 1e-9),
                    reduce > 0 ? static_cast<double>(report.allVoxels) * kMega / reduce : kNone);
                lattice = report.lattice;
                // a surface of area A separates by E max|n_i| A of its voxels' faces
                const double share = static_cast<double>(report.voxels) * lattice.edge *
                                     lattice.edge / std::max(area, 1e-300);
                if (isSix)
                    result.check(
                        name + " at " + std::to_string(resolution) +
                            " has as many voxels as its area needs, a share of 0.57 to 1",
                        share > 0.55 && share < 1.02,
                        std::to_string(share));
                else
                    result.check(
                        name + " at " + std::to_string(resolution) +
                            " touches more voxels than it needs",
                        share > 1 && report.voxels == report.touched,
                        std::to_string(share));
            }
            if (const auto mesher = volumeToMeshModule().voxelize; mesher != nullptr) {
                std::vector<std::array<double, 3>> positions;
                for (const glm::dvec3& p : model.positions) {
                    const glm::dvec3 place = (p - lattice.origin) / lattice.edge;
                    positions.push_back({place.x, place.y, place.z});
                }
                for (const bool isSigned : {false, true}) {
                    peers::PeerVoxels made;
                    const Timing timing = timed(
                        [&] { made = mesher(positions, model.triangles, isSigned); }, runs, 10);
                    add(isSigned ? "OpenVDB, signed" : "OpenVDB, unsigned",
                        made.voxels,
                        made.bytes,
                        timing,
                        kNone,
                        kNone);
                }
            }
        }
    }
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench

// How fast meshes become surface voxels, and what those take.

#include "../PeerModule.h"
#include "Models.h"
#include "Subjects.h"
#include "Suites.h"
#include "isofront/bench/Timing.h"

#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/Voxelization.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

constexpr double kMega = 1e-6;
constexpr double kMiB = 1024.0 * 1024.0;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

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

/// A mesh, and how finely it is measured.
struct Voxelised {
    std::string name;
    voxels::TriangleModel model;
    std::vector<std::uint32_t> resolutions;
};

/// What is voxelised. Together they take minutes at most: the gyroid, which is nothing but surface,
/// is left at a resolution that the others go beyond.
std::vector<Voxelised> subjectsFor(const Context& context)
{
    std::vector<Voxelised> subjects;
    const int level = levelForShare(1.0 / context.pick(16, 64), 4);
    const auto add = [&](const Subject& subject, std::vector<std::uint32_t> resolutions) {
        subjects.push_back(
            {subject.name,
             modelOf(cellsMesh(subject, settingsFor(subject, 4, level), level).extracted.mesh),
             std::move(resolutions)});
    };
    if (!context.isFull()) {
        add(torusSubject(), {64});
        return subjects;
    }
    add(torusSubject(), {512, 2048});
    add(gyroidSubject(), {512});
    if (auto dragon = modelFile(context, kDragon))
        subjects.push_back({"dragon", std::move(*dragon), {512, 1024, 2048}});
    return subjects;
}

/// What one method made of it.
struct Row {
    std::string method;
    std::uint64_t voxels = 0;
    std::size_t bytes = 0;
    Timing timing{};
    double rasterRate = kNone;
    double reduceRate = kNone;
};

/// One model at one resolution, by our methods and OpenVDB's.
class Measurement {
public:
    Measurement(
        const Context& context,
        const Voxelised& subject,
        std::uint32_t resolution,
        SuiteResult& result,
        Table& table)
        : _context(context), _subject(subject), _resolution(resolution), _result(result),
          _table(table)
    {
    }

    void ours(voxels::Separability separability)
    {
        const bool isSix = separability == voxels::Separability::six;
        Row row{.method = isSix ? "six-separating" : "all touched"};
        const Cancellation cancellation(_context);
        const auto progress = tenthsOf(_context, nameOf(row.method));
        voxels::VoxelizationReport report;
        double raster = 1e9;
        double reduce = 1e9;
        row.timing = timed(
            [&] {
                CountedChunks sink;
                const auto made = voxels::voxelize(
                    _subject.model,
                    {_resolution, separability},
                    sink,
                    *_alone,
                    cancellation.flag(),
                    progress);
                if (!made)
                    return;
                report = *made;
                row.bytes = sink.bytes();
                raster = std::min(raster, report.rasterSeconds);
                reduce = std::min(reduce, report.reduceSeconds);
            },
            kRuns,
            kSeconds);
        if (_context.isStopped())
            return;
        row.voxels = report.voxels;
        row.rasterRate = megatriangles() / std::max(raster, 1e-9);
        // all but those of the coarsest chunk are reduced; it is the least part of them
        if (reduce > 0)
            row.reduceRate = static_cast<double>(report.allVoxels) * kMega / reduce;
        add(row);
        _lattice = report.lattice;
        // a surface of area A separates by E max|n_i| A of its voxels' faces
        const double share = static_cast<double>(report.voxels) * _lattice.edge * _lattice.edge /
                             std::max(areaOf(_subject.model), 1e-300);
        const std::string where = _subject.name + " at " + std::to_string(_resolution);
        if (isSix)
            _result.check(
                where + " has as many voxels as its area needs, a share of 0.57 to 1",
                share > 0.55 && share < 1.02,
                std::to_string(share));
        else
            _result.check(
                where + " touches more voxels than it needs",
                share > 1 && report.voxels == report.touched,
                std::to_string(share));
    }

    /// After ours, whose lattice it takes.
    void openVdb(bool isSigned)
    {
        const auto mesher = volumeToMeshModule().voxelize;
        if (mesher == nullptr || _context.isStopped())
            return;
        Row row{.method = isSigned ? "OpenVDB, signed" : "OpenVDB, unsigned"};
        _context.say(nameOf(row.method));
        std::vector<std::array<double, 3>> positions;
        for (const glm::dvec3& p : _subject.model.positions) {
            const glm::dvec3 place = (p - _lattice.origin) / _lattice.edge;
            positions.push_back({place.x, place.y, place.z});
        }
        peers::PeerVoxels made;
        row.timing = timed(
            [&] { made = mesher(positions, _subject.model.triangles, isSigned); }, kRuns, kSeconds);
        row.voxels = made.voxels;
        row.bytes = made.bytes;
        add(row);
    }

private:
    static constexpr std::size_t kRuns = 5;
    static constexpr double kSeconds = 5; ///< after which nothing is run again

    [[nodiscard]] std::string nameOf(const std::string& method) const
    {
        return _subject.name + " at " + std::to_string(_resolution) + ", " + method;
    }
    [[nodiscard]] double megatriangles() const
    {
        return static_cast<double>(_subject.model.triangles.size()) * kMega;
    }
    void add(const Row& row)
    {
        const auto bytes = static_cast<double>(row.bytes);
        _table.add(
            {_subject.name,
             count(_subject.model.triangles.size()),
             count(_resolution),
             row.method,
             count(row.voxels),
             1e3 * row.timing.least,
             megatriangles() / std::max(row.timing.least, 1e-9),
             row.rasterRate,
             row.reduceRate,
             bytes / kMiB,
             bytes / static_cast<double>(std::max<std::uint64_t>(row.voxels, 1))});
    }

    const Context& _context;
    const Voxelised& _subject;
    std::uint32_t _resolution;
    SuiteResult& _result;
    Table& _table;
    std::shared_ptr<core::Jobs> _alone = core::makeJobs(core::JobsBackend::inlined);
    voxels::VoxelLattice _lattice;
};

/// A folder that goes when it is no longer needed.
class ScratchFolder {
public:
    ScratchFolder()
    {
        std::error_code ignored;
        std::string pattern =
            (std::filesystem::temp_directory_path(ignored) / "isofront-bench-XXXXXX").string();
        if (::mkdtemp(pattern.data()) != nullptr)
            _path = pattern;
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder()
    {
        std::error_code ignored;
        if (!_path.empty())
            std::filesystem::remove_all(_path, ignored);
    }
    [[nodiscard]] const std::filesystem::path& path() const { return _path; }

private:
    std::filesystem::path _path;
};

/// A model on disk.
struct Stored {
    voxels::VoxelizationReport report;
    std::uint64_t bytes = 0; ///< of the file
    double seconds = 0;      ///< processor time of all of it
};

core::Result<Stored> storedModel(
    const Context& context,
    const std::string& what,
    const voxels::TriangleModel& model,
    std::uint32_t resolution)
{
    const ScratchFolder folder;
    const auto path = folder.path() / "model.voxels";
    auto store = voxels::createStore(path);
    if (!store)
        return tl::unexpected(store.error());
    const Cancellation cancellation(context);
    const auto alone = core::makeJobs(core::JobsBackend::inlined);
    core::Result<voxels::VoxelizationReport> made;
    std::optional<core::Error> error;
    const Timing timing = timed(
        [&] {
            made = voxels::voxelize(
                model,
                {.resolution = resolution},
                **store,
                *alone,
                cancellation.flag(),
                tenthsOf(context, what));
            if (made)
                error = (*store)->finish({.name = what, .lattice = made->lattice});
        },
        1);
    if (!made)
        return tl::unexpected(made.error());
    if (error)
        return tl::unexpected(*error);
    std::error_code ignored;
    return Stored{*made, std::filesystem::file_size(path, ignored), timing.least};
}

/// What models take on disk as triangles and as voxels, as table 1 of Chajdas et al. has it, and
/// the times of their section 5.
Table sizeTable()
{
    return {
        "sizes",
        "What models take on disk, as triangles and as voxels of all levels",
        {{"model", "", ""},
         {"attributes", "", "of the triangles' corners; voxels have normals in any case"},
         {"triangles", "", ""},
         {"resolution", "voxels", "along the longest edge"},
         {"voxels", "", "of the finest level"},
         {"geometry", "MiB", "32-bit positions, attributes and corners"},
         {"size", "MiB", "of the file of voxels"},
         {"share", "%", "size over geometry"},
         {"bytes_per_voxel", "", "size over voxels of the finest level"},
         {"chain", "", "voxels of all levels over those of the finest"},
         {"finest", "s", "processor time of making the finest level, one thread"},
         {"coarser", "s", "the same of all others"},
         {"all", "s", "the same of all of it, with the file"}},
        {},
        {}};
}

void measureSizes(const Context& context, SuiteResult& result)
{
    Table table = sizeTable();
    std::vector<std::pair<std::string, voxels::TriangleModel>> models;
    if (context.isFull())
        for (const auto& [name, file] : {
                 std::pair{"dragon", kDragon},
                 std::pair{"armadillo", "armadillo_86k.ply.gz"},
                 std::pair{"bunny", "bunny_closed_75k.ply.gz"},
             })
            if (auto model = modelFile(context, file))
                models.emplace_back(name, std::move(*model));
    if (models.empty())
        models.emplace_back("hills", hills(context.pick(40U, 300U)));
    for (auto& [name, model] : models)
        for (const bool isColoured : {false, true}) {
            if (context.isStopped())
                return;
            model.colours.assign(isColoured ? model.positions.size() : 0, 0xff4080c0U);
            // as many voxels for a triangle as the paper's models have
            const double triangles = static_cast<double>(model.triangles.size());
            constexpr double kVoxelsPerTriangle = 0.5;
            const core::Box box = boundsOf(model);
            const double longest = std::max({box.size().x, box.size().y, box.size().z});
            constexpr double kVoxelsPerArea = 0.75; // of any direction, the mean
            const auto resolution = static_cast<std::uint32_t>(std::clamp(
                std::sqrt(kVoxelsPerTriangle * triangles / (kVoxelsPerArea * areaOf(model))) *
                    longest,
                16.0,
                4096.0));
            const auto made = storedModel(
                context,
                name + (isColoured ? " with colours" : "") + " at " + std::to_string(resolution),
                model,
                resolution);
            if (!made) {
                if (!context.isStopped())
                    result.check(name + " becomes a file of voxels", false, made.error().message);
                return;
            }
            // positions, perhaps normals and colours; three corners
            const double geometry =
                static_cast<double>(model.positions.size()) * (isColoured ? 12 + 12 + 4 : 12) +
                triangles * 12;
            const auto bytes = static_cast<double>(made->bytes);
            const auto finest = static_cast<double>(made->report.voxels);
            const double chain = static_cast<double>(made->report.allVoxels) / finest;
            table.add(
                {name,
                 std::string(isColoured ? "positions, normals, colours" : "positions"),
                 count(model.triangles.size()),
                 count(resolution),
                 count(made->report.voxels),
                 geometry / kMiB,
                 bytes / kMiB,
                 100 * bytes / geometry,
                 bytes / finest,
                 chain,
                 made->report.rasterSeconds,
                 made->report.reduceSeconds,
                 made->seconds});
            result.check(
                name + (isColoured ? " with colours" : "") +
                    " has 1.2 to 1.5 times as many voxels with all levels",
                made->report.lattice.levels == 1 || (chain > 1.2 && chain < 1.5),
                std::to_string(chain));
        }
    result.tables.push_back(std::move(table));
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
    for (const Voxelised& subject : subjectsFor(context))
        for (const std::uint32_t resolution : subject.resolutions) {
            if (context.isStopped())
                return result;
            Measurement measurement(context, subject, resolution, result, table);
            measurement.ours(voxels::Separability::six);
            measurement.ours(voxels::Separability::conservative);
            // distances take longer than voxels by far
            const bool isLarge = resolution > 512;
            if (isLarge && subject.name != "dragon")
                continue;
            measurement.openVdb(false);
            measurement.openVdb(true);
        }
    result.tables.push_back(std::move(table));
    measureSizes(context, result);
    return result;
}

} // namespace isofront::bench

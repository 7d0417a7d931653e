#include "LatticeExtent.h"
#include "Pool.h"
#include "Rasteriser.h"
#include "VoxelPipeline.h"

#include <isofront/voxels/Voxelization.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>

namespace isofront::voxels {

namespace {

/// For each chunk, the triangles whose box meets it.
struct Bins {
    std::vector<std::uint64_t> begin; ///< by chunk, and the end
    std::vector<std::uint32_t> triangles;
};

/// The triangles of a model, by chunk.
class TriangleSource final : public VoxelSource {
public:
    TriangleSource(
        const TriangleModel& model,
        const core::Box& bounds,
        const VoxelLattice& lattice,
        Separability separability)
        : _model(onLattice(model, lattice)), _separability(separability)
    {
        const glm::dvec3 size = bounds.size() / lattice.edge;
        for (std::size_t axis = 0; axis < 3; ++axis)
            _counts[axis] =
                static_cast<std::uint32_t>(std::floor(size[axis] + 0.75)) / kChunkEdge + 1;
    }

    [[nodiscard]] ChunkPlace counts() const override { return _counts; }
    [[nodiscard]] bool isColoured() const override { return _model.model.isColoured(); }
    [[nodiscard]] std::vector<Task> tasks() override
    {
        _bins = sorted();
        std::vector<Task> tasks;
        ChunkPlace place{};
        for (place[2] = 0; place[2] < _counts[2]; ++place[2])
            for (place[1] = 0; place[1] < _counts[1]; ++place[1])
                for (place[0] = 0; place[0] < _counts[0]; ++place[0])
                    if (const auto triangles = trianglesOf(place); !triangles.empty())
                        tasks.push_back({place, triangles.size()});
        return tasks;
    }
    void make(const ChunkPlace& place, VoxelList& list) override
    {
        std::uint64_t touched = 0;
        _rasterisers.with([&](Rasteriser& rasteriser) {
            rasteriser.run(_model, place, trianglesOf(place), _separability, list, touched);
        });
        _touched += touched;
    }
    /// Cubes that a triangle touches, of all chunks made.
    [[nodiscard]] std::uint64_t touched() const { return _touched; }

private:
    [[nodiscard]] std::size_t indexOf(const ChunkPlace& place) const
    {
        return place[0] + std::size_t{_counts[0]} * (place[1] + std::size_t{_counts[1]} * place[2]);
    }
    [[nodiscard]] std::span<const std::uint32_t> trianglesOf(const ChunkPlace& place) const
    {
        const std::size_t index = indexOf(place);
        return {
            _bins.triangles.data() + _bins.begin[index],
            _bins.triangles.data() + _bins.begin[index + 1]};
    }
    [[nodiscard]] Bins sorted() const
    {
        const auto forEachChunk = [&](const auto& body) {
            const auto& triangles = _model.model.triangles;
            for (std::uint32_t i = 0; i < triangles.size(); ++i) {
                const bool usable = std::ranges::all_of(triangles[i], [&](std::uint32_t corner) {
                    return corner < _model.points.size() &&
                           isFinite(_model.model.positions[corner]);
                });
                if (!usable)
                    continue;
                const VoxelRange range = voxelsOf(_model.triangle(i));
                ChunkPlace low{};
                ChunkPlace high{};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    low[axis] = static_cast<std::uint32_t>(
                        std::max<std::int64_t>(range.low[axis], 0) / kChunkEdge);
                    high[axis] = std::min(
                        static_cast<std::uint32_t>((range.high[axis] - 1) / kChunkEdge),
                        _counts[axis] - 1);
                }
                ChunkPlace place{};
                for (place[2] = low[2]; place[2] <= high[2]; ++place[2])
                    for (place[1] = low[1]; place[1] <= high[1]; ++place[1])
                        for (place[0] = low[0]; place[0] <= high[0]; ++place[0])
                            body(indexOf(place), i);
            }
        };
        Bins bins;
        bins.begin.assign(std::size_t{_counts[0]} * _counts[1] * _counts[2] + 1, 0);
        forEachChunk([&](std::size_t chunk, std::uint32_t) { ++bins.begin[chunk + 1]; });
        for (std::size_t i = 1; i < bins.begin.size(); ++i)
            bins.begin[i] += bins.begin[i - 1];
        bins.triangles.resize(bins.begin.back());
        std::vector<std::uint64_t> next(bins.begin.begin(), bins.begin.end() - 1);
        forEachChunk([&](std::size_t chunk, std::uint32_t triangle) {
            bins.triangles[next[chunk]++] = triangle;
        });
        return bins;
    }

    LatticeModel _model;
    Separability _separability;
    ChunkPlace _counts{};
    Bins _bins;
    Pool<Rasteriser> _rasterisers;
    std::atomic<std::uint64_t> _touched = 0;
};

} // namespace

std::uint32_t levelsFor(std::uint32_t resolution)
{
    const std::uint32_t chunks = (resolution + kChunkEdge - 1) / kChunkEdge;
    return 1 + static_cast<std::uint32_t>(std::bit_width(chunks - 1));
}

VoxelLattice latticeFor(const core::Box& bounds, std::uint32_t resolution)
{
    VoxelLattice lattice;
    lattice.resolution = resolution;
    const glm::dvec3 size = bounds.size();
    const double longest = std::max({size.x, size.y, size.z});
    lattice.edge = longest > 0 ? longest / (resolution - 0.5) : 1;
    lattice.origin = bounds.low - glm::dvec3(0.25 * lattice.edge);
    lattice.levels = levelsFor(resolution);
    return lattice;
}

core::Result<VoxelizationReport> voxelize(
    const TriangleModel& model,
    const VoxelizationSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled,
    const std::function<void(double)>& progress)
{
    if (settings.resolution < 1 || settings.resolution > kMaxResolution)
        return core::failure(
            core::ErrorCode::usage,
            "a resolution of " + std::to_string(settings.resolution) + " is not between 1 and " +
                std::to_string(kMaxResolution));
    VoxelizationReport report;
    report.model = inspect(model);
    if (report.model.bounds.isEmpty())
        return core::failure(
            core::ErrorCode::badData,
            model.triangles.empty()
                ? "the model has no triangles"
                : "none of the model's " + std::to_string(model.triangles.size()) +
                      " triangles has three finite corners");
    if (auto failed = checkColours(model))
        return tl::unexpected(*failed);
    report.lattice = latticeFor(report.model.bounds, settings.resolution);
    if (!canDivide(report.lattice, report.model.bounds))
        return core::failure(
            core::ErrorCode::badData,
            "the model's extent can't be divided into " + std::to_string(settings.resolution) +
                " voxels, as its coordinates are too large, too small or too close together; "
                "scale or move it");
    TriangleSource source(model, report.model.bounds, report.lattice, settings.separability);
    const auto made = runPipeline(
        source,
        {report.lattice.levels, settings.allFaces, settings.scratchFolder},
        sink,
        jobs,
        cancelled,
        progress);
    if (!made)
        return tl::unexpected(made.error());
    report.voxels = made->voxels;
    report.touched = source.touched();
    report.allVoxels = made->allVoxels;
    report.chunks = made->chunks;
    report.emptyRegions = made->emptyRegions;
    report.scratchBytes = made->scratchBytes;
    report.rasterSeconds = made->makeSeconds;
    report.reduceSeconds = made->reduceSeconds;
    return report;
}

} // namespace isofront::voxels

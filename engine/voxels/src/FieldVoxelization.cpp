#include "isofront/voxels/FieldVoxelization.h"

#include "FieldRasteriser.h"
#include "PlaceSort.h"
#include "Pool.h"
#include "VoxelPipeline.h"

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace isofront::voxels {

namespace {

/// Edge of the parts of a chunk that threads share [voxels].
constexpr std::int64_t kBrick = 64;
constexpr std::int64_t kBricks = kChunkEdge / kBrick;
constexpr std::size_t kBricksOfChunk = kBricks * kBricks * kBricks;

/// A field, by chunk.
class FieldSource final : public VoxelSource {
public:
    FieldSource(
        const fields::Field& field,
        const FieldVoxelizationSettings& settings,
        const VoxelLattice& lattice,
        core::Jobs& jobs,
        const std::atomic<bool>* cancelled)
        : _grid(field, settings, lattice), _settings{settings.separability, settings.closed},
          _jobs(jobs), _cancelled(cancelled)
    {
        for (std::size_t axis = 0; axis < 3; ++axis)
            _chunks[axis] =
                static_cast<std::uint32_t>((_grid.counts()[axis] + kChunkEdge - 1) / kChunkEdge);
    }

    [[nodiscard]] ChunkPlace counts() const override { return _chunks; }
    [[nodiscard]] bool isColoured() const override { return _grid.isColoured(); }
    [[nodiscard]] std::vector<Task> tasks() override
    {
        std::vector<Task> tasks;
        addTasks({0, 0, 0}, _chunks, tasks);
        return tasks;
    }

    void make(const ChunkPlace& place, VoxelList& list) override
    {
        std::array<std::int64_t, 3> chunk{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            chunk[axis] = static_cast<std::int64_t>(place[axis]) * kChunkEdge;
        std::array<VoxelList, kBricksOfChunk> parts;
        _jobs.parallelFor(kBricksOfChunk, [&](std::size_t i) {
            if (_cancelled != nullptr && _cancelled->load(std::memory_order_relaxed))
                return; // what calls will look, too
            const auto brick = static_cast<std::int64_t>(i);
            const std::array<std::int64_t, 3> at{
                brick % kBricks, brick / kBricks % kBricks, brick / (kBricks * kBricks)};
            VoxelRange range;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                range.low[axis] = at[axis] * kBrick;
                range.high[axis] = range.low[axis] + kBrick;
                if (chunk[axis] + range.low[axis] >= _grid.counts()[axis])
                    return;
            }
            FieldRasteriser::Counts counts;
            _rasterisers.with([&](FieldRasteriser& rasteriser) {
                rasteriser.run(_grid, chunk, range, _settings, parts[i], counts);
            });
            _samples += counts.samples;
            _sanitised += counts.sanitised;
        });
        std::vector<std::uint64_t> keys;
        std::vector<std::uint64_t> scratch;
        VoxelList all;
        for (const VoxelList& part : parts) {
            for (const WeightedVoxel& voxel : part.voxels)
                keys.push_back(std::uint64_t{voxel.order()} << 32U | keys.size());
            all.voxels.insert(all.voxels.end(), part.voxels.begin(), part.voxels.end());
            all.colours.insert(all.colours.end(), part.colours.begin(), part.colours.end());
            list.faces.insert(list.faces.end(), part.faces.begin(), part.faces.end());
        }
        sortByPlace(keys, scratch);
        for (const std::uint64_t key : keys) {
            list.voxels.push_back(all.voxels[key & 0xffffffffU]);
            if (!all.colours.empty())
                list.colours.push_back(all.colours[key & 0xffffffffU]);
        }
        std::ranges::sort(list.faces, {}, &WeightedFaces::voxel);
        for (WeightedFaces& faces : list.faces) // until now they named its order
            faces.voxel = static_cast<std::uint32_t>(
                std::ranges::lower_bound(list.voxels, faces.voxel, {}, &WeightedVoxel::order) -
                list.voxels.begin());
    }

    [[nodiscard]] std::uint64_t samples() const { return _samples; }
    [[nodiscard]] std::uint64_t sanitised() const { return _sanitised; }

private:
    /// Adds the chunks from `low` on, `high` not included, that the bounds don't prove empty.
    void addTasks(const ChunkPlace& low, const ChunkPlace& high, std::vector<Task>& tasks) const
    {
        HalfPlace first{};
        HalfPlace last{};
        std::size_t longest = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            // the middles, and half a voxel beyond for the corners
            first[axis] = 2 * static_cast<std::int64_t>(low[axis]) * kChunkEdge - 2;
            last[axis] = 2 * static_cast<std::int64_t>(high[axis]) * kChunkEdge + 2;
            if (high[axis] - low[axis] > high[longest] - low[longest])
                longest = axis;
        }
        const core::Interval values = _grid.bounds(first, last);
        if (_grid.hasNoneBetween(first, last) || values.high < _grid.isovalue() ||
            (values.low >= _grid.isovalue() && _grid.hasDataBetween(first, last)))
            return;
        if (high[longest] - low[longest] == 1) {
            tasks.push_back({low, 1});
            return;
        }
        ChunkPlace middle = high;
        middle[longest] = low[longest] + (high[longest] - low[longest]) / 2;
        addTasks(low, middle, tasks);
        ChunkPlace start = low;
        start[longest] = middle[longest];
        addTasks(start, high, tasks);
    }

    FieldGrid _grid;
    FieldRasteriser::Settings _settings;
    core::Jobs& _jobs;
    const std::atomic<bool>* _cancelled;
    ChunkPlace _chunks{};
    Pool<FieldRasteriser> _rasterisers;
    std::atomic<std::uint64_t> _samples = 0;
    std::atomic<std::uint64_t> _sanitised = 0;
};

/// What is wrong with settings; nothing if they make sense.
std::string objectionTo(const FieldVoxelizationSettings& settings)
{
    const core::Box& box = settings.box;
    const glm::dvec3 size = box.size();
    if (box.isEmpty() || !std::isfinite(size.x + size.y + size.z) ||
        !std::isfinite(box.low.x + box.low.y + box.low.z))
        return "the box to voxelise is empty, or not finite";
    if (!(settings.edge > 0) || !std::isfinite(settings.edge))
        return "the edge of a voxel must be above 0, and finite";
    const glm::dvec3 next = box.low + settings.edge;
    if (next.x == box.low.x || next.y == box.low.y || next.z == box.low.z)
        return "the edge of a voxel is too small for where the box lies: choose a larger one, or "
               "move the box";
    if (latticeOf(settings).resolution > kMaxResolution)
        return "more than " + std::to_string(kMaxResolution) +
               " voxels along the box: choose a larger edge";
    if (!std::isfinite(settings.isovalue))
        return "the isovalue is not finite";
    if (!(settings.filterStrength >= 0) || !std::isfinite(settings.filterStrength))
        return "the filter's strength must be 0 or more, and finite";
    const double determinant = glm::determinant(settings.worldFromField.linear);
    if (!(std::abs(determinant) > 0) || !std::isfinite(determinant))
        return "the map from the field to the world can't be inverted";
    return {};
}

} // namespace

VoxelLattice latticeOf(const FieldVoxelizationSettings& settings)
{
    VoxelLattice lattice;
    lattice.origin = settings.box.low;
    lattice.edge = settings.edge;
    const std::array<std::uint32_t, 3> counts = voxelCounts(settings);
    lattice.resolution = std::max({counts[0], counts[1], counts[2]});
    lattice.levels = levelsFor(lattice.resolution);
    return lattice;
}

core::Result<FieldVoxelizationReport> voxelizeField(
    const fields::Field& field,
    const FieldVoxelizationSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled,
    const std::function<void(double)>& progress)
{
    if (const std::string objection = objectionTo(settings); !objection.empty())
        return core::failure(core::ErrorCode::usage, objection);
    FieldVoxelizationReport report;
    report.lattice = latticeOf(settings);
    FieldSource source(field, settings, report.lattice, jobs, cancelled);
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
    report.allVoxels = made->allVoxels;
    report.chunks = made->chunks;
    report.emptyRegions = made->emptyRegions;
    report.scratchBytes = made->scratchBytes;
    report.samples = source.samples();
    report.sanitisedSamples = source.sanitised();
    return report;
}

} // namespace isofront::voxels

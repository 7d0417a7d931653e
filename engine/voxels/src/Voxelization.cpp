#include "EmptySpace.h"
#include "OutsideSpace.h"
#include "Rasteriser.h"
#include "Reduction.h"
#include "ScratchFile.h"

#include <isofront/voxels/Voxelization.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>

namespace isofront::voxels {

namespace {

using Place = std::array<std::uint32_t, 3>;

/// Levels of detail whose chunks are made together, by all threads: groups of 64 chunks.
constexpr std::uint32_t kGroupLevels = 2;
/// How much of the work is done with the last triangle.
constexpr double kRasterShare = 0.7;

/// One of its kind for each job that runs at once, made when needed and used again.
template <typename T>
class Pool {
public:
    /// Calls `body` with one that nobody else has.
    template <typename Body>
    void with(const Body& body)
    {
        std::unique_ptr<T> one;
        {
            const std::scoped_lock lock(_mutex);
            if (!_free.empty()) {
                one = std::move(_free.back());
                _free.pop_back();
            }
        }
        if (one == nullptr)
            one = std::make_unique<T>();
        body(*one);
        const std::scoped_lock lock(_mutex);
        _free.push_back(std::move(one));
    }

private:
    std::mutex _mutex;
    std::vector<std::unique_ptr<T>> _free;
};

/// The first failure of jobs that run at once.
class FirstError {
public:
    void set(core::Error error)
    {
        const std::scoped_lock lock(_mutex);
        if (!_error)
            _error = std::move(error);
        _failed = true;
    }
    [[nodiscard]] bool failed() const { return _failed; }
    [[nodiscard]] const std::optional<core::Error>& error() const { return _error; }

private:
    std::mutex _mutex;
    std::atomic<bool> _failed = false;
    std::optional<core::Error> _error;
};

/// For each chunk, the triangles whose box meets it.
struct Bins {
    std::vector<std::uint64_t> begin; ///< by chunk, and the end
    std::vector<std::uint32_t> triangles;
};

std::uint32_t colourOf(const WeightedVoxel& voxel)
{
    const float opacity = voxel.colour[3];
    const auto code = [&](float sum) {
        const double c = opacity > 0 ? std::clamp(static_cast<double>(sum / opacity), 0.0, 1.0) : 0;
        const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
        return static_cast<std::uint32_t>(std::lround(255 * s));
    };
    const double weight = std::max(static_cast<double>(voxel.area), 1e-12);
    const double part = std::clamp(static_cast<double>(opacity) / weight, 0.0, 1.0);
    return code(voxel.colour[0]) | code(voxel.colour[1]) << 8U | code(voxel.colour[2]) << 16U |
           static_cast<std::uint32_t>(std::lround(255 * part)) << 24U;
}

Chunk stored(const ChunkKey& key, std::span<const WeightedVoxel> voxels, bool coloured)
{
    Chunk chunk;
    chunk.key = key;
    chunk.voxels.reserve(voxels.size());
    for (const WeightedVoxel& voxel : voxels) {
        chunk.voxels.push_back(
            {voxel.place, packNormal({voxel.normal[0], voxel.normal[1], voxel.normal[2]})});
        if (coloured)
            chunk.colours.push_back(colourOf(voxel));
    }
    return chunk;
}

/// All passes over one model.
class Voxelizer {
public:
    Voxelizer(
        const TriangleModel& model,
        const VoxelizationSettings& settings,
        ChunkSink& sink,
        core::Jobs& jobs,
        const std::atomic<bool>* cancelled,
        const std::function<void(double)>& progress,
        ScratchFile scratch,
        VoxelizationReport report)
        : _settings(settings), _sink(sink), _jobs(jobs), _cancelled(cancelled), _progress(progress),
          _scratch(std::move(scratch)), _report(std::move(report)),
          _model(onLattice(model, _report.lattice)), _counts(chunkCounts()),
          _outside(_counts, _scratch)
    {
    }

    core::Result<VoxelizationReport> run()
    {
        const Bins bins = sorted();
        if (auto failed = rasterise(bins))
            return tl::unexpected(*failed);
        if (_settings.allFaces)
            _report.emptyRegions = 0;
        else if (auto failed = _outside.build(_chunks))
            return tl::unexpected(*failed);
        else
            _report.emptyRegions = _outside.closedParts();
        std::vector<WeightedVoxel> top;
        if (auto failed = finish({_report.lattice.levels - 1, 0, 0, 0}, top))
            return tl::unexpected(*failed);
        if (_progress)
            _progress(1);
        return _report;
    }

private:
    /// A chunk's triangles, and what a job needs to make its voxels.
    struct RasterSpace {
        Rasteriser rasteriser;
        EmptySpace empty;
    };
    struct MaskSpace {
        EmptySpace empty;
        ReductionScratch reduction;
    };
    /// A chunk of a group while the group is made.
    struct Made {
        ChunkKey key;
        std::vector<WeightedVoxel> voxels;
        Chunk chunk;
    };

    [[nodiscard]] Place chunkCounts() const
    {
        const glm::dvec3 size = _report.model.bounds.size() / _report.lattice.edge;
        Place counts{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            counts[axis] =
                static_cast<std::uint32_t>(std::floor(size[axis] + 0.75)) / kChunkEdge + 1;
        return counts;
    }
    [[nodiscard]] std::size_t indexOf(const Place& place) const
    {
        return place[0] + std::size_t{_counts[0]} * (place[1] + std::size_t{_counts[1]} * place[2]);
    }
    [[nodiscard]] bool isCancelled() const
    {
        return _cancelled != nullptr && _cancelled->load(std::memory_order_relaxed);
    }
    static core::Error interrupted() { return {core::ErrorCode::interrupted, "interrupted"}; }

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
                Place low{};
                Place high{};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    low[axis] = static_cast<std::uint32_t>(
                        std::max<std::int64_t>(range.low[axis], 0) / kChunkEdge);
                    high[axis] = std::min(
                        static_cast<std::uint32_t>((range.high[axis] - 1) / kChunkEdge),
                        _counts[axis] - 1);
                }
                Place place{};
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
    static bool isFinite(const glm::dvec3& p) { return std::isfinite(p.x + p.y + p.z); }

    std::optional<core::Error> rasterise(const Bins& bins)
    {
        std::vector<Place> places;
        Place place{};
        for (place[2] = 0; place[2] < _counts[2]; ++place[2])
            for (place[1] = 0; place[1] < _counts[1]; ++place[1])
                for (place[0] = 0; place[0] < _counts[0]; ++place[0])
                    if (bins.begin[indexOf(place)] < bins.begin[indexOf(place) + 1])
                        places.push_back(place);

        std::vector<ScratchChunk> chunks(places.size());
        std::vector<std::uint64_t> touched(places.size());
        Pool<RasterSpace> spaces;
        FirstError error;
        std::atomic<std::uint64_t> done = 0;
        std::mutex telling;
        _jobs.parallelFor(places.size(), [&](std::size_t i) {
            if (error.failed())
                return;
            if (isCancelled()) {
                error.set(interrupted());
                return;
            }
            const std::size_t index = indexOf(places[i]);
            const std::span<const std::uint32_t> triangles(
                bins.triangles.data() + bins.begin[index],
                bins.triangles.data() + bins.begin[index + 1]);
            spaces.with([&](RasterSpace& space) {
                const std::vector<WeightedVoxel> voxels = space.rasteriser.run(
                    _model, places[i], triangles, _settings.separability, touched[i]);
                auto kept = keep(places[i], voxels, space.empty);
                if (kept)
                    chunks[i] = *kept;
                else
                    error.set(kept.error());
            });
            const std::uint64_t sum = done += triangles.size();
            if (_progress) {
                const std::scoped_lock lock(telling);
                _progress(
                    kRasterShare * static_cast<double>(sum) /
                    static_cast<double>(bins.triangles.size()));
            }
        });
        if (error.failed())
            return error.error();
        for (std::size_t i = 0; i < chunks.size(); ++i) {
            _report.touched += touched[i];
            _report.voxels += chunks[i].voxels;
            if (chunks[i].voxels > 0)
                _chunks.push_back(chunks[i]);
        }
        // in the order of their places in the hierarchy, so that each of its parts is a range
        std::ranges::sort(_chunks, {}, [](const ScratchChunk& c) { return mortonOf(c.place); });
        return std::nullopt;
    }

    core::Result<ScratchChunk>
    keep(const Place& place, const std::vector<WeightedVoxel>& voxels, EmptySpace& empty)
    {
        ScratchChunk chunk;
        chunk.place = place;
        chunk.voxels = static_cast<std::uint32_t>(voxels.size());
        if (voxels.empty())
            return chunk;
        const auto at = _scratch.append(std::as_bytes(std::span(voxels)));
        if (!at)
            return tl::unexpected(at.error());
        chunk.voxelsAt = *at;
        if (_settings.allFaces)
            return chunk;
        empty.build(voxels);
        chunk.parts = empty.parts();
        for (std::size_t face = 0; face < kFaces; ++face) {
            const auto runs = empty.layer(static_cast<Face>(face));
            const auto layerAt = _scratch.append(std::as_bytes(std::span(runs)));
            if (!layerAt)
                return tl::unexpected(layerAt.error());
            chunk.layersAt[face] = *layerAt;
            chunk.layerRuns[face] = static_cast<std::uint32_t>(runs.size());
        }
        return chunk;
    }

    /// Bits of x, y and z in turn, x lowest.
    static std::uint64_t mortonOf(const Place& place)
    {
        std::uint64_t code = 0;
        for (unsigned bit = 0; bit < 20; ++bit)
            for (unsigned axis = 0; axis < 3; ++axis)
                code |= static_cast<std::uint64_t>(place[axis] >> bit & 1U) << (3 * bit + axis);
        return code;
    }
    /// The chunks of level 0 under one of any level.
    [[nodiscard]] std::span<const ScratchChunk> under(const ChunkKey& key) const
    {
        const std::uint64_t first = mortonOf({key.x, key.y, key.z}) << 3 * key.level;
        const auto codeOf = [](const ScratchChunk& c) { return mortonOf(c.place); };
        const auto begin = std::ranges::lower_bound(_chunks, first, {}, codeOf);
        const auto end = std::ranges::lower_bound(
            _chunks, first + (std::uint64_t{1} << 3 * key.level), {}, codeOf);
        return {begin, end};
    }

    std::optional<core::Error> put(Chunk chunk)
    {
        _report.allVoxels += chunk.voxels.size();
        ++_report.chunks;
        return _sink.put(std::move(chunk));
    }

    /// Makes all chunks under a key, and that of the key itself, whose voxels are handed up.
    std::optional<core::Error> finish(const ChunkKey& key, std::vector<WeightedVoxel>& voxels)
    {
        if (under(key).empty())
            return std::nullopt;
        if (isCancelled())
            return interrupted();
        if (key.level <= kGroupLevels)
            return finishGroup(key, voxels);
        std::array<std::vector<WeightedVoxel>, 8> children;
        for (std::uint32_t which = 0; which < 8; ++which)
            if (auto failed = finish(key.child(which), children[which]))
                return failed;
        std::array<std::span<const WeightedVoxel>, 8> parts;
        std::ranges::copy(children, parts.begin());
        voxels = reduced(parts, _reduction);
        return put(stored(key, voxels, !_model.colours.empty()));
    }

    std::optional<core::Error> finishGroup(const ChunkKey& key, std::vector<WeightedVoxel>& voxels)
    {
        const std::span<const ScratchChunk> chunks = under(key);
        const bool coloured = !_model.colours.empty();
        FirstError error;
        std::vector<std::vector<Made>> levels(key.level + 1);
        levels[0].resize(chunks.size());
        _jobs.parallelFor(chunks.size(), [&](std::size_t i) {
            _spaces.with([&](MaskSpace& space) {
                const Place& place = chunks[i].place;
                Made& made = levels[0][i];
                made.key = {0, place[0], place[1], place[2]};
                if (auto failed = withFaces(chunks[i], space.empty, made.voxels))
                    error.set(*failed);
                made.chunk = stored(made.key, made.voxels, coloured);
            });
        });
        if (error.failed())
            return error.error();
        for (std::uint32_t level = 1; level <= key.level; ++level) {
            const std::vector<Made>& below = levels[level - 1];
            std::vector<Made>& here = levels[level];
            std::vector<std::size_t> first; // child of each parent
            for (std::size_t i = 0; i < below.size(); ++i)
                if (i == 0 || below[i].key.parent() != below[i - 1].key.parent())
                    first.push_back(i);
            here.resize(first.size());
            first.push_back(below.size());
            _jobs.parallelFor(here.size(), [&](std::size_t i) {
                std::array<std::span<const WeightedVoxel>, 8> children;
                for (std::size_t child = first[i]; child < first[i + 1]; ++child) {
                    const ChunkKey& k = below[child].key;
                    children[(k.x & 1U) | (k.y & 1U) << 1U | (k.z & 1U) << 2U] =
                        below[child].voxels;
                }
                here[i].key = below[first[i]].key.parent();
                _spaces.with(
                    [&](MaskSpace& space) { here[i].voxels = reduced(children, space.reduction); });
                here[i].chunk = stored(here[i].key, here[i].voxels, coloured);
            });
        }
        for (std::vector<Made>& level : levels)
            for (Made& made : level)
                if (auto failed = put(std::move(made.chunk)))
                    return failed;
        _finished += chunks.size();
        if (_progress)
            _progress(
                kRasterShare + (1 - kRasterShare) * static_cast<double>(_finished) /
                                   static_cast<double>(_chunks.size()));
        voxels = std::move(levels.back().front().voxels);
        return std::nullopt;
    }

    /// Reads a chunk's voxels back and gives them their faces.
    std::optional<core::Error> withFaces(
        const ScratchChunk& chunk, EmptySpace& empty, std::vector<WeightedVoxel>& voxels) const
    {
        voxels.resize(chunk.voxels);
        if (auto failed = _scratch.read(chunk.voxelsAt, std::as_writable_bytes(std::span(voxels))))
            return failed;
        if (_settings.allFaces) {
            for (WeightedVoxel& voxel : voxels)
                voxel.place |= static_cast<std::uint32_t>(kAllFaces) << 24U;
            return std::nullopt;
        }
        empty.build(voxels);
        std::vector<bool> outside(empty.parts());
        for (EmptyLabel part = 0; part < empty.parts(); ++part)
            outside[part] = _outside.isOutside(chunk, part);
        std::array<std::vector<std::uint64_t>, kFaces> beyond;
        for (std::size_t face = 0; face < kFaces; ++face) {
            auto bits = _outside.beyond(chunk, static_cast<Face>(face));
            if (!bits)
                return bits.error();
            beyond[face] = std::move(*bits);
        }
        for (WeightedVoxel& voxel : voxels) {
            const Voxel own{voxel.place, 0};
            const Place at{own.x(), own.y(), own.z()};
            for (std::size_t face = 0; face < kFaces; ++face)
                if (isSeen(at, face, empty, outside, beyond[face]))
                    voxel.place |= static_cast<std::uint32_t>(faceBit(static_cast<Face>(face)))
                                   << 24U;
        }
        return std::nullopt;
    }
    static bool isSeen(
        const Place& at,
        std::size_t face,
        const EmptySpace& empty,
        const std::vector<bool>& outside,
        const std::vector<std::uint64_t>& beyond)
    {
        const std::size_t axis = face / 2;
        const bool high = face % 2 != 0;
        if (at[axis] == (high ? kChunkEdge - 1 : 0)) {
            const std::uint32_t row = at[axis == 2 ? 1 : 2];
            const std::uint32_t bit = row * kChunkEdge + at[axis == 0 ? 1 : 0];
            return (beyond[bit / 64] >> bit % 64 & 1U) != 0;
        }
        Place next = at;
        next[axis] += high ? 1U : ~std::uint32_t{0};
        const EmptyLabel label = empty.at(next[0], next[1], next[2]);
        return label != kFull && outside[label];
    }

    const VoxelizationSettings& _settings;
    ChunkSink& _sink;
    core::Jobs& _jobs;
    const std::atomic<bool>* _cancelled;
    const std::function<void(double)>& _progress;
    ScratchFile _scratch;
    VoxelizationReport _report;
    LatticeModel _model;
    Place _counts;
    OutsideSpace _outside;
    std::vector<ScratchChunk> _chunks; ///< those with voxels, along a Morton curve
    Pool<MaskSpace> _spaces;
    ReductionScratch _reduction;
    std::uint64_t _finished = 0;
};

} // namespace

VoxelLattice latticeFor(const core::Box& bounds, std::uint32_t resolution)
{
    VoxelLattice lattice;
    lattice.resolution = resolution;
    const glm::dvec3 size = bounds.size();
    const double longest = std::max({size.x, size.y, size.z});
    lattice.edge = longest > 0 ? longest / (resolution - 0.5) : 1;
    lattice.origin = bounds.low - glm::dvec3(0.25 * lattice.edge);
    const std::uint32_t chunks = (resolution + kChunkEdge - 1) / kChunkEdge;
    lattice.levels = 1 + static_cast<std::uint32_t>(std::bit_width(chunks - 1));
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
    if (!model.colours.empty() && model.colours.size() != model.positions.size())
        return core::failure(
            core::ErrorCode::badData,
            "the model has " + std::to_string(model.colours.size()) + " colours for " +
                std::to_string(model.positions.size()) + " positions");
    report.lattice = latticeFor(report.model.bounds, settings.resolution);
    auto scratch = ScratchFile::create(settings.scratchFolder);
    if (!scratch)
        return tl::unexpected(scratch.error());
    return Voxelizer(
               model,
               settings,
               sink,
               jobs,
               cancelled,
               progress,
               std::move(*scratch),
               std::move(report))
        .run();
}

} // namespace isofront::voxels

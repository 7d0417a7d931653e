#include "VoxelPipeline.h"

#include "EmptySpace.h"
#include "OutsideSpace.h"
#include "Pool.h"
#include "Reduction.h"
#include "ScratchFile.h"
#include "StoredChunk.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <mutex>
#include <optional>
#include <string>

namespace isofront::voxels {

namespace {

using Place = ChunkPlace;

/// Levels of detail whose chunks are made together, by all threads: groups of 64 chunks.
constexpr std::uint32_t kGroupLevels = 2;
/// How much of the work is done with the last voxel of level 0.
constexpr double kRasterShare = 0.7;

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

/// Processor time of all threads that share in some work.
class WorkTime {
public:
    /// Adds what a piece of work takes.
    template <typename Work>
    void measure(const Work& work)
    {
        const std::int64_t start = now();
        work();
        _nanoseconds += now() - start;
    }
    [[nodiscard]] double seconds() const { return 1e-9 * static_cast<double>(_nanoseconds); }

private:
    static std::int64_t now()
    {
        timespec time{};
        ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
    }
    std::atomic<std::int64_t> _nanoseconds = 0;
};

/// All passes over one model.
class Pipeline {
public:
    Pipeline(
        VoxelSource& source,
        const PipelineSettings& settings,
        ChunkSink& sink,
        core::Jobs& jobs,
        const std::atomic<bool>* cancelled,
        const std::function<void(double)>& progress,
        ScratchFile scratch)
        : _source(source), _settings(settings), _sink(sink), _jobs(jobs), _cancelled(cancelled),
          _progress(progress), _scratch(std::move(scratch)), _outside(source.counts(), _scratch)
    {
    }

    core::Result<PipelineReport> run()
    {
        if (auto failed = rasterise(_source.tasks()))
            return tl::unexpected(*failed);
        if (!_settings.allFaces) {
            if (auto failed = _outside.build(_chunks))
                return tl::unexpected(*failed);
            _report.emptyRegions = _outside.closedParts();
        }
        VoxelList top;
        if (auto failed = finish({_settings.levels - 1, 0, 0, 0}, top))
            return tl::unexpected(*failed);
        if (_progress)
            _progress(1);
        _report.scratchBytes = _scratch.bytes();
        _report.makeSeconds = _makeTime.seconds();
        _report.reduceSeconds = _reduceTime.seconds();
        return _report;
    }

private:
    /// What a job needs to make a chunk's voxels.
    struct RasterSpace {
        VoxelList list;
        EmptySpace empty;
    };
    struct MaskSpace {
        EmptySpace empty;
    };
    /// A chunk of a group while the group is made.
    struct Made {
        ChunkKey key;
        VoxelList list;
        Chunk chunk;
    };

    [[nodiscard]] bool isCancelled() const
    {
        return _cancelled != nullptr && _cancelled->load(std::memory_order_relaxed);
    }
    static core::Error interrupted() { return {core::ErrorCode::interrupted, "interrupted"}; }

    std::optional<core::Error> rasterise(const std::vector<VoxelSource::Task>& tasks)
    {
        std::uint64_t work = 0;
        for (const VoxelSource::Task& task : tasks)
            work += task.work;
        std::vector<ScratchChunk> chunks(tasks.size());
        Pool<RasterSpace> spaces;
        FirstError error;
        std::atomic<std::uint64_t> done = 0;
        std::mutex telling;
        _jobs.parallelFor(tasks.size(), [&](std::size_t i) {
            if (error.failed())
                return;
            if (isCancelled()) {
                error.set(interrupted());
                return;
            }
            spaces.with([&](RasterSpace& space) {
                space.list.clear();
                _makeTime.measure([&] { _source.make(tasks[i].place, space.list); });
                auto kept = keep(tasks[i].place, space.list, space.empty);
                if (kept)
                    chunks[i] = *kept;
                else
                    error.set(kept.error());
            });
            const std::uint64_t sum = done += tasks[i].work;
            if (_progress) {
                const std::scoped_lock lock(telling);
                _progress(kRasterShare * static_cast<double>(sum) / static_cast<double>(work));
            }
        });
        if (error.failed())
            return error.error();
        // sources leave out what is left of a chunk once they are told to end
        if (isCancelled())
            return interrupted();
        for (const ScratchChunk& chunk : chunks)
            if (chunk.voxels > 0)
                _chunks.push_back(chunk);
        // in the order of their places in the hierarchy, so that each of its parts is a range
        std::ranges::sort(_chunks, {}, [](const ScratchChunk& c) { return mortonOf(c.place); });
        return std::nullopt;
    }

    core::Result<ScratchChunk> keep(const Place& place, const VoxelList& list, EmptySpace& empty)
    {
        ScratchChunk chunk;
        chunk.place = place;
        chunk.voxels = static_cast<std::uint32_t>(list.voxels.size());
        chunk.faces = static_cast<std::uint32_t>(list.faces.size());
        if (list.voxels.empty())
            return chunk;
        const auto at = _scratch.append(std::as_bytes(std::span(list.voxels)));
        if (!at)
            return tl::unexpected(at.error());
        chunk.voxelsAt = *at;
        if (!list.colours.empty()) {
            const auto coloursAt = _scratch.append(std::as_bytes(std::span(list.colours)));
            if (!coloursAt)
                return tl::unexpected(coloursAt.error());
            chunk.coloursAt = *coloursAt;
        }
        if (!list.faces.empty()) {
            const auto facesAt = _scratch.append(std::as_bytes(std::span(list.faces)));
            if (!facesAt)
                return tl::unexpected(facesAt.error());
            chunk.facesAt = *facesAt;
        }
        if (_settings.allFaces)
            return chunk;
        empty.build(list.voxels);
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
        if (chunk.voxels.empty())
            return std::nullopt;
        if (chunk.key.level == 0)
            _report.voxels += chunk.voxels.size();
        _report.allVoxels += chunk.voxels.size();
        ++_report.chunks;
        return _sink.put(std::move(chunk));
    }

    /// Makes all chunks under a key, and that of the key itself, whose voxels are handed up.
    std::optional<core::Error> finish(const ChunkKey& key, VoxelList& list)
    {
        if (isCancelled())
            return interrupted();
        if (under(key).empty())
            return std::nullopt;
        if (key.level <= kGroupLevels)
            return finishGroup(key, list);
        std::array<VoxelList, 8> children;
        std::array<const VoxelList*, 8> parts{};
        for (std::uint32_t which = 0; which < 8; ++which) {
            if (auto failed = finish(key.child(which), children[which]))
                return failed;
            parts[which] = &children[which];
        }
        _reduceTime.measure([&] { list = reduced(parts); });
        return put(stored(key, list, _source.isColoured()));
    }

    std::optional<core::Error> finishGroup(const ChunkKey& key, VoxelList& list)
    {
        const std::span<const ScratchChunk> chunks = under(key);
        const bool coloured = _source.isColoured();
        FirstError error;
        std::vector<std::vector<Made>> levels(key.level + 1);
        levels[0].resize(chunks.size());
        _jobs.parallelFor(chunks.size(), [&](std::size_t i) {
            _spaces.with([&](MaskSpace& space) {
                const Place& place = chunks[i].place;
                Made& made = levels[0][i];
                made.key = {0, place[0], place[1], place[2]};
                if (auto failed = withFaces(chunks[i], space.empty, made.list))
                    error.set(*failed);
                made.chunk = stored(made.key, made.list, coloured);
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
                std::array<const VoxelList*, 8> children{};
                for (std::size_t child = first[i]; child < first[i + 1]; ++child) {
                    const ChunkKey& k = below[child].key;
                    children[(k.x & 1U) | (k.y & 1U) << 1U | (k.z & 1U) << 2U] = &below[child].list;
                }
                here[i].key = below[first[i]].key.parent();
                _reduceTime.measure([&] { here[i].list = reduced(children); });
                here[i].chunk = stored(here[i].key, here[i].list, coloured);
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
        list = std::move(levels.back().front().list);
        return std::nullopt;
    }

    /// Reads a chunk's voxels back and gives them their faces.
    std::optional<core::Error>
    withFaces(const ScratchChunk& chunk, EmptySpace& empty, VoxelList& list) const
    {
        std::vector<WeightedVoxel>& voxels = list.voxels;
        voxels.resize(chunk.voxels);
        if (auto failed = _scratch.read(chunk.voxelsAt, std::as_writable_bytes(std::span(voxels))))
            return failed;
        if (_source.isColoured()) {
            list.colours.resize(chunk.voxels);
            if (auto failed =
                    _scratch.read(chunk.coloursAt, std::as_writable_bytes(std::span(list.colours))))
                return failed;
        }
        list.faces.resize(chunk.faces);
        if (chunk.faces > 0)
            if (auto failed =
                    _scratch.read(chunk.facesAt, std::as_writable_bytes(std::span(list.faces))))
                return failed;
        if (_settings.allFaces) {
            for (WeightedVoxel& voxel : voxels)
                voxel.place |= static_cast<std::uint32_t>(kAllFaces) << 24U;
            dropWalls(list);
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
        show(voxels, empty, outside, beyond);
        dropWalls(list);
        return std::nullopt;
    }
    /// Removes the voxels that only closed the solid. They have no faces of their own.
    static void dropWalls(VoxelList& list)
    {
        const auto isWall = [](const WeightedVoxel& voxel) { return (voxel.place & kWall) != 0; };
        if (std::ranges::none_of(list.voxels, isWall))
            return;
        std::vector<std::uint32_t> indexOf(list.voxels.size());
        std::uint32_t kept = 0;
        for (std::size_t i = 0; i < list.voxels.size(); ++i) {
            indexOf[i] = kept;
            if (isWall(list.voxels[i]))
                continue;
            list.voxels[kept] = list.voxels[i];
            if (!list.colours.empty())
                list.colours[kept] = list.colours[i];
            ++kept;
        }
        list.voxels.resize(kept);
        if (!list.colours.empty())
            list.colours.resize(kept);
        for (WeightedFaces& faces : list.faces)
            faces.voxel = indexOf[faces.voxel];
    }
    /// Gives voxels the faces across which it is outside.
    static void show(
        std::vector<WeightedVoxel>& voxels,
        const EmptySpace& empty,
        const std::vector<bool>& outside,
        const std::array<std::vector<std::uint64_t>, kFaces>& beyond)
    {
        constexpr std::uint32_t kLast = kChunkEdge - 1;
        constexpr std::uint32_t kNoRow = 0xffffffffU;
        std::uint32_t row = kNoRow;
        EmptySpace::RowCursor own;
        std::array<EmptySpace::RowCursor, kFaces> beside; // across each face but those along x
        for (WeightedVoxel& voxel : voxels) {
            const Voxel at{voxel.place, 0};
            const std::array<std::uint32_t, 3> place{at.x(), at.y(), at.z()};
            if (voxel.order() / kChunkEdge != row) {
                row = voxel.order() / kChunkEdge;
                own = empty.along(place[1], place[2]);
                for (std::size_t face = 2; face < kFaces; ++face) {
                    Place next = place;
                    if (next[face / 2] != (face % 2 != 0 ? kLast : 0)) {
                        next[face / 2] += face % 2 != 0 ? 1U : ~std::uint32_t{0};
                        beside[face] = empty.along(next[1], next[2]);
                    }
                }
            }
            for (std::size_t face = 0; face < kFaces; ++face) {
                const std::size_t axis = face / 2;
                const bool high = face % 2 != 0;
                bool isSeen = false;
                if (place[axis] == (high ? kLast : 0)) {
                    const std::uint32_t bit =
                        place[axis == 2 ? 1 : 2] * kChunkEdge + place[axis == 0 ? 1 : 0];
                    isSeen = (beyond[face][bit / 64] >> bit % 64 & 1U) != 0;
                } else {
                    const EmptyLabel label = axis > 0 ? beside[face].at(place[0])
                                                      : own.at(high ? place[0] + 1 : place[0] - 1);
                    isSeen = label != kFull && outside[label];
                }
                if (isSeen)
                    voxel.place |= static_cast<std::uint32_t>(faceBit(static_cast<Face>(face)))
                                   << 24U;
            }
        }
    }

    VoxelSource& _source;
    const PipelineSettings& _settings;
    ChunkSink& _sink;
    core::Jobs& _jobs;
    const std::atomic<bool>* _cancelled;
    const std::function<void(double)>& _progress;
    ScratchFile _scratch;
    OutsideSpace _outside;
    PipelineReport _report;
    std::vector<ScratchChunk> _chunks; ///< those with voxels, along a Morton curve
    Pool<MaskSpace> _spaces;
    std::uint64_t _finished = 0;
    WorkTime _makeTime;
    WorkTime _reduceTime;
};

} // namespace

core::Result<PipelineReport> runPipeline(
    VoxelSource& source,
    const PipelineSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled,
    const std::function<void(double)>& progress)
{
    auto scratch = ScratchFile::create(settings.scratchFolder);
    if (!scratch)
        return tl::unexpected(scratch.error());
    return Pipeline(source, settings, sink, jobs, cancelled, progress, std::move(*scratch)).run();
}

} // namespace isofront::voxels

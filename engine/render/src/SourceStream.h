#pragma once

#include "isofront/render/HandOver.h"
#include "isofront/render/HybridScene.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/Delta.h>
#include <isofront/voxels/SourceMesh.h>

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <unordered_map>
#include <vector>

namespace isofront::render {

/// Brings the triangles that a voxel model was made from, block by block, where its finest voxels
/// are too coarse: as deltas of cells, like a surface's.
///
/// The source is read when a view needs it for the first time. What is near comes first; what a
/// view needs stays; all else leaves when room is short, once voxels have its place.
///
/// Thread: one at a time. Reading and cutting run in `jobs`.
class SourceStream {
public:
    /// @param grid   blocks of the hand-over, which are the parts that come and go
    /// @param bytes  what triangles may take on the device
    SourceStream(
        SourceReader read,
        const voxels::VoxelLattice& lattice,
        const BlockGrid& grid,
        std::shared_ptr<core::Jobs> jobs,
        std::uint64_t bytes);
    SourceStream(const SourceStream&) = delete;
    SourceStream& operator=(const SourceStream&) = delete;
    /// Stops what is read and cut, and waits until nothing is.
    ~SourceStream();

    /// The next step of the cells on the device, never waiting. Follow it by `confirm` or `refuse`.
    /// @param fadingBytes  of meshes that only a former picture shows
    surface::Delta
    update(const hierarchy::View& view, const HandOver& owners, std::uint64_t fadingBytes);
    /// The step was applied.
    void confirm();
    /// There was no room for the step: nothing of it has happened, and so much isn't tried again.
    void refuse();

    /// For HandOver::setSource.
    [[nodiscard]] std::span<const SourceState> states() const { return _states; }
    /// Whether all that the last view needs is there, as far as there is room for it.
    [[nodiscard]] bool isComplete() const { return _isComplete; }
    /// Whether something is read or cut, or was so since the last step.
    [[nodiscard]] bool isWorking() const;
    /// Waits until something is read or cut, or nothing is being so, or it is told to stop.
    void wait(const std::stop_token& stop);
    /// Why there is no source, once.
    std::optional<core::Error> takeError();

    /// Whether nobody outside sees the back of what is shown: SourceMesh::isClosed.
    [[nodiscard]] bool isClosed() const { return _isClosed; }
    [[nodiscard]] std::uint64_t bytes() const { return _bytes; } ///< on the device
    [[nodiscard]] std::size_t hostBytes() const;
    [[nodiscard]] bool isFull() const { return _isFull; } ///< a view needs more than there is room

private:
    /// A block's cells.
    struct Part {
        std::vector<surface::ShownCell> cells;
        std::uint64_t bytes = 0; ///< on the device
    };
    struct Resident {
        std::vector<surface::CellId> ids;
        std::uint64_t bytes = 0;
    };
    void open();
    void cut(std::size_t block);
    void take();
    void fail(const core::Error& error);
    void submit(std::function<void()> job);
    [[nodiscard]] std::vector<std::size_t>
    wanted(const hierarchy::View& view, double distance) const;
    [[nodiscard]] Part partOf(const voxels::SourceMesh& mesh, std::size_t block) const;
    void letGo(
        const glm::dvec3& eye,
        const HandOver& owners,
        const std::set<std::size_t>& kept,
        std::uint64_t needed);
    [[nodiscard]] glm::uvec3 placeOf(std::size_t block) const;

    SourceReader _read;
    voxels::VoxelLattice _lattice;
    BlockGrid _grid;
    std::shared_ptr<core::Jobs> _jobs;
    std::uint32_t _exponent; ///< of the cells: extractor::CellMesh

    std::vector<SourceState> _states;
    std::unordered_map<std::size_t, Resident> _residents;
    std::unordered_map<std::size_t, Part> _cut; ///< waits for room, or for its frame
    std::uint64_t _bytes = 0;
    std::uint64_t _limit; ///< of the bytes; less after a refusal
    bool _isComplete = true;
    bool _isFull = false;
    bool _isClosed = false;
    std::optional<core::Error> _error;
    bool _hasFailed = false;
    bool _isOpening = false;
    std::set<std::size_t> _asked; ///< blocks being cut
    surface::Delta _delta;        ///< the last step
    std::vector<std::size_t> _added;
    std::vector<std::size_t> _removed;
    std::uint64_t _version = 0;

    std::shared_ptr<const voxels::SourceMesh> _mesh; ///< once it is read
    mutable std::mutex _mutex;                       ///< of what follows
    std::condition_variable_any _changed;
    std::optional<core::Result<std::shared_ptr<const voxels::SourceMesh>>> _opened;
    std::vector<std::pair<std::size_t, core::Result<Part>>> _done;
    std::size_t _running = 0;
    std::stop_source _stopping; ///< of all jobs
};

} // namespace isofront::render

#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/Delta.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>

namespace isofront::surface {

struct SurfaceOptions {
    extractor::ExtractionSettings extraction;
    /// How far the mesh may lie from the true surface on the screen, as expected before extraction
    /// [px]. Triangles, time and memory fall with its square.
    double pixelError = 2.0;
    /// No cell is finer than this; see hierarchy::kMaxLevel.
    int maxLevel = hierarchy::kMaxLevel;
    /// Bound of the cache of meshes that are not shown but may be again [bytes].
    std::size_t cacheBytes = std::size_t{256} << 20U;
};

struct UpdateBudget {
    double milliseconds = 2.0; ///< of the calling thread; what is left is done in later updates
};

/// Counters of a surface; those of work add up from its beginning.
struct SurfaceStats {
    std::size_t frontCells = 0;       ///< cells of the shown front, empty ones included
    std::size_t shownCells = 0;       ///< those with triangles
    std::size_t triangles = 0;        ///< shown
    std::size_t pendingCells = 0;     ///< asked for and not there yet
    std::size_t meshBytes = 0;        ///< of the shown meshes
    std::size_t cacheBytes = 0;       ///< of the cache
    std::size_t hierarchyBytes = 0;   ///< of the fronts, about
    std::uint64_t cellsExtracted = 0; ///< sampled
    std::uint64_t cellsSkipped = 0;   ///< proved empty by the field's bounds, never sampled
    std::uint64_t cellsFromCache = 0;
    std::uint64_t cellsCancelled = 0; ///< asked for, and no longer wanted before they were there
    std::uint64_t samples = 0;
    std::uint64_t sanitisedSamples = 0;
    std::uint64_t refusedViews = 0; ///< not finite
    std::uint64_t deltas = 0;
};

/// The surface of a field at the detail a viewer needs, as a stream of deltas.
///
/// Two fronts make it work. The wanted front follows the viewer at once, in integers. The shown
/// front trails it: a diamond is split or merged in it when the meshes of all cells that this
/// brings have been extracted, in the background and most visible error first. So what the deltas
/// add up to is a conforming, crack-free mesh after each of them.
///
/// Thread: one at a time. Extraction runs in `jobs`.
class Surface {
public:
    /// @param jobs  where cells are extracted; null makes a pool of its own
    Surface(
        std::shared_ptr<const fields::Field> field,
        hierarchy::Domain domain,
        SurfaceOptions options = {},
        std::shared_ptr<core::Jobs> jobs = nullptr);
    Surface(Surface&&) noexcept;
    Surface& operator=(Surface&&) noexcept;
    ~Surface();

    /// Follows the viewer and hands out what is ready. Never waits for an extraction. A view that
    /// is not valid changes nothing and is counted.
    Delta update(const hierarchy::View& view, const UpdateBudget& budget = {});

    /// Waits until the surface is as the view wants it, skipping everything in between: for still
    /// pictures and the first frame. The delta leads from what is shown now to that.
    /// @param progress  called from the calling thread with a share in [0, 1], now and then
    /// @param stop      ends it early: the delta is empty then, and nothing has changed
    Delta settle(
        const hierarchy::View& view,
        const std::function<void(double)>& progress = {},
        const std::stop_token& stop = {});

    /// True if the last update's view has all it wants.
    [[nodiscard]] bool isSettled() const;
    [[nodiscard]] SurfaceStats stats() const;
    [[nodiscard]] const hierarchy::Domain& domain() const;

private:
    class Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace isofront::surface

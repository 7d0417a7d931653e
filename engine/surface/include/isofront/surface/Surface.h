#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/Delta.h>
#include <isofront/surface/DetailSettings.h>
#include <isofront/surface/SharedCells.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <stop_token>

namespace isofront::surface {

struct SurfaceOptions {
    extractor::ExtractionSettings extraction;
    /// How far the mesh may lie from the true surface on the screen, as expected before extraction
    /// [px]. Triangles, time and memory fall with its square.
    double pixelError = 2.0;
    /// What decides about detail beside the pixels.
    DetailSettings detail;
    /// No cell is finer than this; see hierarchy::kMaxLevel.
    int maxLevel = hierarchy::kMaxLevel;
    /// Bound of the cache of meshes that are not shown but may be again [bytes].
    std::size_t cacheBytes = std::size_t{256} << 20U;
    /// Cells that are shared with other surfaces of the same field in the same domain; null for
    /// none. SurfaceStats counts them as extracted, whoever did it.
    std::shared_ptr<SharedCells> shared;

    /// Ceilings. Where one would be exceeded, all errors that are asked for are allowed to grow by
    /// the same factor, until what they lead to fits: SurfaceStats::effectivePixelError tells.
    std::size_t maxCells = std::numeric_limits<std::size_t>::max(); ///< empty ones included, >= 6
    std::size_t maxTriangles = std::numeric_limits<std::size_t>::max(); ///< shown
    /// Of meshes shown and under way, of the cache (which gives way first), of the hierarchy, and
    /// of UpdateBudget::hostBytes [bytes].
    std::size_t maxBytes = std::numeric_limits<std::size_t>::max();

    /// After a change of the isovalue show a front first that has as many cells less as one that is
    /// coarser by so many levels, and is there sooner: a quarter for 3 levels.
    int coarseFirst = 0;

    /// Where a viewer jumps, show what he then sees in a few whole steps, each with a quarter of
    /// the cells of the next, in place of diamond by diamond through all levels between: fewer than
    /// half as many cells are extracted until all is there, but detail doesn't come to the most
    /// visible places first, and the viewer isn't followed while a step is prepared. Not where
    /// errors are measured, which takes the levels between, nor under ceilings.
    bool skipLevels = false;
};

struct UpdateBudget {
    double milliseconds = 2.0; ///< of the calling thread; what is left is done in later updates
    /// What the host holds for this surface and counts in SurfaceOptions::maxBytes, for example
    /// removed meshes that are still fading [bytes].
    std::size_t hostBytes = 0;
};

/// Counters of a surface; those of work add up from its beginning.
struct SurfaceStats {
    std::size_t frontCells = 0;     ///< cells of the shown front, empty ones included
    std::size_t shownCells = 0;     ///< those with triangles
    std::size_t triangles = 0;      ///< shown
    std::size_t pendingCells = 0;   ///< asked for and not there yet
    std::size_t meshBytes = 0;      ///< of the shown meshes
    std::size_t cacheBytes = 0;     ///< of the cache
    std::size_t hierarchyBytes = 0; ///< of the fronts and of what is known of diamonds, about
    std::size_t totalBytes = 0;     ///< all that SurfaceOptions::maxBytes counts
    /// What the ceilings leave of SurfaceOptions::pixelError [px].
    double effectivePixelError = 0;
    std::uint64_t cellsExtracted = 0; ///< sampled
    std::uint64_t cellsSkipped = 0;   ///< proved empty by the field's bounds, never sampled
    std::uint64_t cellsFromCache = 0;
    std::uint64_t cellsCancelled = 0; ///< asked for, and no longer wanted before they were there
    std::uint64_t samples = 0;
    std::uint64_t sanitisedSamples = 0;
    std::uint64_t refusedViews = 0;     ///< not finite
    std::uint64_t refusedIsovalues = 0; ///< not finite
    std::uint64_t deltas = 0;
};

/// The surface of a field at the detail a viewer needs, as a stream of deltas.
///
/// Two fronts make it work. The wanted front follows the viewer at once, in integers. The shown
/// front trails it: a diamond is split or merged in it when the meshes of all cells that this
/// brings have been extracted, in the background and most visible error first. So what the deltas
/// add up to is a conforming, crack-free mesh of one isovalue after each of them.
///
/// Where a viewer comes to rest, the surface ends as one that is built from nothing for that view,
/// whatever was seen before.
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

    /// Asks for another isovalue [field units]. Returns at once; the updates to come show the old
    /// surface until the new one is whole, and take it in one delta. Until then detail stays as it
    /// is. Another call abandons what is under way. A value that is not finite changes nothing and
    /// is counted.
    void setIsovalue(double isovalue);
    /// The one asked for last.
    [[nodiscard]] double isovalue() const;
    /// Asks for another detail in the updates to come.
    /// @param pixelError  see SurfaceOptions, > 0
    void setDetail(double pixelError, DetailSettings detail);

    /// True if the last update's view has all it wants, and the ceilings leave nothing to try.
    [[nodiscard]] bool isSettled() const;
    [[nodiscard]] SurfaceStats stats() const;
    [[nodiscard]] const hierarchy::Domain& domain() const;

private:
    class Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace isofront::surface

#pragma once

#include "CellCache.h"
#include "FormerMeshes.h"
#include "isofront/surface/Delta.h"
#include "isofront/surface/SharedCells.h"
#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/Jobs.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Front.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace isofront::surface {

/// Prepares another whole surface in the background, with the one delta that leads to it: for
/// another isovalue, or for a viewer who has jumped. All that depends on the number of cells is
/// done here, so that to take over the result costs the same whatever its size.
///
/// Thread: members from one thread. What it is given to read must not change until `isQuiet()`.
class WholeSurface : public std::enable_shared_from_this<WholeSurface> {
public:
    struct Sources {
        std::shared_ptr<const extractor::CellExtractor> extractor;
        std::shared_ptr<SharedCells> shared; ///< with other surfaces; null for none
        const hierarchy::Front* shown = nullptr;
        const CellMeshes* meshes = nullptr; ///< of it
        bool sameIsovalue = false;          ///< so that meshes that are shown can stay
        /// The front to prepare; null for the one that is shown.
        const hierarchy::Front* target = nullptr;
        /// Levels to take from the finest places of the target, or of what it has beyond the shown
        /// front if it is another.
        int coarser = 0;
        const CellCache* cache = nullptr;
        /// What else is known of cells at the extractor's isovalue.
        std::vector<const FormerMeshes*> former;
        const DiamondBounds* bounds = nullptr;
        /// Of the isovalue that is shown, to tell which cells bounds prove empty.
        std::shared_ptr<const extractor::CellExtractor> shownExtractor;
        /// Of the cells that are shown; null if errors are not measured.
        const MeasuredErrors* shownErrors = nullptr;
    };
    struct Result {
        hierarchy::Front shown;                     ///< the front of the meshes
        hierarchy::Front wanted;                    ///< the same once more
        CellMeshes meshes;                          ///< those with triangles
        std::vector<FormerMeshes::EmptyCell> empty; ///< cells found to have none, by name
        /// What is known of the cells without triangles that are to go; nothing of those that their
        /// diamond's bounds prove empty, which is as easily told again.
        std::vector<FormerMeshes::EmptyCell> shownEmpty;
        CellMeshes leaving; ///< meshes that are to go, if the isovalue stays
        std::size_t leavingBytes = 0;
        Delta delta; ///< without a version
        std::shared_ptr<MeasuredErrors> errors;
        std::size_t triangles = 0;
        std::size_t meshBytes = 0;
        std::uint64_t cellsExtracted = 0;
        std::uint64_t cellsSkipped = 0;
        std::uint64_t cellsFromCache = 0;
        std::uint64_t samples = 0;
        std::uint64_t sanitisedSamples = 0;
    };

    /// @param jobs  must be there until it is quiet
    WholeSurface(Sources sources, core::Jobs& jobs) : _sources(std::move(sources)), _jobs(&jobs) {}

    void start();
    /// Asks it to end early. Of the result there are then only the meshes and empty cells that were
    /// extracted until then.
    void abort() { _aborted.store(true, std::memory_order_relaxed); }
    [[nodiscard]] bool isAborted() const { return _aborted.load(std::memory_order_relaxed); }
    /// True once nothing of it runs any more.
    [[nodiscard]] bool isQuiet() const { return _quiet.load(std::memory_order_acquire); }
    void wait() const { _quiet.wait(false, std::memory_order_acquire); }
    /// Cells that are still to be extracted, as far as is known.
    [[nodiscard]] std::size_t pending() const;
    /// Once it is quiet.
    [[nodiscard]] Result& result() { return _result; }
    [[nodiscard]] const Result& result() const { return _result; }
    [[nodiscard]] int coarser() const { return _sources.coarser; }
    /// True if it is of another front than the one that is shown.
    [[nodiscard]] bool hasTarget() const { return _sources.target != nullptr; }
    [[nodiscard]] double isovalue() const { return _sources.extractor->settings().isovalue; }

private:
    struct Item {
        CellId id;
        CellMeshPointer mesh; ///< null until it is extracted
        enum class Origin : std::uint8_t { shown, cache, extracted } origin = Origin::extracted;
    };

    void list();
    void listShownEmpty();
    void work();
    [[nodiscard]] CellMeshPointer known(const CellId& id) const;
    void leave();
    void keep(Item& item);
    void salvage();
    void assemble();

    Sources _sources;
    /// Not shared: the last to let go of jobs would wait for them, and that may be one of them.
    core::Jobs* _jobs;
    std::vector<Item> _items; ///< cells that may have a surface, by their names
    std::atomic<std::size_t> _next{0};
    std::atomic<std::size_t> _count{0};
    std::atomic<std::size_t> _running{0};
    std::atomic<bool> _aborted{false};
    std::atomic<bool> _quiet{false};
    Result _result;
};

} // namespace isofront::surface

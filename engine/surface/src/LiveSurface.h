#pragma once

#include "BudgetControl.h"
#include "CellCache.h"
#include "DeltaBuilder.h"
#include "ExtractionQueue.h"
#include "WholeSurface.h"
#include "isofront/surface/Surface.h"
#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/hierarchy/Refinement.h>

#include <chrono>
#include <deque>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace isofront::surface {

/// What a Surface does.
///
/// In turn: usually the wanted front follows the viewer and the shown one follows it, operation by
/// operation. While another isovalue is prepared (`_whole`), both stand still. When the viewer
/// rests and nothing is left to do, a front is built from nothing for the view (`_rest`), and what
/// differs from it becomes operations, too.
class Surface::Impl {
public:
    Impl(
        std::shared_ptr<const fields::Field> field,
        const hierarchy::Domain& domain,
        const SurfaceOptions& options,
        std::shared_ptr<core::Jobs> jobs);
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl();

    Delta update(const hierarchy::View& view, const UpdateBudget& budget);
    Delta settle(
        const hierarchy::View& view,
        const std::function<void(double)>& progress,
        const std::stop_token& stop);
    void setIsovalue(double isovalue);
    [[nodiscard]] double isovalue() const { return _isovalue; }
    void setDetail(double pixelError, DetailSettings detail);
    [[nodiscard]] bool isSettled() const;
    [[nodiscard]] SurfaceStats stats() const;
    [[nodiscard]] const hierarchy::Domain& domain() const { return _refinement.domain(); }

private:
    using Clock = std::chrono::steady_clock;
    using LatticePoint = hierarchy::LatticePoint;
    using LatticePointHash = hierarchy::LatticePointHash;
    using Requests = std::vector<ExtractionQueue::Request>;

    /// What a diamond's split or merge brings to the shown front.
    struct Operation {
        bool split = false;
        std::vector<CellId> cells;
        std::vector<CellMeshPointer> meshes; ///< as long as `cells`; null while missing
        std::size_t missing = 0;
        double urgency = 0;
        bool waits = false; ///< when it was planned, for another that leads the same way
    };
    using Operations = std::unordered_map<LatticePoint, Operation, LatticePointHash>;

    /// The front built from nothing while the viewer rests.
    struct Rest {
        explicit Rest(hierarchy::Refinement fresh) : refinement(std::move(fresh)) {}

        hierarchy::Refinement refinement;
        enum class Stage { refining, asking, comparing } stage = Stage::refining;
        std::vector<LatticePoint> left; ///< diamonds that the stage has still to look at
        bool comparesWanted = false;    ///< they are those of the wanted front, else of the new one
        std::unordered_set<CellId, CellIdHash> measured; ///< cells that are being extracted for it
        std::vector<hierarchy::FrontChange> changes;
    };
    class Settling; // Settling.cpp

    // LiveSurface.cpp: the viewer and the criterion
    void follow(const hierarchy::View& view);
    void renewCriterion();
    [[nodiscard]] hierarchy::RefinementSettings refinementSettings() const;
    [[nodiscard]] std::shared_ptr<const extractor::CellExtractor>
    extractorFor(double isovalue) const;

    // the way from the wanted front to the shown one
    void refine(Requests& requests, Clock::time_point deadline);
    void plan(const std::vector<hierarchy::FrontChange>& changes, Requests& requests);
    void plan(const hierarchy::FrontChange& change, double urgency, Requests& requests);
    void drop(Operations::iterator found);
    void request(Requests& requests);
    void reorder(Requests& requests);
    [[nodiscard]] double urgencyOf(const LatticePoint& centre, bool split) const;
    [[nodiscard]] bool isInView(const hierarchy::Diamond& diamond) const;
    void receive(DeltaBuilder& delta, Clock::time_point deadline);
    void receiveRoot(ExtractionQueue::Finished finished, DeltaBuilder& delta);
    void commitReady(DeltaBuilder& delta, Clock::time_point deadline);
    void commit(const LatticePoint& centre, Operation operation, DeltaBuilder& delta);
    [[nodiscard]] bool isLiveSettled() const;
    void beginMeasuring();

    // meshes
    [[nodiscard]] bool isShown(const CellId& id) const;
    void show(const CellId& id, CellMeshPointer mesh, DeltaBuilder& delta);
    void hide(const CellId& id, DeltaBuilder& delta);
    void keep(const CellId& id, CellMeshPointer mesh);
    CellMeshPointer fromCache(const CellId& id);
    void measure(const CellId& id, const extractor::CellMesh& mesh);
    void count(const extractor::CellMesh& mesh);
    void count(const WholeSurface::Result& result);
    void retire(FormerMeshes former);
    void retireSome(Clock::time_point deadline);
    void boundRetired();
    Delta finish(DeltaBuilder& delta);
    template <typename T>
    void discard(T thing);

    // Ceilings.cpp
    [[nodiscard]] std::size_t bytesInUse() const;
    [[nodiscard]] std::size_t bytesNeeded() const;
    [[nodiscard]] bool hasRoomFor(const LatticePoint& centre, const Operation& operation) const;
    [[nodiscard]] bool hasRoomForAllOperations() const;
    [[nodiscard]] double shareOfCeilings() const;
    void watchCells();
    void watchCeilings();
    void judgeTrial();

    // Changing.cpp: another isovalue
    std::optional<Delta> change();
    void startWhole(int coarser, const hierarchy::Front* target = nullptr);
    Delta takeOverJump(WholeSurface& whole);
    void giveUp(std::shared_ptr<WholeSurface> whole);
    [[nodiscard]] int firstCoarser() const;
    [[nodiscard]] int levelsTooFine(const WholeSurface& whole) const;
    Delta takeOver(WholeSurface& whole);
    void forgetWork();

    // Jumping.cpp
    [[nodiscard]] bool isJumping() const;
    bool holdsBack(Requests& requests);
    void retireOperations();
    void startJump();
    [[nodiscard]] bool jumpsElsewhere() const;

    // Resting.cpp
    void rest(Requests& requests, Clock::time_point deadline);
    void restAsk(Requests& requests);
    void restCompare(Requests& requests);
    void stopResting();
    /// Cells of an unsplit diamond that must be extracted before it can be told whether it is to be
    /// split.
    [[nodiscard]] std::vector<CellId>
    undecidedCells(const hierarchy::Refinement& refinement, const LatticePoint& centre) const;

    SurfaceOptions _options;
    std::shared_ptr<core::Jobs> _jobs;
    std::shared_ptr<const fields::Field> _field;
    hierarchy::Domain _domain;
    std::shared_ptr<const extractor::CellExtractor> _extractor; ///< of the isovalue asked for
    std::shared_ptr<DiamondBounds> _bounds = std::make_shared<DiamondBounds>();
    std::shared_ptr<MeasuredErrors> _errors = std::make_shared<MeasuredErrors>();
    std::shared_ptr<const WhereSurface> _criterion; ///< of the view's resolution
    hierarchy::Refinement _refinement;              ///< holds the wanted front
    hierarchy::Front _shown;
    CellMeshes _meshes; ///< shown, with triangles
    double _isovalue = 0;
    double _shownIsovalue = 0;
    CellCache _cache;
    std::deque<FormerMeshes> _retired; ///< on their way to the cache, the oldest first
    std::size_t _retiredBytes = 0;
    Operations _operations;
    std::size_t _waiting = 0;                                    ///< operations that do
    std::size_t _merges = 0;                                     ///< of the operations
    std::size_t _flightBytes = 0;                                ///< of meshes that operations hold
    std::unordered_map<CellId, LatticePoint, CellIdHash> _owner; ///< of cells asked for
    std::vector<ExtractionQueue::Finished> _arrived;             ///< and not yet looked at
    std::vector<LatticePoint> _ready;
    std::vector<LatticePoint> _blocked; ///< ready, but over a ceiling
    std::vector<CellId> _rootMissing;
    std::vector<ExtractionQueue::Finished> _rootMeshes;
    bool _rootShown = false;
    hierarchy::View _view;
    bool _hasView = false;
    bool _viewStays = false; ///< the last two updates had the same
    double _pixelsPerUnit = 0;
    bool _stillToReorder = false;
    std::size_t _bucketsToReorder = 0;
    std::size_t _nextBucket = 0;
    BudgetControl _control;
    std::size_t _cellsWhenCoarsened = 0;
    /// A finer factor is tried without showing any of it before all of it is known to fit.
    enum class Trial : std::uint8_t { none, waiting, undoing } _trial = Trial::none;
    std::size_t _hostBytes = 0;
    std::optional<Rest> _rest;
    bool _rested = false; ///< the wanted front is the one built from nothing
    std::shared_ptr<WholeSurface> _whole;
    /// The operations were forgotten: until a whole surface is taken over, the wanted front is not
    /// what they would make of the shown one.
    bool _frontsApart = false;
    Requests _held;                ///< kept back
    int _heldBack = 0;             ///< updates in a row, until the wanted front was settled
    glm::dvec3 _jumpEye{0.0};      ///< where the viewer was when the jump began
    double _jumpReach = 0;         ///< within which the finest detail of the jump is of use [world]
    bool _beginsToMeasure = false; ///< errors of cells, as soon as no whole surface is under way
    SurfaceStats _stats;
    std::uint64_t _version = 0;
    ExtractionQueue _queue; ///< last: its workers stop before what they use goes
};

/// The cells that a diamond's split brings, and those that its merge brings.
std::vector<CellId> halvesOf(const hierarchy::LatticePoint& centre);
std::vector<CellId> wholesOf(const hierarchy::LatticePoint& centre);

/// Lets something large be taken apart by a worker.
template <typename T>
void Surface::Impl::discard(T thing)
{
    _jobs->submit([garbage = std::make_shared<T>(std::move(thing))]() mutable { garbage.reset(); });
}

} // namespace isofront::surface

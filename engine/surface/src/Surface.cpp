#include "isofront/surface/Surface.h"

#include "CellCache.h"
#include "ExtractionQueue.h"
#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/Assert.h>
#include <isofront/hierarchy/Refinement.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace isofront::surface {

namespace {

using Clock = std::chrono::steady_clock;
using hierarchy::Diamond;
using hierarchy::DiamondTetrahedra;
using hierarchy::LatticePoint;
using hierarchy::LatticePointHash;

/// Off-screen work waits for what can be seen.
constexpr double kOffScreen = 0.1;
/// Merging saves memory, which is worth more than off-screen detail and less than visible detail.
constexpr double kMergeUrgency = 0.5;
/// Requests whose urgency is looked at again in one update.
constexpr std::size_t kMostReordered = 1024;

/// What a diamond's split or merge brings to the shown front.
struct Operation {
    bool split = false;
    std::vector<CellId> cells;
    std::vector<CellMeshPointer> meshes; ///< as long as `cells`; null while missing
    std::size_t missing = 0;
    double urgency = 0;
};

std::vector<CellId> halvesOf(const LatticePoint& centre)
{
    std::vector<CellId> ids;
    const DiamondTetrahedra all = tetrahedraOf(Diamond(centre));
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const hierarchy::Tetrahedron& half : all.tetrahedron(i).bisected())
            ids.push_back(cellIdOf(half));
    return ids;
}

std::vector<CellId> wholesOf(const LatticePoint& centre)
{
    std::vector<CellId> ids;
    const DiamondTetrahedra all = tetrahedraOf(Diamond(centre));
    for (std::size_t i = 0; i < all.size(); ++i)
        ids.push_back({centre, all.index(i)});
    return ids;
}

/// Collects what a series of steps adds up to.
class DeltaBuilder {
public:
    void remove(const CellId& id)
    {
        if (_added.erase(id) == 0)
            _removed.push_back(id);
    }
    void add(const CellId& id, CellMeshPointer mesh) { _added[id] = std::move(mesh); }

    Delta build(std::uint64_t version)
    {
        Delta delta;
        delta.removed = std::move(_removed);
        delta.added.reserve(_added.size());
        for (auto& [id, mesh] : _added)
            delta.added.emplace_back(id, std::move(mesh));
        std::ranges::sort(delta.removed);
        std::ranges::sort(delta.added, {}, &ShownCell::id);
        delta.version = version;
        return delta;
    }
    [[nodiscard]] bool isEmpty() const { return _removed.empty() && _added.empty(); }

private:
    std::vector<CellId> _removed;
    std::unordered_map<CellId, CellMeshPointer, CellIdHash> _added;
};

} // namespace

class Surface::Impl {
public:
    Impl(
        std::shared_ptr<const fields::Field> field,
        const hierarchy::Domain& domain,
        const SurfaceOptions& options,
        std::shared_ptr<core::Jobs> jobs)
        : _options(options),
          _jobs(jobs ? std::move(jobs) : std::shared_ptr<core::Jobs>(core::makeJobs())),
          _extractor(std::make_shared<extractor::CellExtractor>(
              std::move(field), domain, withCornerRadius(options, domain))),
          _refinement(
              domain,
              std::make_shared<hierarchy::UniformCriterion>(0),
              {.maxLevel = options.maxLevel}),
          _cache(options.cacheBytes), _queue(_extractor, _jobs)
    {
        _rootMissing = wholesOf(hierarchy::kRootDiamond);
    }

    Delta update(const hierarchy::View& view, const UpdateBudget& budget)
    {
        // an hour is as good as no limit, and fits the clock; NaN is no time at all
        const double milliseconds =
            budget.milliseconds > 0 ? std::min(budget.milliseconds, 3.6e6) : 0.0;
        const auto deadline =
            Clock::now() + std::chrono::duration_cast<Clock::duration>(
                               std::chrono::duration<double, std::milli>(milliseconds));
        hierarchy::RefinementBudget work;
        work.deadline = deadline;
        if (!view.isValid()) {
            _refinement.update(view, work); // which counts it
            return {};
        }
        follow(view);
        const auto changes = _refinement.update(view, work);
        setView(view);

        // first what is there, so that it isn't asked for again
        DeltaBuilder delta;
        receive(delta);
        std::vector<ExtractionQueue::Request> requests;
        for (const CellId& id : _rootMissing)
            requests.push_back({id, std::numeric_limits<double>::max()});
        plan(changes, requests);
        reorder(requests);
        request(requests);
        receive(delta);
        commitReady(delta, deadline);
        return finish(delta);
    }

    Delta settle(
        const hierarchy::View& view,
        const std::function<void(double)>& progress,
        const std::stop_token& stop)
    {
        if (!view.isValid()) {
            _refinement.update(view);
            return {};
        }
        follow(view);
        // the background would do the same work again
        std::vector<CellId> underExtraction;
        for (const auto& [id, centre] : _owner)
            underExtraction.push_back(id);
        _queue.cancel(underExtraction);
        std::vector<ExtractionQueue::Request> requests;
        do
            plan(_refinement.update(view), requests);
        while (!_refinement.isSettled() && !stop.stop_requested());

        std::unordered_map<CellId, CellMeshPointer, CellIdHash> underWay;
        for (const auto& [centre, operation] : _operations)
            for (std::size_t i = 0; i < operation.cells.size(); ++i)
                if (operation.meshes[i])
                    underWay[operation.cells[i]] = operation.meshes[i];
        struct Job {
            CellId id;
            hierarchy::Tetrahedron cell;
            CellMeshPointer mesh;
        };
        std::vector<Job> work;
        std::unordered_set<CellId, CellIdHash> kept;
        _refinement.front().forEachCell([&](const CellId& id, const hierarchy::Tetrahedron& cell) {
            if (isShown(id))
                kept.insert(id);
            else if (const auto found = underWay.find(id); found != underWay.end())
                work.push_back({id, cell, found->second});
            else
                work.push_back({id, cell, _cache.take(id)});
        });
        std::ranges::sort(work, {}, &Job::id);

        // in slices, so that the calling thread can tell how far it is
        constexpr std::size_t kSlice = 256;
        for (std::size_t begin = 0; begin < work.size(); begin += kSlice) {
            if (stop.stop_requested()) {
                for (Job& job : work)
                    if (job.mesh)
                        _cache.insert(job.id, std::move(job.mesh));
                for (const auto& [id, centre] : _owner)
                    requests.push_back({id, _operations.at(centre).urgency});
                request(requests);
                return {};
            }
            if (progress)
                progress(double(begin) / double(work.size()));
            std::array<bool, kSlice> isNew{};
            const std::size_t size = std::min(kSlice, work.size() - begin);
            _jobs->parallelFor(size, [&](std::size_t i) {
                Job& job = work[begin + i];
                isNew[i] = job.mesh == nullptr;
                if (isNew[i])
                    job.mesh =
                        std::make_shared<const extractor::CellMesh>(*_extractor->extract(job.cell));
            });
            for (std::size_t i = 0; i < size; ++i)
                if (isNew[i])
                    count(*work[begin + i].mesh);
        }

        // what was under way leads somewhere else
        std::vector<CellId> stale;
        for (const auto& [id, centre] : _owner)
            stale.push_back(id);
        stale.insert(stale.end(), _rootMissing.begin(), _rootMissing.end());
        _queue.cancel(stale);
        _queue.takeFinished();
        for (auto& [centre, operation] : _operations)
            for (std::size_t i = 0; i < operation.cells.size(); ++i)
                if (operation.meshes[i] && !_refinement.front().hasCell(operation.cells[i]))
                    _cache.insert(operation.cells[i], std::move(operation.meshes[i]));
        _operations.clear();
        _owner.clear();
        _ready.clear();
        _rootMissing.clear();
        _rootMeshes.clear();

        DeltaBuilder delta;
        std::vector<CellId> leaving;
        _shown.forEachCell([&](const CellId& id, const hierarchy::Tetrahedron&) {
            if (_rootShown && !kept.contains(id))
                leaving.push_back(id);
        });
        for (const CellId& id : leaving)
            hide(id, delta);
        _shown = _refinement.front();
        for (Job& job : work)
            show(job.id, std::move(job.mesh), delta);
        _rootShown = true;
        setView(view);
        if (progress)
            progress(1.0);
        return finish(delta);
    }

    [[nodiscard]] bool isSettled() const
    {
        return _hasView && _refinement.isSettled() && _operations.empty() && _rootMissing.empty();
    }

    [[nodiscard]] SurfaceStats stats() const
    {
        SurfaceStats result = _stats;
        result.frontCells = _shown.cellCount();
        result.shownCells = _meshes.size();
        result.pendingCells = _queue.pending();
        result.cacheBytes = _cache.bytes();
        result.hierarchyBytes = _shown.bytes() + _refinement.front().bytes();
        result.refusedViews = _refinement.refusedViews();
        result.deltas = _version;
        return result;
    }

    [[nodiscard]] const hierarchy::Domain& domain() const { return _refinement.domain(); }

private:
    static extractor::ExtractionSettings
    withCornerRadius(const SurfaceOptions& options, const hierarchy::Domain& domain)
    {
        extractor::ExtractionSettings settings = options.extraction;
        if (settings.cornerRadius <= 0)
            settings.cornerRadius =
                2 * hierarchy::axisStep(options.maxLevel, settings.latticeSize) * domain.edge;
        return settings;
    }

    /// Takes over how fine the view's picture is.
    void follow(const hierarchy::View& view)
    {
        _hasView = true;
        if (view.pixelsPerUnit() == _pixelsPerUnit)
            return;
        _pixelsPerUnit = view.pixelsPerUnit();
        _criterion =
            viewCriterion(_extractor, _pixelsPerUnit, _options.pixelError, _criterion.get());
        _refinement.setCriterion(_criterion);
    }

    void setView(const hierarchy::View& view)
    {
        const auto isSame = [&](const hierarchy::View& a, const hierarchy::View& b) {
            return a.eye == b.eye && a.forward == b.forward &&
                   a.verticalFieldOfView == b.verticalFieldOfView && a.width == b.width &&
                   a.height == b.height;
        };
        if (!isSame(view, _view))
            _stillToReorder = true;
        _view = view;
    }

    /// Asks for those cells that are still waited for: what was planned may have been dropped.
    void request(std::vector<ExtractionQueue::Request>& requests)
    {
        std::erase_if(requests, [&](const ExtractionQueue::Request& wanted) {
            return !_owner.contains(wanted.id) &&
                   std::ranges::find(_rootMissing, wanted.id) == _rootMissing.end();
        });
        if (!requests.empty())
            _queue.request(requests);
    }

    /// Turns the steps of the wanted front into operations on the shown one. A split that is made
    /// only because others need it is as urgent as the most urgent of those.
    void plan(
        const std::vector<hierarchy::FrontChange>& changes,
        std::vector<ExtractionQueue::Request>& requests)
    {
        std::unordered_map<LatticePoint, double, LatticePointHash> needed;
        std::vector<double> urgency(changes.size());
        for (std::size_t i = changes.size(); i-- > 0;) {
            const auto& [diamond, split] = changes[i];
            urgency[i] = urgencyOf(diamond, split);
            if (!split)
                continue;
            if (const auto found = needed.find(diamond); found != needed.end())
                urgency[i] = std::max(urgency[i], found->second);
            for (const LatticePoint& parent : parentsOf(Diamond(diamond)))
                needed[parent] = std::max(needed[parent], urgency[i]);
        }
        for (std::size_t i = 0; i < changes.size(); ++i)
            plan(changes[i], urgency[i], requests);
    }

    /// Turns one step into an operation, or takes the opposite one back.
    void plan(
        const hierarchy::FrontChange& change,
        double urgency,
        std::vector<ExtractionQueue::Request>& requests)
    {
        if (const auto found = _operations.find(change.diamond); found != _operations.end()) {
            ISOFRONT_ASSERT(found->second.split != change.split, "the front changed twice alike");
            drop(found);
            return;
        }
        ISOFRONT_ASSERT(
            _shown.isSplit(change.diamond) != change.split, "the shown front is there already");
        Operation operation;
        operation.split = change.split;
        operation.cells = change.split ? halvesOf(change.diamond) : wholesOf(change.diamond);
        operation.meshes.resize(operation.cells.size());
        operation.urgency = urgency;
        for (std::size_t i = 0; i < operation.cells.size(); ++i) {
            operation.meshes[i] = _cache.take(operation.cells[i]);
            if (operation.meshes[i]) {
                ++_stats.cellsFromCache;
                continue;
            }
            ++operation.missing;
            _owner[operation.cells[i]] = change.diamond;
            requests.push_back({operation.cells[i], operation.urgency});
        }
        if (operation.missing == 0)
            _ready.push_back(change.diamond);
        _operations.emplace(change.diamond, std::move(operation));
    }

    void drop(std::unordered_map<LatticePoint, Operation, LatticePointHash>::iterator found)
    {
        Operation& operation = found->second;
        std::vector<CellId> cancelled;
        for (std::size_t i = 0; i < operation.cells.size(); ++i) {
            if (operation.meshes[i]) {
                _cache.insert(operation.cells[i], std::move(operation.meshes[i]));
                continue;
            }
            cancelled.push_back(operation.cells[i]);
            _owner.erase(operation.cells[i]);
        }
        _stats.cellsCancelled += cancelled.size();
        _queue.cancel(cancelled);
        _operations.erase(found);
    }

    [[nodiscard]] double urgencyOf(const LatticePoint& centre, bool split) const
    {
        // where there is nothing to see, a split is made for others' sake alone
        const double urgency = split ? std::max(_refinement.urgency(centre), 0.0) : kMergeUrgency;
        return isInView(Diamond(centre)) ? urgency : urgency * kOffScreen;
    }

    /// A cone around the view holds the frustum; a sphere around the diamond its cells.
    [[nodiscard]] bool isInView(const Diamond& diamond) const
    {
        const hierarchy::Domain& domain = _refinement.domain();
        const glm::dvec3 to =
            domain.worldFromField.point(domain.fieldFromLattice(diamond.centre)) - _view.eye;
        const double distance = glm::length(to);
        const double radius =
            diamond.radius() * domain.latticeUnit() * domain.worldFromField.stretch();
        if (distance <= radius)
            return true;
        const double tangent = std::tan(0.5 * _view.verticalFieldOfView);
        const double aspect = double(_view.width) / _view.height;
        const double cone = std::atan(tangent * std::hypot(1.0, aspect));
        const double angle = std::acos(
            std::clamp(glm::dot(to, glm::normalize(_view.forward)) / distance, -1.0, 1.0));
        return angle - std::asin(radius / distance) <= cone;
    }

    /// Looks again at how urgent the operations under way are, some of them in each update.
    void reorder(std::vector<ExtractionQueue::Request>& requests)
    {
        if (_stillToReorder) {
            _bucketsToReorder = _operations.bucket_count();
            _stillToReorder = false;
        }
        std::size_t looked = 0;
        const std::size_t buckets = _operations.bucket_count();
        for (; _bucketsToReorder > 0 && looked < kMostReordered; --_bucketsToReorder) {
            _nextBucket = (_nextBucket + 1) % buckets;
            for (auto it = _operations.begin(_nextBucket); it != _operations.end(_nextBucket);
                 ++it) {
                Operation& operation = it->second;
                ++looked;
                const double urgency = urgencyOf(it->first, operation.split);
                if (operation.missing == 0 || urgency <= 0 ||
                    std::abs(urgency - operation.urgency) < 0.1 * operation.urgency)
                    continue;
                operation.urgency = urgency;
                for (std::size_t i = 0; i < operation.cells.size(); ++i)
                    if (!operation.meshes[i])
                        requests.push_back({operation.cells[i], urgency});
            }
        }
    }

    void receive(DeltaBuilder& delta)
    {
        for (ExtractionQueue::Finished& finished : _queue.takeFinished()) {
            count(*finished.mesh);
            if (const auto root = std::ranges::find(_rootMissing, finished.id);
                root != _rootMissing.end()) {
                _rootMissing.erase(root);
                _rootMeshes.push_back(std::move(finished));
                if (_rootMissing.empty()) {
                    for (ExtractionQueue::Finished& first : _rootMeshes)
                        show(first.id, std::move(first.mesh), delta);
                    _rootMeshes.clear();
                    _rootShown = true;
                    retryAll();
                }
                continue;
            }
            const auto owner = _owner.find(finished.id);
            if (owner == _owner.end()) {
                // taken back just as it was done: somebody may come back for it
                _cache.insert(finished.id, std::move(finished.mesh));
                continue;
            }
            Operation& operation = _operations.at(owner->second);
            const auto at = std::ranges::find(operation.cells, finished.id);
            operation.meshes[static_cast<std::size_t>(at - operation.cells.begin())] =
                std::move(finished.mesh);
            if (--operation.missing == 0)
                _ready.push_back(owner->second);
            _owner.erase(owner);
        }
    }

    void retryAll()
    {
        for (const auto& [centre, operation] : _operations)
            if (operation.missing == 0)
                _ready.push_back(centre);
    }

    void commitReady(DeltaBuilder& delta, Clock::time_point deadline)
    {
        if (!_rootShown)
            return;
        // a few steps in any case, or a slow machine would never get anywhere
        std::size_t commits = 0;
        while (!_ready.empty() && (commits % 8 != 7 || Clock::now() < deadline)) {
            const LatticePoint centre = _ready.back();
            _ready.pop_back();
            const auto found = _operations.find(centre);
            if (found == _operations.end() || found->second.missing != 0)
                continue;
            // An operation that must wait for a parent or a child comes up again with it.
            const bool split = found->second.split;
            if (split ? !_shown.isComplete(centre) : !_shown.isMergeable(centre))
                continue;
            ++commits;
            Operation operation = std::move(found->second);
            _operations.erase(found);
            for (const CellId& id : split ? wholesOf(centre) : halvesOf(centre))
                hide(id, delta);
            if (split)
                _shown.split(centre);
            else
                _shown.merge(centre);
            for (std::size_t i = 0; i < operation.cells.size(); ++i)
                show(operation.cells[i], std::move(operation.meshes[i]), delta);
            for (const LatticePoint& next :
                 split ? childrenOf(Diamond(centre)) : parentsOf(Diamond(centre)))
                if (_operations.contains(next))
                    _ready.push_back(next);
        }
    }

    [[nodiscard]] bool isShown(const CellId& id) const { return _rootShown && _shown.hasCell(id); }

    void show(const CellId& id, CellMeshPointer mesh, DeltaBuilder& delta)
    {
        if (mesh->indices.empty())
            return;
        _stats.triangles += mesh->triangleCount();
        _stats.meshBytes += mesh->bytes();
        delta.add(id, mesh);
        _meshes[id] = std::move(mesh);
    }

    void hide(const CellId& id, DeltaBuilder& delta)
    {
        static const auto kEmpty = std::make_shared<const extractor::CellMesh>();
        const auto found = _meshes.find(id);
        if (found == _meshes.end()) {
            _cache.insert(id, kEmpty);
            return;
        }
        _stats.triangles -= found->second->triangleCount();
        _stats.meshBytes -= found->second->bytes();
        delta.remove(id);
        _cache.insert(id, std::move(found->second));
        _meshes.erase(found);
    }

    void count(const extractor::CellMesh& mesh)
    {
        if (mesh.stats.provedEmpty)
            ++_stats.cellsSkipped;
        else
            ++_stats.cellsExtracted;
        _stats.samples += mesh.stats.samples;
        _stats.sanitisedSamples += mesh.stats.sanitisedSamples;
    }

    Delta finish(DeltaBuilder& delta)
    {
        if (delta.isEmpty())
            return {};
        return delta.build(++_version);
    }

    SurfaceOptions _options;
    std::shared_ptr<core::Jobs> _jobs;
    std::shared_ptr<const extractor::CellExtractor> _extractor;
    hierarchy::Refinement _refinement; ///< holds the wanted front
    hierarchy::Front _shown;
    std::unordered_map<CellId, CellMeshPointer, CellIdHash> _meshes; ///< shown, with triangles
    CellCache _cache;
    std::unordered_map<LatticePoint, Operation, LatticePointHash> _operations;
    std::unordered_map<CellId, LatticePoint, CellIdHash> _owner; ///< of cells asked for
    std::vector<LatticePoint> _ready;
    std::vector<CellId> _rootMissing;
    std::vector<ExtractionQueue::Finished> _rootMeshes;
    bool _rootShown = false;
    hierarchy::View _view;
    bool _hasView = false;
    double _pixelsPerUnit = 0;
    std::shared_ptr<const WhereSurface> _criterion; ///< of the view's resolution
    bool _stillToReorder = false;
    std::size_t _bucketsToReorder = 0;
    std::size_t _nextBucket = 0;
    SurfaceStats _stats;
    std::uint64_t _version = 0;
    ExtractionQueue _queue; ///< last: its workers stop before what they use goes
};

Surface::Surface(
    std::shared_ptr<const fields::Field> field,
    hierarchy::Domain domain,
    SurfaceOptions options,
    std::shared_ptr<core::Jobs> jobs)
    : _impl(std::make_unique<Impl>(std::move(field), domain, options, std::move(jobs)))
{
}

Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;
Surface::~Surface() = default;

Delta Surface::update(const hierarchy::View& view, const UpdateBudget& budget)
{
    return _impl->update(view, budget);
}

Delta Surface::settle(
    const hierarchy::View& view,
    const std::function<void(double)>& progress,
    const std::stop_token& stop)
{
    return _impl->settle(view, progress, stop);
}

bool Surface::isSettled() const
{
    return _impl->isSettled();
}

SurfaceStats Surface::stats() const
{
    return _impl->stats();
}

const hierarchy::Domain& Surface::domain() const
{
    return _impl->domain();
}

} // namespace isofront::surface

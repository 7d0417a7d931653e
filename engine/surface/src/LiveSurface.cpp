#include "LiveSurface.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isofront::surface {

using hierarchy::Diamond;
using hierarchy::DiamondTetrahedra;

namespace {

/// Off-screen work waits for what can be seen.
constexpr double kOffScreen = 0.1;
/// Merging saves memory, which is worth more than off-screen detail and less than visible detail.
constexpr double kMergeUrgency = 0.5;
/// What is wanted wherever the viewer is comes after the root and before all else.
constexpr double kMostUrgent = 1e12;
/// Requests whose urgency is looked at again in one update.
constexpr std::size_t kMostReordered = 1024;
/// The work that is done between two looks at the clock: steps of the wanted front, cells received
/// and cells handed to the cache.
constexpr std::size_t kSlice = 32;

} // namespace

std::vector<CellId> halvesOf(const hierarchy::LatticePoint& centre)
{
    std::vector<CellId> ids;
    const DiamondTetrahedra all = tetrahedraOf(Diamond(centre));
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const hierarchy::Tetrahedron& half : all.tetrahedron(i).bisected())
            ids.push_back(cellIdOf(half));
    return ids;
}

std::vector<CellId> wholesOf(const hierarchy::LatticePoint& centre)
{
    std::vector<CellId> ids;
    const DiamondTetrahedra all = tetrahedraOf(Diamond(centre));
    for (std::size_t i = 0; i < all.size(); ++i)
        ids.push_back({centre, all.index(i)});
    return ids;
}

Surface::Impl::Impl(
    std::shared_ptr<const fields::Field> field,
    const hierarchy::Domain& domain,
    const SurfaceOptions& options,
    std::shared_ptr<core::Jobs> jobs)
    : _options(options),
      _jobs(jobs ? std::move(jobs) : std::shared_ptr<core::Jobs>(core::makeJobs())),
      _field(std::move(field)), _domain(domain),
      _extractor(extractorFor(options.extraction.isovalue)),
      _refinement(
          domain,
          std::make_shared<hierarchy::UniformCriterion>(0),
          {.maxLevel = options.maxLevel, .offScreen = options.detail.offScreen}),
      _isovalue(options.extraction.isovalue), _shownIsovalue(_isovalue), _cache(options.cacheBytes),
      _queue(_extractor, _jobs, options.shared)
{
    _rootMissing = wholesOf(hierarchy::kRootDiamond);
}

Surface::Impl::~Impl()
{
    if (_whole) {
        _whole->abort();
        _whole->wait();
    }
}

Delta Surface::Impl::update(const hierarchy::View& view, const UpdateBudget& budget)
{
    // an hour is as good as no limit, and fits the clock; NaN is no time at all
    const double milliseconds =
        budget.milliseconds > 0 ? std::min(budget.milliseconds, 3.6e6) : 0.0;
    const auto start = Clock::now();
    const auto after = [&](double share) {
        return start + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double, std::milli>(share * milliseconds));
    };
    if (!view.isValid()) {
        ++_stats.refusedViews;
        return {};
    }
    follow(view);
    _hostBytes = budget.hostBytes;
    if (std::optional<Delta> changed = change())
        return *std::move(changed);
    retireSome(after(0.2));

    // first what is there, so that it isn't asked for again
    DeltaBuilder delta;
    receive(delta, after(0.4));
    Requests requests;
    for (const CellId& id : _rootMissing)
        requests.push_back({id, std::numeric_limits<double>::max()});
    refine(requests, after(0.7));
    rest(requests, after(0.7));
    reorder(requests);
    request(requests);
    receive(delta, after(0.8));
    commitReady(delta, after(1.0));
    watchCeilings();
    Delta result = finish(delta);
    if (isJumping() && _refinement.isSettled())
        startJump();
    return result;
}

void Surface::Impl::setIsovalue(double isovalue)
{
    if (!std::isfinite(isovalue)) {
        ++_stats.refusedIsovalues;
        return;
    }
    _isovalue = isovalue;
    if (_whole && _whole->isovalue() != isovalue)
        _whole->abort();
}

void Surface::Impl::setDetail(double pixelError, DetailSettings detail)
{
    ISOFRONT_ASSERT(pixelError > 0, "no error at all can't be reached");
    const double offScreen = detail.offScreen;
    if (detail.measuredLevels > 0 && _options.detail.measuredLevels <= 0) {
        _beginsToMeasure = true;
        if (_whole)
            _whole->abort();
    }
    _options.pixelError = pixelError;
    _options.detail = std::move(detail);
    _refinement.setOffScreen(offScreen);
    _control.forget();
    if (_hasView)
        renewCriterion();
}

/// What has been extracted doesn't tell its error, nor which cells were proved empty.
void Surface::Impl::beginMeasuring()
{
    _beginsToMeasure = false;
    if (_whole)
        discard(std::exchange(_whole, nullptr));
    _extractor = extractorFor(_isovalue);
    _queue.restart(_extractor);
    _arrived.clear();
    discard(std::exchange(_cache, CellCache(_options.cacheBytes)));
    discard(std::exchange(_retired, {}));
    _retiredBytes = 0;
    _errors = std::make_shared<MeasuredErrors>();
    Requests requests;
    for (const auto& [id, centre] : _owner)
        requests.push_back({id, _operations.at(centre).urgency});
    request(requests);
    if (_hasView)
        renewCriterion();
}

bool Surface::Impl::isLiveSettled() const
{
    return _hasView && !_whole && _isovalue == _shownIsovalue && _refinement.isSettled() &&
           _operations.empty() && _rootMissing.empty();
}

bool Surface::Impl::isSettled() const
{
    return isLiveSettled() && _rested && !_control.mayRefine();
}

SurfaceStats Surface::Impl::stats() const
{
    SurfaceStats result = _stats;
    result.frontCells = _shown.cellCount();
    result.shownCells = _meshes.size();
    result.pendingCells = _queue.pending() + (_whole ? _whole->pending() : 0);
    result.cacheBytes = _cache.bytes();
    result.hierarchyBytes =
        _shown.bytes() + _refinement.bytes() + _bounds->bytes() + _errors->bytes();
    result.totalBytes = bytesInUse();
    result.effectivePixelError = _options.pixelError * _control.factor();
    result.deltas = _version;
    return result;
}

std::shared_ptr<const extractor::CellExtractor> Surface::Impl::extractorFor(double isovalue) const
{
    extractor::ExtractionSettings settings = _options.extraction;
    settings.isovalue = isovalue;
    settings.estimateError = settings.estimateError || _options.detail.measuredLevels > 0;
    if (settings.cornerRadius <= 0)
        settings.cornerRadius =
            2 * hierarchy::axisStep(_options.maxLevel, settings.latticeSize) * _domain.edge;
    return std::make_shared<extractor::CellExtractor>(_field, _domain, settings);
}

hierarchy::RefinementSettings Surface::Impl::refinementSettings() const
{
    hierarchy::RefinementSettings settings;
    settings.maxLevel = _options.maxLevel;
    settings.offScreen = _options.detail.offScreen;
    // under a ceiling the front must be no larger than it has to be
    if (_control.isActive())
        settings.hysteresis = 1;
    return settings;
}

/// Takes over where the viewer looks from and how fine the picture is.
void Surface::Impl::follow(const hierarchy::View& view)
{
    const auto isSame = [](const hierarchy::View& a, const hierarchy::View& b) {
        return a.eye == b.eye && a.forward == b.forward &&
               a.verticalFieldOfView == b.verticalFieldOfView && a.width == b.width &&
               a.height == b.height;
    };
    _viewStays = _hasView && isSame(view, _view);
    if (!_viewStays) {
        _stillToReorder = true;
        _trial = Trial::none;
        _control.forget();
        stopResting();
    }
    _view = view;
    _hasView = true;
    if (view.pixelsPerUnit() == _pixelsPerUnit)
        return;
    _pixelsPerUnit = view.pixelsPerUnit();
    renewCriterion();
}

void Surface::Impl::renewCriterion()
{
    _criterion = viewCriterion(
        _extractor,
        _pixelsPerUnit,
        _options.pixelError,
        _options.detail,
        _bounds,
        _errors,
        _control.factor(),
        _options.maxLevel);
    _refinement.setHysteresis(refinementSettings().hysteresis);
    _refinement.setCriterion(_criterion);
    stopResting();
}

void Surface::Impl::refine(Requests& requests, Clock::time_point deadline)
{
    do {
        plan(
            _refinement.update(
                _view, {.tests = 8 * kSlice, .operations = kSlice, .deadline = deadline}),
            requests);
        watchCells();
    } while (!_refinement.isSettled() && Clock::now() < deadline);
}

/// Asks for those cells that are still waited for: what was planned may have been dropped.
void Surface::Impl::request(Requests& requests)
{
    if (holdsBack(requests))
        return;
    std::erase_if(requests, [&](const ExtractionQueue::Request& wanted) {
        return !_owner.contains(wanted.id) && !(_rest && _rest->measured.contains(wanted.id)) &&
               std::ranges::find(_rootMissing, wanted.id) == _rootMissing.end();
    });
    if (!requests.empty())
        _queue.request(requests);
}

/// Turns the steps of the wanted front into operations on the shown one. A split that is made only
/// because others need it is as urgent as the most urgent of those.
void Surface::Impl::plan(const std::vector<hierarchy::FrontChange>& changes, Requests& requests)
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
void Surface::Impl::plan(const hierarchy::FrontChange& change, double urgency, Requests& requests)
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
        operation.meshes[i] = fromCache(operation.cells[i]);
        if (operation.meshes[i]) {
            _flightBytes += operation.meshes[i]->bytes();
            continue;
        }
        ++operation.missing;
        _owner[operation.cells[i]] = change.diamond;
        requests.push_back({operation.cells[i], operation.urgency});
    }
    if (operation.missing == 0)
        _ready.push_back(change.diamond);
    _merges += operation.split ? 0U : 1U;
    for (const LatticePoint& before :
         operation.split ? parentsOf(Diamond(change.diamond)) : childrenOf(Diamond(change.diamond)))
        if (const auto found = _operations.find(before);
            found != _operations.end() && found->second.split == operation.split)
            operation.waits = true;
    _waiting += operation.waits ? 1U : 0U;
    _operations.emplace(change.diamond, std::move(operation));
}

void Surface::Impl::drop(Operations::iterator found)
{
    Operation& operation = found->second;
    std::vector<CellId> cancelled;
    for (std::size_t i = 0; i < operation.cells.size(); ++i) {
        if (operation.meshes[i]) {
            _flightBytes -= operation.meshes[i]->bytes();
            keep(operation.cells[i], std::move(operation.meshes[i]));
            continue;
        }
        cancelled.push_back(operation.cells[i]);
        _owner.erase(operation.cells[i]);
    }
    _stats.cellsCancelled += cancelled.size();
    _merges -= operation.split ? 0U : 1U;
    _waiting -= operation.waits ? 1U : 0U;
    _queue.cancel(cancelled);
    _operations.erase(found);
}

double Surface::Impl::urgencyOf(const LatticePoint& centre, bool split) const
{
    // where there is nothing to see, a split is made for others' sake alone
    const double urgency =
        split ? std::clamp(_refinement.urgency(centre), 0.0, kMostUrgent) : kMergeUrgency;
    return isInView(Diamond(centre)) ? urgency : urgency * kOffScreen;
}

/// A cone around the view holds the frustum; a sphere around the diamond its cells.
bool Surface::Impl::isInView(const Diamond& diamond) const
{
    const glm::dvec3 to =
        _domain.worldFromField.point(_domain.fieldFromLattice(diamond.centre)) - _view.eye;
    const double distance = glm::length(to);
    const double radius =
        diamond.radius() * _domain.latticeUnit() * _domain.worldFromField.stretch();
    if (distance <= radius)
        return true;
    const double tangent = std::tan(0.5 * _view.verticalFieldOfView);
    const double aspect = double(_view.width) / _view.height;
    const double cone = std::atan(tangent * std::hypot(1.0, aspect));
    const double angle =
        std::acos(std::clamp(glm::dot(to, glm::normalize(_view.forward)) / distance, -1.0, 1.0));
    return angle - std::asin(radius / distance) <= cone;
}

/// Looks again at how urgent the operations under way are, some of them in each update.
void Surface::Impl::reorder(Requests& requests)
{
    if (_stillToReorder) {
        _bucketsToReorder = _operations.bucket_count();
        _stillToReorder = false;
    }
    std::size_t looked = 0;
    const std::size_t buckets = _operations.bucket_count();
    for (; _bucketsToReorder > 0 && looked < kMostReordered; --_bucketsToReorder) {
        _nextBucket = (_nextBucket + 1) % buckets;
        for (auto it = _operations.begin(_nextBucket); it != _operations.end(_nextBucket); ++it) {
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

void Surface::Impl::receive(DeltaBuilder& delta, Clock::time_point deadline)
{
    if (_arrived.empty())
        _arrived = _queue.takeFinished();
    for (std::size_t received = 0; !_arrived.empty(); ++received) {
        if (received % kSlice == kSlice - 1 && Clock::now() > deadline)
            return;
        ExtractionQueue::Finished finished = std::move(_arrived.back());
        _arrived.pop_back();
        count(*finished.mesh);
        measure(finished.id, *finished.mesh);
        if (_rest)
            _rest->measured.erase(finished.id);
        if (std::ranges::find(_rootMissing, finished.id) != _rootMissing.end()) {
            receiveRoot(std::move(finished), delta);
            continue;
        }
        const auto owner = _owner.find(finished.id);
        if (owner == _owner.end()) {
            // taken back just as it was done, or wanted for its error only: it may be of use yet
            keep(finished.id, std::move(finished.mesh));
            continue;
        }
        Operation& operation = _operations.at(owner->second);
        const auto at = std::ranges::find(operation.cells, finished.id);
        _flightBytes += finished.mesh->bytes();
        operation.meshes[static_cast<std::size_t>(at - operation.cells.begin())] =
            std::move(finished.mesh);
        if (--operation.missing == 0)
            _ready.push_back(owner->second);
        _owner.erase(owner);
    }
}

void Surface::Impl::receiveRoot(ExtractionQueue::Finished finished, DeltaBuilder& delta)
{
    std::erase(_rootMissing, finished.id);
    _rootMeshes.push_back(std::move(finished));
    if (!_rootMissing.empty())
        return;
    delta.begin(hierarchy::kRootDiamond);
    for (ExtractionQueue::Finished& first : _rootMeshes)
        show(first.id, std::move(first.mesh), delta);
    _rootMeshes.clear();
    _rootShown = true;
    for (const auto& [centre, operation] : _operations)
        if (operation.missing == 0)
            _ready.push_back(centre);
}

void Surface::Impl::commitReady(DeltaBuilder& delta, Clock::time_point deadline)
{
    if (!_rootShown)
        return;
    if (_trial != Trial::none) {
        judgeTrial();
        if (_trial != Trial::none)
            return;
    }
    _ready.insert(_ready.end(), _blocked.begin(), _blocked.end());
    _blocked.clear();
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
        if (split && !hasRoomFor(centre, found->second)) {
            _blocked.push_back(centre);
            continue;
        }
        ++commits;
        Operation operation = std::move(found->second);
        _operations.erase(found);
        commit(centre, std::move(operation), delta);
    }
}

void Surface::Impl::commit(const LatticePoint& centre, Operation operation, DeltaBuilder& delta)
{
    delta.begin(centre);
    for (const CellId& id : operation.split ? wholesOf(centre) : halvesOf(centre))
        hide(id, delta);
    if (operation.split)
        _shown.split(centre);
    else
        _shown.merge(centre);
    for (std::size_t i = 0; i < operation.cells.size(); ++i) {
        _flightBytes -= operation.meshes[i]->bytes();
        show(operation.cells[i], std::move(operation.meshes[i]), delta);
    }
    _merges -= operation.split ? 0U : 1U;
    _waiting -= operation.waits ? 1U : 0U;
    for (const LatticePoint& next :
         operation.split ? childrenOf(Diamond(centre)) : parentsOf(Diamond(centre)))
        if (_operations.contains(next))
            _ready.push_back(next);
}

bool Surface::Impl::isShown(const CellId& id) const
{
    return _rootShown && _shown.hasCell(id);
}

void Surface::Impl::show(const CellId& id, CellMeshPointer mesh, DeltaBuilder& delta)
{
    if (mesh->indices.empty()) {
        delta.add(id, nullptr);
        return;
    }
    _stats.triangles += mesh->triangleCount();
    _stats.meshBytes += mesh->bytes();
    delta.add(id, mesh);
    _meshes[id] = std::move(mesh);
}

void Surface::Impl::hide(const CellId& id, DeltaBuilder& delta)
{
    const auto found = _meshes.find(id);
    if (found == _meshes.end()) {
        delta.remove(id, nullptr);
        // where errors count, it must be known whether it was proved
        if (_options.detail.measuredLevels <= 0)
            keep(id, meshOfEmptyCell(false));
        else if (_errors->isKnown(id))
            keep(id, meshOfEmptyCell(_errors->isProvedEmpty(id)));
        return;
    }
    _stats.triangles -= found->second->triangleCount();
    _stats.meshBytes -= found->second->bytes();
    delta.remove(id, found->second);
    keep(id, std::move(found->second));
    _meshes.erase(found);
}

void Surface::Impl::keep(const CellId& id, CellMeshPointer mesh)
{
    _cache.insert({id, _shownIsovalue}, std::move(mesh));
}

CellMeshPointer Surface::Impl::fromCache(const CellId& id)
{
    CellMeshPointer mesh = _cache.take({id, _shownIsovalue});
    if (!mesh)
        return nullptr;
    ++_stats.cellsFromCache;
    if (!_errors->isKnown(id))
        measure(id, *mesh);
    return mesh;
}

void Surface::Impl::measure(const CellId& id, const extractor::CellMesh& mesh)
{
    if (_options.detail.measuredLevels <= 0)
        return;
    _errors->record(id, mesh, _domain.worldFromField.stretch());
    _refinement.lookAgain(id.spine);
    if (_rest)
        _rest->refinement.lookAgain(id.spine);
}

void Surface::Impl::count(const extractor::CellMesh& mesh)
{
    if (mesh.stats.provedEmpty)
        ++_stats.cellsSkipped;
    else
        ++_stats.cellsExtracted;
    _stats.samples += mesh.stats.samples;
    _stats.sanitisedSamples += mesh.stats.sanitisedSamples;
}

void Surface::Impl::count(const WholeSurface::Result& result)
{
    _stats.triangles = result.triangles;
    _stats.meshBytes = result.meshBytes;
    _stats.cellsExtracted += result.cellsExtracted;
    _stats.cellsSkipped += result.cellsSkipped;
    _stats.cellsFromCache += result.cellsFromCache;
    _stats.samples += result.samples;
    _stats.sanitisedSamples += result.sanitisedSamples;
}

/// Keeps what a change of the isovalue has left.
void Surface::Impl::retire(FormerMeshes former)
{
    _retiredBytes += former.bytes();
    _retired.push_back(std::move(former));
    boundRetired();
}

/// Like the cache, what is on its way there gives way to all else, the oldest first. It would pile
/// up where isovalues follow each other so fast that there is no time to put it away.
void Surface::Impl::boundRetired()
{
    const std::size_t room = _options.maxBytes - std::min(bytesNeeded(), _options.maxBytes);
    while (!_retired.empty() && _retiredBytes > std::min(_options.cacheBytes, room)) {
        _retiredBytes -= _retired.front().bytes();
        discard(std::move(_retired.front()));
        _retired.pop_front();
    }
}

/// Hands some of it to the cache.
void Surface::Impl::retireSome(Clock::time_point deadline)
{
    for (std::size_t moved = 0; !_retired.empty(); ++moved) {
        if (moved % kSlice == kSlice - 1 && Clock::now() > deadline)
            return;
        FormerMeshes& former = _retired.front();
        _retiredBytes -= former.bytes();
        if (former.isDone()) {
            _retired.pop_front();
            continue;
        }
        former.moveOneTo(_cache);
        _retiredBytes += former.bytes();
    }
}

Delta Surface::Impl::finish(DeltaBuilder& delta)
{
    Delta result = delta.build(_version + 1, _shownIsovalue);
    if (result.isEmpty())
        return {};
    ++_version;
    return result;
}

} // namespace isofront::surface

#include "LiveSurface.h"

#include <isofront/core/Powers.h>

#include <algorithm>
#include <utility>

namespace isofront::surface {

/// Goes on with a change of the isovalue. A delta, perhaps an empty one, if that is all there is to
/// do now; nothing if everything else goes its way.
std::optional<Delta> Surface::Impl::change()
{
    if (_whole && !_whole->isQuiet()) {
        if (_whole->hasTarget() && jumpsElsewhere())
            _whole->abort();
        return Delta{};
    }
    if (_beginsToMeasure)
        beginMeasuring();
    if (_whole) {
        std::shared_ptr<WholeSurface> whole = std::exchange(_whole, nullptr);
        const bool isAborted = whole->isAborted();
        const int levels = levelsTooFine(*whole);
        if (!isAborted && levels == 0) {
            Delta delta = whole->hasTarget() ? takeOverJump(*whole) : takeOver(*whole);
            discard(std::move(whole));
            return delta;
        }
        const int coarser = whole->coarser() + levels;
        giveUp(std::move(whole));
        if (!isAborted) {
            startWhole(coarser);
            return _whole->isQuiet() ? change() : Delta{};
        }
    }
    if (_isovalue == _shownIsovalue && !_frontsApart)
        return std::nullopt;
    forgetWork();
    _extractor = extractorFor(_isovalue);
    _queue.restart(_extractor);
    if (!_rootShown) {
        // nothing is on show that would have to wait
        _shownIsovalue = _isovalue;
        _errors = std::make_shared<MeasuredErrors>();
        _rootMissing = wholesOf(hierarchy::kRootDiamond);
        _rootMeshes.clear();
        _refinement = hierarchy::Refinement(_domain, _criterion, refinementSettings());
        renewCriterion();
        _frontsApart = false;
        return std::nullopt;
    }
    startWhole(firstCoarser());
    // jobs that run at once are done by now
    return _whole->isQuiet() ? change() : Delta{};
}

/// Keeps what there is of it, whether it was ended early or can't be shown.
void Surface::Impl::giveUp(std::shared_ptr<WholeSurface> whole)
{
    WholeSurface::Result& result = whole->result();
    retire(
        {std::move(result.meshes), std::move(result.empty), result.meshBytes, whole->isovalue()});
    discard(std::move(whole));
}

/// The levels by which a change of the isovalue begins coarser.
int Surface::Impl::firstCoarser() const
{
    if (_isovalue == _shownIsovalue)
        return 0;
    // For a while the old mesh and the new one are there together: under a ceiling there must be
    // room for both. A level has 2^(2/3) times the triangles of the one above.
    int coarser = _options.coarseFirst;
    const double room = static_cast<double>(_options.maxBytes) - static_cast<double>(bytesNeeded());
    const double bytes = static_cast<double>(_stats.meshBytes);
    while (coarser < _options.maxLevel && bytes * core::twoToThirds(-2 * coarser) > room)
        ++coarser;
    return coarser;
}

/// By how many levels a surface of another isovalue must be coarser to stay below the ceilings,
/// about; 0 if it does, or if there is nothing coarser.
int Surface::Impl::levelsTooFine(const WholeSurface& whole) const
{
    if (whole.coarser() >= _options.maxLevel || whole.isovalue() == _shownIsovalue)
        return 0;
    const std::size_t room = _options.maxBytes - std::min(bytesNeeded(), _options.maxBytes);
    const auto share = [](std::size_t used, std::size_t most) {
        return static_cast<double>(used) / std::max(1.0, static_cast<double>(most));
    };
    const double most = std::max(
        share(whole.result().triangles, _options.maxTriangles),
        share(whole.result().meshBytes, room));
    int levels = 0;
    while (levels < _options.maxLevel && core::twoToThirds(2 * levels) < most)
        ++levels;
    return levels;
}

void Surface::Impl::startWhole(int coarser, const hierarchy::Front* target)
{
    WholeSurface::Sources sources;
    sources.extractor = _extractor;
    sources.shared = _options.shared;
    sources.shown = &_shown;
    sources.meshes = &_meshes;
    sources.sameIsovalue = _isovalue == _shownIsovalue;
    sources.cache = &_cache;
    sources.bounds = _bounds.get();
    sources.coarser = coarser;
    sources.target = target;
    for (const FormerMeshes& former : _retired)
        if (former.isovalue() == _isovalue)
            sources.former.push_back(&former);
    sources.shownExtractor = extractorFor(_shownIsovalue);
    if (_options.detail.measuredLevels > 0)
        sources.shownErrors = _errors.get();
    _whole = std::make_shared<WholeSurface>(std::move(sources), *_jobs);
    _whole->start();
}

Delta Surface::Impl::takeOver(WholeSurface& whole)
{
    WholeSurface::Result& result = whole.result();
    if (!result.delta.isEmpty())
        result.delta.version = ++_version;
    std::optional<FormerMeshes> former;
    if (_isovalue != _shownIsovalue) {
        former.emplace(
            std::move(_meshes), std::move(result.shownEmpty), _stats.meshBytes, _shownIsovalue);
        _errors = std::move(result.errors);
    } else {
        discard(std::move(_meshes));
    }
    _meshes = std::move(result.meshes);
    discard(std::exchange(_shown, std::move(result.shown)));
    _shownIsovalue = _isovalue;
    count(result);

    // Where the surface is now, the front goes on from what is shown.
    discard(std::exchange(
        _refinement,
        hierarchy::Refinement(
            _domain, _criterion, refinementSettings(), std::move(result.wanted))));
    _frontsApart = false;
    _control.forget();
    renewCriterion();
    if (former)
        retire(*std::move(former));
    return std::move(result.delta);
}

/// Gives up all operations: they were steps between meshes of an isovalue that has gone.
void Surface::Impl::forgetWork()
{
    _frontsApart = true;
    stopResting();
    _stats.cellsCancelled += _owner.size();
    discard(std::exchange(_operations, {}));
    discard(std::exchange(_owner, {}));
    _arrived.clear();
    _held.clear();
    _ready.clear();
    _blocked.clear();
    _merges = 0;
    _waiting = 0;
    _flightBytes = 0;
    _trial = Trial::none;
}

} // namespace isofront::surface

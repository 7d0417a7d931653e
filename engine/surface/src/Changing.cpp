#include "LiveSurface.h"

#include <isofront/core/Powers.h>

#include <algorithm>
#include <utility>

namespace isofront::surface {

/// Goes on with a change of the isovalue. A delta, perhaps an empty one, if that is all there is to
/// do now; nothing if everything else goes its way.
std::optional<Delta> Surface::Impl::change()
{
    if (_whole) {
        if (!_whole->isQuiet())
            return Delta{};
        const std::shared_ptr<WholeSurface> whole = std::exchange(_whole, nullptr);
        if (!whole->isAborted())
            return takeOver(*whole);
    }
    if (_isovalue == _shownIsovalue && _extractor->settings().isovalue == _isovalue)
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
        return std::nullopt;
    }
    startWhole();
    if (!_whole->isQuiet())
        return Delta{};
    // done on this very thread
    return takeOver(*std::exchange(_whole, nullptr));
}

void Surface::Impl::startWhole()
{
    WholeSurface::Sources sources;
    sources.extractor = _extractor;
    sources.shown = &_shown;
    sources.meshes = &_meshes;
    sources.sameIsovalue = _isovalue == _shownIsovalue;
    sources.cache = &_cache;
    sources.bounds = _bounds.get();
    if (!sources.sameIsovalue) {
        sources.coarser = _options.coarseFirst;
        // For a while the old mesh and the new one are there together: under a ceiling there must
        // be room for both. A level has 2^(2/3) times the triangles of the one above.
        const double room = static_cast<double>(_options.maxBytes) -
                            static_cast<double>(bytesInUse() - _cache.bytes());
        const double bytes = static_cast<double>(_stats.meshBytes);
        while (sources.coarser < _options.maxLevel &&
               bytes * core::twoToThirds(-2 * sources.coarser) > room)
            ++sources.coarser;
    }
    _whole = std::make_shared<WholeSurface>(std::move(sources), _jobs);
    _whole->start();
}

Delta Surface::Impl::takeOver(WholeSurface& whole)
{
    WholeSurface::Result& result = whole.result();
    if (!result.delta.isEmpty())
        result.delta.version = ++_version;
    if (_isovalue != _shownIsovalue) {
        _retiredBytes += _stats.meshBytes;
        _retired.push_back({std::move(_meshes), _shownIsovalue});
        _errors = std::move(result.errors);
    } else {
        discard(std::move(_meshes));
    }
    _meshes = std::move(result.meshes);
    discard(std::exchange(_shown, std::move(result.shown)));
    _shownIsovalue = _isovalue;
    _stats.triangles = result.triangles;
    _stats.meshBytes = result.meshBytes;
    _stats.cellsExtracted += result.cellsExtracted;
    _stats.cellsSkipped += result.cellsSkipped;
    _stats.cellsFromCache += result.cellsFromCache;
    _stats.samples += result.samples;
    _stats.sanitisedSamples += result.sanitisedSamples;

    // Where the surface is now, the front goes on from what is shown.
    discard(std::exchange(
        _refinement,
        hierarchy::Refinement(
            _domain, _criterion, refinementSettings(), std::move(result.wanted))));
    _control.forget();
    renewCriterion();
    return std::move(result.delta);
}

/// Gives up all operations: they were steps between meshes of an isovalue that has gone.
void Surface::Impl::forgetWork()
{
    stopResting();
    _stats.cellsCancelled += _owner.size();
    discard(std::exchange(_operations, {}));
    discard(std::exchange(_owner, {}));
    _arrived.clear();
    _ready.clear();
    _blocked.clear();
    _merges = 0;
    _flightBytes = 0;
    _trial = Trial::none;
}

} // namespace isofront::surface

#include "LiveSurface.h"

#include <algorithm>
#include <utility>

namespace isofront::surface {

namespace {

/// Diamonds that are gone over between two looks at the clock.
constexpr std::size_t kLooks = 256;
/// A cell that only has to be measured waits for all others.
constexpr double kMeasureUrgency = 1e-3;

} // namespace

/// Where the viewer stays and all is done, builds the front from nothing and takes it over. What
/// hysteresis has left goes, and so does what was refined while errors were not yet known: the
/// front depends on nothing but the field and the view.
void Surface::Impl::rest(Requests& requests, Clock::time_point deadline)
{
    if (!_viewStays || _rested || _trial != Trial::none)
        return;
    if (_rest && !(isLiveSettled() && _rest->refinement.isSettled())) {
        // an error that has become known changes one of the fronts
        _rest->stage = Rest::Stage::refining;
        _rest->changes.clear();
    }
    if (!isLiveSettled())
        return;
    if (!_rest)
        _rest.emplace(hierarchy::Refinement(_domain, _criterion, refinementSettings()));
    while (Clock::now() < deadline) {
        switch (_rest->stage) {
        case Rest::Stage::refining:
            _rest->refinement.update(_view, {.tests = kLooks, .deadline = deadline});
            if (!_rest->refinement.isSettled())
                break;
            if (!_rest->measured.empty())
                return;
            _rest->stage = Rest::Stage::asking;
            _rest->left = _rest->refinement.front().diamonds();
            _rest->changes.clear();
            break;
        case Rest::Stage::asking:
            restAsk(requests);
            if (_rest->stage == Rest::Stage::refining && !_rest->measured.empty())
                return;
            break;
        case Rest::Stage::comparing:
            restCompare(requests);
            if (_rested)
                return;
            break;
        }
    }
}

/// Has the cells extracted that decide whether their diamond is to be split.
void Surface::Impl::restAsk(Requests& requests)
{
    for (std::size_t looked = 0; looked < kLooks && !_rest->left.empty(); ++looked) {
        const LatticePoint centre = _rest->left.back();
        _rest->left.pop_back();
        for (const CellId& id : undecidedCells(_rest->refinement, centre)) {
            if (const CellMeshPointer mesh = _cache.find({id, _shownIsovalue})) {
                measure(id, *mesh);
                continue;
            }
            _rest->measured.insert(id);
            requests.push_back({id, kMeasureUrgency});
        }
    }
    if (!_rest->left.empty())
        return;
    // what was found in the cache is known at once; otherwise there may be nothing left to ask
    if (!_rest->measured.empty() || !_rest->refinement.isSettled()) {
        _rest->stage = Rest::Stage::refining;
        return;
    }
    _rest->stage = Rest::Stage::comparing;
    _rest->left = _rest->refinement.front().diamonds();
    _rest->comparesWanted = false;
}

void Surface::Impl::restCompare(Requests& requests)
{
    const hierarchy::Front& fresh = _rest->refinement.front();
    const hierarchy::Front& wanted = _refinement.front();
    const hierarchy::Front& here = _rest->comparesWanted ? wanted : fresh;
    const hierarchy::Front& there = _rest->comparesWanted ? fresh : wanted;
    for (std::size_t looked = 0; looked < kLooks && !_rest->left.empty(); ++looked) {
        const LatticePoint centre = _rest->left.back();
        _rest->left.pop_back();
        if (here.isSplit(centre) && !there.isSplit(centre))
            _rest->changes.push_back({centre, !_rest->comparesWanted});
    }
    if (!_rest->left.empty())
        return;
    if (!_rest->comparesWanted) {
        _rest->comparesWanted = true;
        _rest->left = wanted.diamonds();
        return;
    }
    std::ranges::sort(_rest->changes, {}, [](const hierarchy::FrontChange& change) {
        return std::pair(hierarchy::Diamond(change.diamond).level, change.diamond);
    });
    if (!_rest->changes.empty())
        discard(std::exchange(_refinement, std::move(_rest->refinement)));
    plan(_rest->changes, requests);
    _rest.reset();
    _rested = true;
}

void Surface::Impl::stopResting()
{
    _rested = false;
    if (!_rest)
        return;
    std::vector<CellId> cancelled(_rest->measured.begin(), _rest->measured.end());
    std::erase_if(cancelled, [&](const CellId& id) { return _owner.contains(id); });
    _queue.cancel(cancelled);
    discard(std::move(*_rest));
    _rest.reset();
}

std::vector<CellId> Surface::Impl::undecidedCells(
    const hierarchy::Refinement& refinement, const LatticePoint& centre) const
{
    std::vector<CellId> cells;
    const hierarchy::DiamondState state = refinement.front().stateOf(centre);
    if (_options.detail.measuredLevels <= 0 || state.split ||
        hierarchy::Diamond(centre).level >= _options.maxLevel ||
        _errors->of(centre, state.cells).complete ||
        // if even the most that its error can be doesn't split it, its error is of no interest
        !(refinement.urgency(centre, {state.cells, true}) > 1))
        return cells;
    for (std::uint8_t index = 0; index < 8; ++index)
        if ((unsigned{state.cells} >> index & 1U) != 0 && !_errors->isKnown({centre, index}))
            cells.push_back({centre, index});
    return cells;
}

} // namespace isofront::surface

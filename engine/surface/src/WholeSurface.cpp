#include "WholeSurface.h"

#include "Turns.h"

#include <isofront/core/Powers.h>

#include <algorithm>
#include <utility>

namespace isofront::surface {

namespace {

/// Cells that a worker takes at a time, so that neighbours share what is in its cache.
constexpr std::size_t kBlock = 16;

/// Merges the finest places until there are so many times fewer splits as in a surface that is
/// coarser by so many levels.
/// @param kept  what is split in it stays so, and doesn't count
void coarsen(hierarchy::Front& front, int levels, const hierarchy::Front& kept)
{
    std::size_t extra = 0;
    front.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
        extra += front.isSplit(centre) && !kept.isSplit(centre) ? 1U : 0U;
    });
    const double most = static_cast<double>(extra) * core::twoToThirds(-2 * levels);
    while (static_cast<double>(extra) > most) {
        std::vector<hierarchy::LatticePoint> finest;
        front.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
            if (front.isMergeable(centre) && !kept.isSplit(centre))
                finest.push_back(centre);
        });
        for (const hierarchy::LatticePoint& centre : finest)
            front.merge(centre);
        extra -= finest.size();
    }
}

/// The cells of each diamond are a step of their own: each replaces itself.
std::vector<DeltaStep> stepsByDiamond(const Delta& delta)
{
    std::vector<DeltaStep> steps;
    auto gone = delta.removed.begin();
    auto come = delta.added.begin();
    while (gone != delta.removed.end() || come != delta.added.end()) {
        DeltaStep step;
        step.diamond = come == delta.added.end() ||
                               (gone != delta.removed.end() && gone->spine < come->id.spine)
                           ? gone->spine
                           : come->id.spine;
        for (; gone != delta.removed.end() && gone->spine == step.diamond; ++gone)
            ++step.removed;
        for (; come != delta.added.end() && come->id.spine == step.diamond; ++come)
            ++step.added;
        steps.push_back(step);
    }
    return steps;
}

} // namespace

void WholeSurface::start()
{
    _running = 1;
    _jobs->submit([self = shared_from_this()] { self->list(); });
}

std::size_t WholeSurface::pending() const
{
    const std::size_t count = _count.load(std::memory_order_relaxed);
    return count - std::min(count, _next.load(std::memory_order_relaxed));
}

void WholeSurface::list()
{
    _result.shown = _sources.target != nullptr ? *_sources.target : *_sources.shown;
    if (_sources.coarser > 0)
        coarsen(
            _result.shown,
            _sources.coarser,
            _sources.target != nullptr ? *_sources.shown : hierarchy::Front{});
    _result.shown.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
        const hierarchy::DiamondState state = _result.shown.stateOf(centre);
        if (state.split || isAborted())
            return;
        const extractor::BoxBounds* bounds = _sources.bounds->find(centre);
        const bool empty = bounds != nullptr && _sources.extractor->provesEmpty(*bounds);
        for (std::uint8_t index = 0; index < 8; ++index) {
            if ((unsigned{state.cells} >> index & 1U) == 0)
                continue;
            const CellId id{centre, index};
            if (empty)
                ++_result.cellsSkipped;
            else if (!_sources.sameIsovalue || !_sources.shown->hasCell(id))
                _items.push_back({id, nullptr, Item::Origin::extracted});
            else if (const auto mesh = _sources.meshes->find(id); mesh != _sources.meshes->end())
                _items.push_back({id, mesh->second, Item::Origin::shown});
        }
    });
    if (!_sources.sameIsovalue || _sources.target != nullptr)
        listShownEmpty();
    std::ranges::sort(_items, {}, &Item::id);
    _count.store(_items.size(), std::memory_order_relaxed);
    const std::size_t helpers = std::min(_jobs->concurrency(), _items.size() / kBlock + 1) - 1;
    _running += helpers;
    for (std::size_t i = 0; i < helpers; ++i)
        _jobs->submit([self = shared_from_this()] { self->work(); });
    work();
}

void WholeSurface::listShownEmpty()
{
    _sources.shown->forEachDiamond([&](const hierarchy::LatticePoint& centre) {
        const hierarchy::DiamondState state = _sources.shown->stateOf(centre);
        if (state.split || isAborted())
            return;
        const extractor::BoxBounds* bounds = _sources.bounds->find(centre);
        if (bounds != nullptr && _sources.shownExtractor->provesEmpty(*bounds))
            return;
        for (std::uint8_t index = 0; index < 8; ++index) {
            const CellId id{centre, index};
            if ((unsigned{state.cells} >> index & 1U) == 0 || _sources.meshes->contains(id) ||
                (_sources.sameIsovalue && _result.shown.hasCell(id)))
                continue;
            if (_sources.shownErrors == nullptr)
                _result.shownEmpty.push_back({id, false});
            else if (_sources.shownErrors->isKnown(id))
                _result.shownEmpty.push_back({id, _sources.shownErrors->isProvedEmpty(id)});
        }
    });
    std::ranges::sort(_result.shownEmpty, {}, &FormerMeshes::EmptyCell::id);
}

CellMeshPointer WholeSurface::known(const CellId& id) const
{
    for (const FormerMeshes* former : _sources.former)
        if (CellMeshPointer mesh = former->find(id))
            return mesh;
    return _sources.cache->find({id, isovalue()});
}

void WholeSurface::work()
{
    for (std::size_t begin = _next.fetch_add(kBlock); begin < _items.size();
         begin = _next.fetch_add(kBlock)) {
        const std::size_t end = std::min(begin + kBlock, _items.size());
        for (std::size_t i = begin; i < end && !isAborted(); ++i) {
            Item& item = _items[i];
            if (item.origin == Item::Origin::shown)
                continue;
            item.mesh = known(item.id);
            if (item.mesh) {
                item.origin = Item::Origin::cache;
                continue;
            }
            item.mesh =
                extractShared(*_sources.extractor, _sources.shared.get(), item.id, &_aborted);
        }
        if (isAborted())
            break;
        if (handOver(*_jobs, [self = shared_from_this()] { self->work(); }))
            return;
    }
    leave();
}

void WholeSurface::leave()
{
    if (_running.fetch_sub(1) != 1)
        return;
    if (isAborted())
        salvage();
    else
        assemble();
    _quiet.store(true, std::memory_order_release);
    _quiet.notify_all();
}

void WholeSurface::keep(Item& item)
{
    if (item.mesh->indices.empty()) {
        _result.empty.push_back({item.id, item.mesh->stats.provedEmpty});
        return;
    }
    _result.triangles += item.mesh->triangleCount();
    _result.meshBytes += item.mesh->bytes();
    _result.meshes.emplace(item.id, std::move(item.mesh));
}

void WholeSurface::salvage()
{
    _result.shown = {};
    for (Item& item : _items)
        if (item.mesh && item.origin == Item::Origin::extracted)
            keep(item);
    _items = {};
}

void WholeSurface::assemble()
{
    const double stretch = _sources.extractor->domain().worldFromField.stretch();
    _result.errors = std::make_shared<MeasuredErrors>();
    _result.meshes.reserve(_items.size());
    Delta& delta = _result.delta;
    delta.isovalue = isovalue();
    for (Item& item : _items) {
        const extractor::CellMesh& mesh = *item.mesh;
        _result.errors->record(item.id, mesh, stretch);
        _result.cellsFromCache += item.origin == Item::Origin::cache ? 1U : 0U;
        if (item.origin == Item::Origin::extracted) {
            (mesh.stats.provedEmpty ? _result.cellsSkipped : _result.cellsExtracted) += 1;
            _result.samples += mesh.stats.samples;
            _result.sanitisedSamples += mesh.stats.sanitisedSamples;
        }
        if (!mesh.indices.empty() &&
            (!_sources.sameIsovalue || !_sources.meshes->contains(item.id)))
            delta.added.emplace_back(item.id, item.mesh);
        keep(item);
    }
    for (const auto& [id, mesh] : *_sources.meshes) {
        if (_sources.sameIsovalue && _result.meshes.contains(id))
            continue;
        delta.removed.push_back(id);
        if (_sources.sameIsovalue) {
            _result.leavingBytes += mesh->bytes();
            _result.leaving.emplace(id, mesh);
        }
    }
    std::ranges::sort(delta.removed);
    if (_sources.target == nullptr && _sources.coarser == 0)
        delta.steps = stepsByDiamond(delta);
    else if (!delta.isEmpty())
        delta.steps = {{hierarchy::kRootDiamond, delta.removed.size(), delta.added.size()}};
    if (_sources.target == nullptr)
        _result.wanted = _result.shown;
    _items = {};
}

} // namespace isofront::surface

#include "LiveSurface.h"

#include <algorithm>
#include <array>
#include <stop_token>
#include <utility>

namespace isofront::surface {

namespace {

/// Cells that are extracted between two looks at what else there is to do.
constexpr std::size_t kSlice = 256;
constexpr std::size_t kTests = 4096;
/// Of the factor at a time, while the front is not even complete when it meets its ceiling.
constexpr int kBoldSteps = 4;

} // namespace

/// The front of a view, built from nothing, and the meshes of its cells; those that were there
/// already come from where they were.
class Surface::Impl::Settling {
public:
    Settling(
        Impl& surface, const std::function<void(double)>& progress, const std::stop_token& stop)
        : _surface(surface), _progress(progress), _stop(stop),
          _refinement(surface._domain, surface._criterion, surface.refinementSettings())
    {
        const bool keeps = surface._rootShown && surface._shownIsovalue == surface._isovalue;
        if (keeps)
            _known = surface._meshes;
        for (const auto& [centre, operation] : surface._operations)
            for (std::size_t i = 0; i < operation.cells.size(); ++i)
                if (operation.meshes[i])
                    _known[operation.cells[i]] = operation.meshes[i];
        _keepsShown = keeps;
    }

    /// False if it was stopped.
    bool run()
    {
        while (refine()) {
            const std::vector<CellId> undecided = cellsWhere([&](const LatticePoint& centre) {
                return _surface.undecidedCells(_refinement, centre);
            });
            const std::vector<CellId> missing =
                undecided.empty()
                    ? cellsWhere([&](const LatticePoint& centre) { return missingOf(centre); })
                    : std::vector<CellId>{};
            if (!undecided.empty() || !missing.empty()) {
                extract(undecided, false);
                extract(missing, true);
                continue;
            }
            if (!fits() && !_surface._control.isAtItsEnd()) {
                _surface._control.coarsen();
            } else if (_surface._control.mayRefine()) {
                _surface._control.refine();
            } else {
                return true;
            }
            renew();
        }
        return false;
    }

    [[nodiscard]] hierarchy::Refinement& refinement() { return _refinement; }
    /// Of all cells of the front but those that are shown already; null for those without
    /// triangles that were never extracted.
    [[nodiscard]] CellMeshes& meshes() { return _known; }

private:
    bool refine()
    {
        while (!_refinement.isSettled() && !_stop.stop_requested()) {
            _refinement.update(_surface._view, {.tests = kTests});
            if (_refinement.front().cellCount() <= _surface._options.maxCells ||
                _surface._control.isAtItsEnd())
                continue;
            // it has only grown so far, and will grow more
            _surface._control.coarsen(_refinement.isSettled() ? 1 : kBoldSteps);
            renew();
        }
        return !_stop.stop_requested();
    }

    /// Begins anew with another factor, so that the front only ever grows.
    void renew()
    {
        _surface.renewCriterion();
        _refinement = hierarchy::Refinement(
            _surface._domain, _surface._criterion, _surface.refinementSettings());
    }

    template <typename CellsOf>
    std::vector<CellId> cellsWhere(const CellsOf& cellsOf) const
    {
        std::vector<CellId> cells;
        _refinement.front().forEachDiamond([&](const LatticePoint& centre) {
            for (const CellId& id : cellsOf(centre))
                cells.push_back(id);
        });
        std::ranges::sort(cells);
        return cells;
    }

    /// Cells of the front whose meshes aren't there yet.
    [[nodiscard]] std::vector<CellId> missingOf(const LatticePoint& centre) const
    {
        std::vector<CellId> cells;
        const hierarchy::DiamondState state = _refinement.front().stateOf(centre);
        for (std::uint8_t index = 0; !state.split && index < 8; ++index) {
            const CellId id{centre, index};
            if ((unsigned{state.cells} >> index & 1U) != 0 && !_known.contains(id) &&
                !(_keepsShown && _surface._shown.hasCell(id)))
                cells.push_back(id);
        }
        return cells;
    }

    void extract(const std::vector<CellId>& cells, bool isLast)
    {
        for (std::size_t begin = 0; begin < cells.size() && !_stop.stop_requested();
             begin += kSlice) {
            const std::size_t size = std::min(kSlice, cells.size() - begin);
            if (_progress && isLast) {
                _share = std::max(_share, double(begin) / double(cells.size()));
                _progress(_share);
            }
            std::array<CellMeshPointer, kSlice> meshes;
            for (std::size_t i = 0; i < size; ++i)
                meshes[i] = find(cells[begin + i]);
            std::array<bool, kSlice> isNew{};
            _surface._jobs->parallelFor(size, [&](std::size_t i) {
                isNew[i] = meshes[i] == nullptr;
                if (isNew[i])
                    meshes[i] = extractShared(
                        *_surface._extractor, _surface._options.shared.get(), cells[begin + i]);
            });
            for (std::size_t i = 0; i < size; ++i) {
                if (isNew[i])
                    _surface.count(*meshes[i]);
                _surface.measure(cells[begin + i], *meshes[i]);
                _refinement.lookAgain(cells[begin + i].spine);
                _known[cells[begin + i]] = std::move(meshes[i]);
            }
        }
    }

    CellMeshPointer find(const CellId& id)
    {
        if (const auto found = _known.find(id); found != _known.end())
            return found->second;
        CellMeshPointer mesh = _surface._cache.take({id, _surface._isovalue});
        if (mesh)
            ++_surface._stats.cellsFromCache;
        return mesh;
    }

    [[nodiscard]] bool fits() const
    {
        std::size_t triangles = 0;
        std::size_t bytes = 0;
        _refinement.front().forEachCell([&](const CellId& id, const hierarchy::Tetrahedron&) {
            if (const auto found = _known.find(id);
                found != _known.end() && !found->second->indices.empty()) {
                triangles += found->second->triangleCount();
                bytes += found->second->bytes();
            }
        });
        const std::size_t others =
            _surface.bytesNeeded() - _surface._stats.meshBytes - _surface._flightBytes;
        return triangles <= _surface._options.maxTriangles &&
               bytes + others <= _surface._options.maxBytes &&
               _refinement.front().cellCount() <= _surface._options.maxCells;
    }

    Impl& _surface;
    const std::function<void(double)>& _progress;
    const std::stop_token& _stop;
    hierarchy::Refinement _refinement;
    bool _keepsShown = false;
    CellMeshes _known;
    double _share = 0;
};

Delta Surface::Impl::settle(
    const hierarchy::View& view,
    const std::function<void(double)>& progress,
    const std::stop_token& stop)
{
    if (!view.isValid()) {
        ++_stats.refusedViews;
        return {};
    }
    follow(view);
    if (_whole) {
        _whole->abort();
        _whole->wait();
        giveUp(std::exchange(_whole, nullptr));
    }
    if (_beginsToMeasure)
        beginMeasuring();
    // all that is known is in one place then
    retireSome(Clock::time_point::max());
    if (_extractor->settings().isovalue != _isovalue || _shownIsovalue != _isovalue) {
        forgetWork();
        _extractor = extractorFor(_isovalue);
        _queue.restart(_extractor);
        _errors = std::make_shared<MeasuredErrors>();
        renewCriterion();
    }
    stopResting();
    // the background would do the same work again
    std::vector<CellId> underExtraction = _rootMissing;
    for (const auto& [id, centre] : _owner)
        underExtraction.push_back(id);
    _queue.cancel(underExtraction);

    Settling settling(*this, progress, stop);
    if (!settling.run()) {
        // all is as it was; what had come goes to the cache, and work goes on with the next update
        for (auto& [id, mesh] : settling.meshes())
            if (!_meshes.contains(id))
                _cache.insert({id, _isovalue}, std::move(mesh));
        Requests requests;
        for (const auto& [id, centre] : _owner)
            requests.push_back({id, _operations.at(centre).urgency});
        request(requests);
        if (_isovalue != _shownIsovalue) // the errors are of cells that aren't shown
            _errors = std::make_shared<MeasuredErrors>();
        return {};
    }

    DeltaBuilder delta;
    delta.begin(hierarchy::kRootDiamond);
    const hierarchy::Front& front = settling.refinement().front();
    const bool keeps = _rootShown && _shownIsovalue == _isovalue;
    std::vector<CellId> leaving;
    _shown.forEachCell([&](const CellId& id, const hierarchy::Tetrahedron&) {
        if (_rootShown && !(keeps && front.hasCell(id)))
            leaving.push_back(id);
    });
    for (const CellId& id : leaving)
        hide(id, delta);
    _shownIsovalue = _isovalue;
    for (auto& [id, mesh] : settling.meshes()) {
        if (!front.hasCell(id))
            keep(id, std::move(mesh)); // an operation's, or extracted for its error alone
        else if (!_meshes.contains(id))
            show(id, std::move(mesh), delta);
    }
    forgetWork();
    _frontsApart = false;
    _rootMissing.clear();
    _rootMeshes.clear();
    _shown = front;
    discard(std::exchange(_refinement, std::move(settling.refinement())));
    _rootShown = true;
    _rested = true;
    if (progress)
        progress(1.0);
    watchCeilings();
    return finish(delta);
}

} // namespace isofront::surface

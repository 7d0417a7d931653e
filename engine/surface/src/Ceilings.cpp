#include "LiveSurface.h"

#include <algorithm>

namespace isofront::surface {

namespace {

/// While the viewer moves, a finer factor is taken up only if it will hardly be too fine: a step of
/// the factor makes the mesh a fifth larger.
constexpr double kPlenty = 0.7;
/// Steps at a time while the wanted front still grows beyond its ceiling.
constexpr int kBoldSteps = 4;

} // namespace

std::size_t Surface::Impl::bytesInUse() const
{
    return _stats.meshBytes + _flightBytes + _retiredBytes + _cache.bytes() + _shown.bytes() +
           _refinement.bytes() + _bounds->bytes() + _errors->bytes() + _hostBytes;
}

/// Without what gives way to all else: the cache and what is on its way there.
std::size_t Surface::Impl::bytesNeeded() const
{
    return bytesInUse() - _cache.bytes() - _retiredBytes;
}

bool Surface::Impl::hasRoomFor(const LatticePoint& centre, const Operation& operation) const
{
    // a split doubles the cells of its diamond
    const std::size_t wholes = operation.cells.size() / 2;
    if (_shown.cellCount() + wholes > _options.maxCells)
        return false;
    if (bytesNeeded() > _options.maxBytes)
        return false;
    if (_stats.triangles * 2 < _options.maxTriangles / 2)
        return true;
    std::size_t triangles = _stats.triangles;
    for (const CellMeshPointer& mesh : operation.meshes)
        triangles += mesh->triangleCount();
    for (const CellId& id : wholesOf(centre))
        if (const auto found = _meshes.find(id); found != _meshes.end())
            triangles -= found->second->triangleCount();
    return triangles <= _options.maxTriangles;
}

bool Surface::Impl::hasRoomForAllOperations() const
{
    // what one operation brings another may take away
    std::unordered_map<CellId, std::size_t, CellIdHash> brought;
    std::size_t triangles = _stats.triangles;
    for (const auto& [centre, operation] : _operations)
        for (std::size_t i = 0; i < operation.cells.size(); ++i) {
            const std::size_t count = operation.meshes[i]->triangleCount();
            brought[operation.cells[i]] = count;
            triangles += count;
        }
    for (const auto& [centre, operation] : _operations)
        for (const CellId& id : operation.split ? wholesOf(centre) : halvesOf(centre)) {
            if (const auto other = brought.find(id); other != brought.end())
                triangles -= other->second;
            else if (const auto shown = _meshes.find(id); shown != _meshes.end())
                triangles -= shown->second->triangleCount();
        }
    return _refinement.front().cellCount() <= _options.maxCells &&
           triangles <= _options.maxTriangles && bytesNeeded() <= _options.maxBytes;
}

/// Of the ceiling that is nearest.
double Surface::Impl::shareOfCeilings() const
{
    const auto share = [](std::size_t used, std::size_t most) {
        return static_cast<double>(used) / std::max(1.0, static_cast<double>(most));
    };
    return std::max(
        {share(_refinement.front().cellCount(), _options.maxCells),
         share(_stats.triangles, _options.maxTriangles),
         share(bytesNeeded(), _options.maxBytes)});
}

/// The wanted front may not grow far beyond its ceiling, even for the time until it is settled.
void Surface::Impl::watchCells()
{
    const std::size_t cells = _refinement.front().cellCount();
    if (cells <= _options.maxCells || _control.isAtItsEnd()) {
        _cellsWhenCoarsened = _options.maxCells;
        return;
    }
    if (_trial == Trial::waiting) // so it has only grown
        _control.coarsen();
    else if (_refinement.isSettled())
        _control.coarsenOnSuspicion(1);
    else if (cells > _cellsWhenCoarsened + _options.maxCells / 16)
        _control.coarsenOnSuspicion(kBoldSteps);
    else
        return;
    _cellsWhenCoarsened = cells;
    if (_trial == Trial::waiting)
        _trial = Trial::undoing;
    renewCriterion();
}

void Surface::Impl::watchCeilings()
{
    const std::size_t needed = bytesNeeded();
    boundRetired();
    _cache.setCapacity(std::min(
        _options.cacheBytes,
        _options.maxBytes - std::min(needed + _retiredBytes, _options.maxBytes)));
    if (!_refinement.isSettled() || _trial != Trial::none)
        return;
    const bool isOver = !_blocked.empty() || needed > _options.maxBytes;
    if (isOver) {
        if (_merges == 0 && !_control.isAtItsEnd()) { // merges would make room
            // What hysteresis and history have left may be too much where the front built from
            // nothing isn't: only a trial proves that. Memory is as it is.
            if (needed > _options.maxBytes)
                _control.coarsen();
            else
                _control.coarsenOnSuspicion(1);
            renewCriterion();
        }
        return;
    }
    if (!_control.mayRefine())
        return;
    if (isLiveSettled() && _rested) {
        _control.refine();
        _trial = Trial::waiting;
        renewCriterion();
    } else if (!_viewStays && shareOfCeilings() < kPlenty) {
        _control.refine();
        renewCriterion();
    }
}

void Surface::Impl::judgeTrial()
{
    if (!_refinement.isSettled())
        return;
    if (_trial == Trial::undoing) {
        _trial = Trial::none;
        return;
    }
    if (!_owner.empty())
        return; // meshes are still missing
    if (hasRoomForAllOperations()) {
        _trial = Trial::none;
        return;
    }
    _control.coarsen();
    _trial = Trial::undoing;
    renewCriterion();
}

} // namespace isofront::surface

#include "LiveSurface.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <limits>
#include <utility>

namespace isofront::surface {

namespace {

/// Operations that wait for others: fewer are soon done one after the other.
constexpr std::size_t kFewWaiting = 64;
/// Updates in a row in which requests are kept back.
constexpr int kMostHeldBack = 60;
/// The first step of a jump, and by how much the next are finer [levels].
constexpr int kFirstCoarser = 6;
constexpr int kFiner = 3;

} // namespace

/// True if most of what is to be done leads through levels that nobody wants to see.
bool Surface::Impl::isJumping() const
{
    constexpr std::size_t kNoCeiling = std::numeric_limits<std::size_t>::max();
    return _options.skipLevels && _rootShown && _waiting >= kFewWaiting &&
           2 * _waiting > _operations.size() && _options.detail.measuredLevels <= 0 &&
           _options.maxCells == kNoCeiling && _options.maxTriangles == kNoCeiling &&
           _options.maxBytes == kNoCeiling;
}

/// Keeps requests back as long as they may turn out to be for levels that are skipped, which is
/// known once the wanted front is there. For a viewer who never stands still it may never be.
bool Surface::Impl::holdsBack(Requests& requests)
{
    if (_refinement.isSettled())
        _heldBack = 0;
    if (isJumping() && _heldBack < kMostHeldBack) {
        ++_heldBack;
        _held.insert(_held.end(), requests.begin(), requests.end());
        return true;
    }
    requests.insert(requests.begin(), _held.begin(), _held.end());
    _held.clear();
    return false;
}

/// Prepares the wanted front whole, coarser first.
void Surface::Impl::startJump()
{
    LatticePoint finest = hierarchy::kRootDiamond;
    for (const auto& [centre, operation] : _operations)
        if (operation.split && hierarchy::Diamond(centre).level > hierarchy::Diamond(finest).level)
            finest = centre;
    _jumpEye = _view.eye;
    _jumpReach = std::max(0.0, _criterion->refineDistance(hierarchy::Diamond(finest)));
    retireOperations();
    forgetWork();
    _queue.restart(_extractor);
    startWhole(finest == hierarchy::kRootDiamond ? 0 : kFirstCoarser, &_refinement.front());
}

/// What operations hold may be wanted yet.
void Surface::Impl::retireOperations()
{
    CellMeshes meshes;
    std::vector<FormerMeshes::EmptyCell> empty;
    for (auto& [centre, operation] : _operations)
        for (std::size_t i = 0; i < operation.cells.size(); ++i) {
            if (!operation.meshes[i])
                continue;
            if (operation.meshes[i]->indices.empty())
                empty.push_back({operation.cells[i], operation.meshes[i]->stats.provedEmpty});
            else
                meshes.emplace(operation.cells[i], operation.meshes[i]);
        }
    std::ranges::sort(empty, {}, &FormerMeshes::EmptyCell::id);
    const std::size_t bytes = std::exchange(_flightBytes, 0);
    retire({std::move(meshes), std::move(empty), bytes, _shownIsovalue});
}

/// True if the viewer is so far from where the jump went that none of its finest detail is of use.
/// The first step is taken all the same, so that there is something new however often he jumps.
bool Surface::Impl::jumpsElsewhere() const
{
    return _whole->coarser() < kFirstCoarser && glm::distance(_view.eye, _jumpEye) > _jumpReach;
}

Delta Surface::Impl::takeOverJump(WholeSurface& whole)
{
    WholeSurface::Result& result = whole.result();
    if (!result.delta.isEmpty())
        result.delta.version = ++_version;
    count(result);
    discard(std::exchange(_meshes, std::move(result.meshes)));
    discard(std::exchange(_shown, std::move(result.shown)));
    retire(
        {std::move(result.leaving),
         std::move(result.shownEmpty),
         result.leavingBytes,
         _shownIsovalue});
    if (whole.coarser() == 0)
        _frontsApart = false; // the wanted front is as it was when the jump began
    else
        startWhole(std::max(0, whole.coarser() - kFiner), &_refinement.front());
    return std::move(result.delta);
}

} // namespace isofront::surface

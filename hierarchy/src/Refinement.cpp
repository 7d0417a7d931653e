#include "isofront/hierarchy/Refinement.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::hierarchy {

namespace {

constexpr double kDueNow = -1.0;
/// In edges of the domain. Beyond it steps of the finest cells' size would be lost to rounding.
constexpr double kLongestPath = 1e4;

} // namespace

Refinement::Refinement(
    Domain domain, std::shared_ptr<const Criterion> criterion, RefinementSettings settings)
    : _domain(domain), _criterion(std::move(criterion)), _settings(settings),
      _stretch(domain.worldFromField.stretch())
{
    ISOFRONT_ASSERT(_criterion != nullptr, "a refinement needs a criterion");
    _settings.maxLevel = std::clamp(_settings.maxLevel, 0, kMaxLevel);
}

std::vector<FrontChange> Refinement::update(const View& view, const RefinementBudget& budget)
{
    std::vector<FrontChange> changes;
    if (!view.isValid()) {
        ++_refusedViews;
        return changes;
    }
    moveTo(view.eye);

    for (std::size_t tests = 0; tests < budget.tests && changes.size() < budget.operations;
         ++tests) {
        // the clock is not free: a look at it every so often is enough
        if (tests % 16 == 15 && std::chrono::steady_clock::now() > budget.deadline)
            break;
        if (_due.empty())
            break;
        const LatticePoint centre = _due.top().diamond;
        _due.pop();
        test(centre, changes);
    }
    return changes;
}

void Refinement::setCriterion(std::shared_ptr<const Criterion> criterion)
{
    ISOFRONT_ASSERT(criterion != nullptr, "a refinement needs a criterion");
    _criterion = std::move(criterion);
    if (_hasEye)
        startAfresh();
}

std::size_t Refinement::bytes() const
{
    constexpr std::size_t kWakeNode = sizeof(std::pair<LatticePoint, double>) + 3 * sizeof(void*);
    return _front.bytes() + _wakeAt.size() * kWakeNode + _asleep.size() * sizeof(Wake) +
           _due.size() * sizeof(Due);
}

void Refinement::startAfresh()
{
    _travelled = 0;
    _asleep = {};
    _due = {};
    _wakeAt.clear();
    _front.forEachDiamond([this](const LatticePoint& centre) { touch(centre); });
}

double Refinement::urgency(const LatticePoint& centre) const
{
    const Diamond diamond(centre);
    const double reach = _criterion->refineDistance(diamond);
    // the smallest distance keeps the order of reaches among diamonds that hold the eye
    const double nearest = 1e-9 * _domain.edge * _stretch;
    return reach / std::max(distanceTo(diamond), nearest);
}

void Refinement::moveTo(const glm::dvec3& eye)
{
    if (!_hasEye) {
        _hasEye = true;
        _eye = eye;
        startAfresh();
        return;
    }
    if (eye == _eye)
        return;
    _travelled += glm::distance(eye, _eye);
    _eye = eye;
    // A path so long (or infinite) that it would swallow small steps: every appointment is over.
    if (!(_travelled < kLongestPath * _domain.edge * _stretch)) {
        startAfresh();
        return;
    }
    while (!_asleep.empty() && _asleep.top().travelled <= _travelled) {
        const Wake wake = _asleep.top();
        _asleep.pop();
        const auto found = _wakeAt.find(wake.diamond);
        if (found != _wakeAt.end() && found->second == wake.travelled)
            touch(wake.diamond);
    }
}

void Refinement::test(const LatticePoint& centre, std::vector<FrontChange>& changes)
{
    _wakeAt.erase(centre);
    if (!_front.isKnown(centre))
        return; // its cells were merged away meanwhile
    const Diamond diamond(centre);
    const double distance = distanceTo(diamond);
    const double reach = _criterion->refineDistance(diamond);

    if (!_front.isSplit(centre)) {
        if (diamond.level >= _settings.maxLevel)
            return;
        if (!(distance < reach)) {
            sleep(centre, reach < 0 ? kAlways : distance - reach);
            return;
        }
        for (const LatticePoint& split : _front.refine(centre)) {
            changes.push_back({split, true});
            touch(split);
            for (const LatticePoint& child : childrenOf(Diamond(split)))
                touch(child);
        }
        return;
    }

    const double mergeDistance = reach * _settings.hysteresis;
    if (!(distance > mergeDistance)) {
        sleep(centre, mergeDistance - distance);
        return;
    }
    if (!_front.isMergeable(centre))
        return; // looked at again when a child has been merged
    _front.merge(centre);
    changes.push_back({centre, false});
    touch(centre);
    for (const LatticePoint& parent : parentsOf(diamond))
        touch(parent);
}

void Refinement::touch(const LatticePoint& centre)
{
    const auto [entry, isNew] = _wakeAt.try_emplace(centre, kDueNow);
    if (!isNew) {
        if (entry->second == kDueNow)
            return;
        entry->second = kDueNow;
    }
    _due.push({urgency(centre), centre});
}

void Refinement::sleep(const LatticePoint& centre, double slack)
{
    const double until = _travelled + slack;
    if (!std::isfinite(until))
        return;
    _wakeAt[centre] = until;
    _asleep.push({until, centre});
}

double Refinement::distanceTo(const Diamond& diamond) const
{
    const glm::dvec3 centre =
        _domain.worldFromField.point(_domain.fieldFromLattice(diamond.centre));
    const double radius = diamond.radius() * _domain.latticeUnit() * _stretch;
    // scaled, so that an eye however far doesn't overflow
    const double scale = std::max({1.0, std::abs(_eye.x), std::abs(_eye.y), std::abs(_eye.z)});
    return std::max(0.0, scale * glm::length(centre / scale - _eye / scale) - radius);
}

} // namespace isofront::hierarchy

#include "isofront/hierarchy/Refinement.h"

#include <isofront/core/Assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::hierarchy {

namespace {

constexpr double kDueNow = -1.0;
/// In edges of the domain. Beyond it steps of the finest cells' size would be lost to rounding.
constexpr double kLongestPath = 1e4;

/// Directions are rounded to a grid of so many steps from the middle of a side of a cube to its
/// edge, which turns them by at most atan(sqrt(2) / 2 / 8) radians.
constexpr double kDirectionSteps = 8;
constexpr double kMostTurned = 0.0883;
/// Beyond it, next to nothing is outside the picture [radians].
constexpr double kWidestCone = 1.5;

glm::dvec3 roundedDirection(const glm::dvec3& forward)
{
    const glm::dvec3 size = glm::abs(forward);
    const double largest = std::max({size.x, size.y, size.z});
    return glm::normalize(glm::round(forward / largest * kDirectionSteps));
}

/// Half angle of the cone around a view's picture [radians].
double coneOf(const View& view)
{
    const double aspect = double(view.width) / view.height;
    return std::atan(std::tan(0.5 * view.verticalFieldOfView) * std::hypot(1.0, aspect));
}

} // namespace

double
distanceTo(const Domain& domain, double stretch, const Diamond& diamond, const glm::dvec3& eye)
{
    const glm::dvec3 centre = domain.worldFromField.point(domain.fieldFromLattice(diamond.centre));
    const double radius = diamond.radius() * domain.latticeUnit() * stretch;
    // scaled, so that an eye however far doesn't overflow
    const double scale = std::max({1.0, std::abs(eye.x), std::abs(eye.y), std::abs(eye.z)});
    return std::max(0.0, scale * glm::length(centre / scale - eye / scale) - radius);
}

Refinement::Refinement(
    Domain domain,
    std::shared_ptr<const Criterion> criterion,
    RefinementSettings settings,
    Front front)
    : _domain(domain), _criterion(std::move(criterion)), _settings(settings),
      _stretch(domain.worldFromField.stretch()), _front(std::move(front))
{
    ISOFRONT_ASSERT(_criterion != nullptr, "a refinement needs a criterion");
    ISOFRONT_ASSERT(_settings.offScreen > 0 && _settings.offScreen <= 1, "it is a share");
    _settings.maxLevel = std::clamp(_settings.maxLevel, 0, kMaxLevel);
}

std::vector<FrontChange> Refinement::update(const View& view, const RefinementBudget& budget)
{
    std::vector<FrontChange> changes;
    if (!view.isValid()) {
        ++_refusedViews;
        return changes;
    }
    follow(view);

    for (std::size_t tests = 0; tests < budget.tests && changes.size() < budget.operations;
         ++tests) {
        // the clock is not free: a look at it every so often is enough
        if (tests % 16 == 15 && std::chrono::steady_clock::now() > budget.deadline)
            break;
        if (isWakeDue()) {
            wakeNext();
        } else if (!_unswept.empty()) {
            lookAgain(_unswept.back());
            _unswept.pop_back();
        } else if (!_due.empty()) {
            const LatticePoint centre = _due.top().diamond;
            _due.pop();
            test(centre, changes);
        } else {
            break;
        }
    }
    return changes;
}

void Refinement::setCriterion(std::shared_ptr<const Criterion> criterion)
{
    ISOFRONT_ASSERT(criterion != nullptr, "a refinement needs a criterion");
    _criterion = std::move(criterion);
    if (_hasView)
        startSweep();
}

void Refinement::lookAgain(const LatticePoint& diamond)
{
    if (_hasView && _front.isKnown(diamond))
        touch(diamond);
}

std::size_t Refinement::bytes() const
{
    constexpr std::size_t kWakeNode = sizeof(std::pair<LatticePoint, double>) + 3 * sizeof(void*);
    return _front.bytes() + _wakeAt.size() * kWakeNode + _asleep.size() * sizeof(Wake) +
           _due.size() * sizeof(Due) + _unswept.capacity() * sizeof(LatticePoint);
}

void Refinement::startSweep()
{
    _unswept = _front.diamonds();
    // Appointments made before are kept to, which does no harm; but they mustn't pile up.
    if (_asleep.size() > 4 * _wakeAt.size() + 1024) {
        _asleep = {};
        for (const auto& [diamond, travelled] : _wakeAt)
            if (travelled != kDueNow)
                _asleep.push({travelled, diamond});
    }
}

double Refinement::urgency(const LatticePoint& centre, DiamondState state) const
{
    const Diamond diamond(centre);
    // the smallest distance keeps the order of reaches among diamonds that hold the eye
    const double nearest = 1e-9 * _domain.edge * _stretch;
    return reachOf(diamond, state).distance / std::max(distanceTo(diamond), nearest);
}

void Refinement::follow(const View& view)
{
    bool sweeps = !_hasView;
    if (_settings.offScreen < 1) {
        const glm::dvec3 direction = roundedDirection(view.forward);
        const double cone = coneOf(view) + kMostTurned;
        sweeps = sweeps || direction != _direction || cone != _cone;
        _direction = direction;
        _cone = cone;
    }
    if (_hasView && view.eye != _eye) {
        _travelled += glm::distance(view.eye, _eye);
        // A path so long (or infinite) that it would swallow small steps: every appointment is
        // over.
        if (!(_travelled < kLongestPath * _domain.edge * _stretch)) {
            _travelled = 0;
            _asleep = {};
            _due = {};
            _wakeAt.clear();
            sweeps = true;
        }
    }
    _eye = view.eye;
    _hasView = true;
    if (sweeps)
        startSweep();
}

void Refinement::wakeNext()
{
    const Wake wake = _asleep.top();
    _asleep.pop();
    const auto found = _wakeAt.find(wake.diamond);
    if (found != _wakeAt.end() && found->second == wake.travelled)
        touch(wake.diamond);
}

void Refinement::test(const LatticePoint& centre, std::vector<FrontChange>& changes)
{
    _wakeAt.erase(centre);
    if (!_front.isKnown(centre))
        return; // its cells were merged away meanwhile
    const Diamond diamond(centre);
    const double distance = distanceTo(diamond);
    const Reach reach = reachOf(diamond, _front.stateOf(centre));

    if (!_front.isSplit(centre)) {
        if (diamond.level >= _settings.maxLevel)
            return;
        if (!(distance < reach.distance)) {
            const double free = reach.distance < 0 ? kAlways : distance - reach.distance;
            sleep(centre, std::min(free, reach.slack));
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

    const double mergeDistance = reach.distance * _settings.hysteresis;
    if (!(distance > mergeDistance)) {
        sleep(centre, std::min(mergeDistance - distance, reach.slack));
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

double Refinement::outsideBy(const Diamond& diamond) const
{
    const glm::dvec3 centre =
        _domain.worldFromField.point(_domain.fieldFromLattice(diamond.centre));
    const glm::dvec3 to = centre - _eye;
    const double along = glm::dot(to, _direction);
    const double across = glm::length(to - along * _direction);
    // behind the tip, the tip itself is the nearest point of the cone
    const bool behind = along * std::cos(_cone) + across * std::sin(_cone) < 0;
    const double outside =
        behind ? glm::length(to) : across * std::cos(_cone) - along * std::sin(_cone);
    return outside - diamond.radius() * _domain.latticeUnit() * _stretch;
}

Refinement::Reach Refinement::reachOf(const Diamond& diamond, DiamondState state) const
{
    Reach reach{_criterion->refineDistance(diamond, state), kAlways};
    if (_settings.offScreen < 1 && reach.distance > 0 && reach.distance < kAlways &&
        _cone < kWidestCone) {
        const double outside = outsideBy(diamond);
        if (outside > 0)
            reach.distance *= _settings.offScreen;
        reach.slack = std::abs(outside);
    }
    return reach;
}

} // namespace isofront::hierarchy

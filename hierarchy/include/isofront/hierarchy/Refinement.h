#pragma once

#include <isofront/hierarchy/Criterion.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/Front.h>
#include <isofront/hierarchy/View.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <queue>
#include <unordered_map>
#include <vector>

namespace isofront::hierarchy {

/// How far a diamond is from a viewer's eye: from a ball around its tetrahedra, 0 inside [world].
/// @param stretch  of the domain's map
double
distanceTo(const Domain& domain, double stretch, const Diamond& diamond, const glm::dvec3& eye);

/// How much one update may do.
struct RefinementBudget {
    std::size_t tests = 4096;      ///< diamonds looked at
    std::size_t operations = 4096; ///< diamonds split or merged (a closure is not cut in two)
    std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// One step of the front.
struct FrontChange {
    LatticePoint diamond;
    bool split = false; ///< otherwise merged
};

struct RefinementSettings {
    int maxLevel = kMaxLevel;
    /// A diamond is merged only from this many times its refinement distance on. The default, one
    /// level of the hierarchy, keeps a viewer who wavers from making work.
    double hysteresis = 1.2599210498948732; // 2^(1/3)
    /// Share of their refinement distance at which diamonds outside the picture are split, (0, 1].
    /// What is kept for the picture is decided by a cone around it and a direction rounded to about
    /// 5 degrees, so that small turns of the head change nothing.
    double offScreen = 1;
};

/// Keeps a front as fine as a criterion asks for a moving viewer.
///
/// Each diamond is looked at again only once the viewer has travelled far enough for the decision
/// to change, so that a steady flight costs little, whatever the size of the front. Those whose
/// error is most visible come first.
///
/// Thread: one at a time.
class Refinement {
public:
    Refinement(
        Domain domain,
        std::shared_ptr<const Criterion> criterion,
        RefinementSettings settings = {},
        Front front = {});

    /// Follows the viewer. A view that is not valid is refused: nothing changes, and it is counted.
    /// @return the splits and merges made, in order
    std::vector<FrontChange> update(const View& view, const RefinementBudget& budget = {});

    /// Looks at everything again with another criterion, in the updates to come.
    void setCriterion(std::shared_ptr<const Criterion> criterion);
    /// Looks at one diamond again: what the criterion knows of it has changed.
    void lookAgain(const LatticePoint& diamond);

    /// True if the last update left nothing to do for its view.
    [[nodiscard]] bool isSettled() const
    {
        return _hasView && _due.empty() && _unswept.empty() && !isWakeDue();
    }
    [[nodiscard]] const Front& front() const { return _front; }
    [[nodiscard]] const Domain& domain() const { return _domain; }
    /// Memory held by the front and by what remembers when to look again, about [bytes].
    [[nodiscard]] std::size_t bytes() const;
    [[nodiscard]] std::uint64_t refusedViews() const { return _refusedViews; }

    /// How badly a diamond wants to be split: its refinement distance over its distance from the
    /// eye; above 1 it is to be split.
    [[nodiscard]] double urgency(const LatticePoint& diamond) const
    {
        return urgency(diamond, _front.stateOf(diamond));
    }
    /// The same as if the diamond stood otherwise on the front.
    [[nodiscard]] double urgency(const LatticePoint& diamond, DiamondState state) const;
    /// These take effect where diamonds are looked at from now on; see RefinementSettings.
    void setHysteresis(double hysteresis) { _settings.hysteresis = hysteresis; }
    void setOffScreen(double share) { _settings.offScreen = share; }

private:
    struct Wake {
        double travelled; ///< path length at which the diamond is due [world]
        LatticePoint diamond;

        bool operator<(const Wake& other) const { return travelled > other.travelled; }
    };
    struct Due {
        double urgency;
        LatticePoint diamond;

        bool operator<(const Due& other) const { return urgency < other.urgency; }
    };

    void follow(const View& view);
    /// Begins to look at everything again.
    void startSweep();
    [[nodiscard]] bool isWakeDue() const
    {
        return !_asleep.empty() && _asleep.top().travelled <= _travelled;
    }
    void wakeNext();
    void test(const LatticePoint& centre, std::vector<FrontChange>& changes);
    /// Queues a diamond to be looked at as soon as the budget allows.
    void touch(const LatticePoint& centre);
    /// Lets a diamond sleep until the viewer has travelled so much further.
    void sleep(const LatticePoint& centre, double slack);
    [[nodiscard]] double distanceTo(const Diamond& diamond) const
    {
        return hierarchy::distanceTo(_domain, _stretch, diamond, _eye);
    }
    /// How far a diamond lies outside the cone of the picture, negative inside [world].
    [[nodiscard]] double outsideBy(const Diamond& diamond) const;
    /// How near the viewer must be to split a diamond, and how far he may travel before that
    /// changes.
    struct Reach {
        double distance = 0;
        double slack = kAlways;
    };
    [[nodiscard]] Reach reachOf(const Diamond& diamond, DiamondState state) const;

    Domain _domain;
    std::shared_ptr<const Criterion> _criterion;
    RefinementSettings _settings;
    double _stretch;
    Front _front;
    glm::dvec3 _eye{0.0};
    bool _hasView = false;
    glm::dvec3 _direction{0.0};         ///< of the picture's cone, rounded
    double _cone = 0;                   ///< its half angle [radians]
    std::vector<LatticePoint> _unswept; ///< what was on the front when the sweep began
    double _travelled = 0;              ///< length of the viewer's path so far [world]
    std::priority_queue<Wake> _asleep;
    std::priority_queue<Due> _due;
    /// When each known diamond wakes, or kDueNow: entries of the queues that differ are stale.
    std::unordered_map<LatticePoint, double, LatticePointHash> _wakeAt;
    std::uint64_t _refusedViews = 0;
};

} // namespace isofront::hierarchy

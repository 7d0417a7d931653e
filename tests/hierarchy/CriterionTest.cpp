#include "FrontChecks.h"
#include "support/Random.h"

#include <isofront/hierarchy/Refinement.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

namespace isofront::hierarchy {
namespace {

constexpr RefinementBudget kUnlimited{
    std::numeric_limits<std::size_t>::max(), std::numeric_limits<std::size_t>::max()};

View viewFrom(const glm::dvec3& eye, const glm::dvec3& forward = {0, 1, 0})
{
    View view;
    view.eye = eye;
    view.forward = forward;
    return view;
}

double errorOf(const Diamond& diamond, DiamondState)
{
    return 0.1 * std::exp2(-diamond.level / 3.0);
}

Front frontOf(CriterionPointer criterion, const View& view, double offScreen = 1)
{
    Refinement refinement(
        Domain{}, std::move(criterion), {.maxLevel = 40, .hysteresis = 1, .offScreen = offScreen});
    refinement.update(view, kUnlimited);
    return refinement.front();
}

glm::dvec3 placeOf(const LatticePoint& centre)
{
    return glm::dvec3(centre.x, centre.y, centre.z) / double(kLatticeEdge);
}

double radiusOf(const LatticePoint& centre)
{
    return Diamond(centre).radius() / double(kLatticeEdge);
}

TEST(FocusCriterion, refinesItsPlaceToItsErrorWhoeverLooks)
{
    Focus focus;
    focus.box = {{0.3, 0.3, 0.3}, {0.3, 0.3, 0.3}};
    focus.radius = 0.1;
    focus.error = 0.004;
    const auto criterion = std::make_shared<FocusCriterion>(Domain{}, focus, errorOf);
    const Front front = frontOf(criterion, viewFrom(glm::dvec3(50)));
    EXPECT_TRUE(front == frontOf(criterion, viewFrom({0.9, 0.9, 0.9})));
    EXPECT_EQ(tests::nonConformingFaces(front), 0U);
    std::size_t inside = 0;
    std::size_t deepOutside = 0;
    front.forEachDiamond([&](const LatticePoint& centre) {
        const double distance =
            glm::distance(placeOf(centre), glm::dvec3(0.3)) - radiusOf(centre) - 0.1;
        const double error = errorOf(Diamond(centre), {});
        if (front.isSplit(centre))
            deepOutside += distance > 0.2 && error < 4 * focus.error ? 1U : 0U;
        else if (distance < 0) {
            ++inside;
            EXPECT_LE(error, focus.error);
        }
    });
    EXPECT_GT(inside, 100U);
    EXPECT_EQ(deepOutside, 0U) << "what is far is refined for the closure's sake at most";
}

TEST(FocusCriterion, fallsOffWithDistanceAndStopsAtItsLevel)
{
    Focus focus;
    focus.box = {{0.2, 0.2, 0.2}, {0.4, 0.3, 0.3}};
    focus.error = 0.004;
    focus.falloff = 0.05;
    const Front front = frontOf(
        std::make_shared<FocusCriterion>(Domain{}, focus, errorOf), viewFrom(glm::dvec3(0)));
    front.forEachDiamond([&](const LatticePoint& centre) {
        if (front.isSplit(centre))
            return;
        const glm::dvec3 p = placeOf(centre);
        const double distance = std::max(
            0.0, glm::distance(p, glm::clamp(p, focus.box.low, focus.box.high)) - radiusOf(centre));
        EXPECT_LE(errorOf(Diamond(centre), {}), focus.error + focus.falloff * distance + 1e-12);
    });
    focus.maxLevel = 5;
    const Front shallow = frontOf(
        std::make_shared<FocusCriterion>(Domain{}, focus, errorOf), viewFrom(glm::dvec3(0)));
    shallow.forEachCell([](const CellId&, const Tetrahedron& cell) { EXPECT_LE(cell.level, 5); });
    EXPECT_LT(shallow.cellCount(), front.cellCount());
}

TEST(FocusCriterion, measuresInTheWorld)
{
    Domain stretched;
    stretched.worldFromField.linear = glm::dmat3(10.0);
    stretched.worldFromField.translation = {100, 200, 300};
    Focus focus;
    focus.box = {{103, 203, 303}, {103, 203, 303}};
    focus.radius = 1;
    focus.error = 0.04;
    const FocusCriterion there(
        stretched, focus, [](const Diamond& d, DiamondState s) { return 10 * errorOf(d, s); });
    focus.box = {{0.3, 0.3, 0.3}, {0.3, 0.3, 0.3}};
    focus.radius = 0.1;
    focus.error = 0.004;
    const FocusCriterion here(Domain{}, focus, errorOf);
    auto generator = tests::random(51);
    Front front;
    for (int i = 0; i < 60; ++i) {
        const auto leaves = tests::splittable(front);
        front.refine(leaves[tests::below(generator, leaves.size())]);
    }
    front.forEachDiamond([&](const LatticePoint& centre) {
        EXPECT_EQ(
            there.refineDistance(Diamond(centre)) > 0, here.refineDistance(Diamond(centre)) > 0);
    });
}

TEST(AnyCriterion, asksForWhatAnyOfThemAsksFor)
{
    const auto distance = std::make_shared<DistanceCriterion>(1.0, 1.2);
    const auto uniform = std::make_shared<UniformCriterion>(7);
    const View view = viewFrom({0.3, 0.4, 0.5});
    Refinement refinement(
        Domain{},
        std::make_shared<AnyCriterion>(std::vector<CriterionPointer>{distance, uniform}),
        {.maxLevel = 20});
    refinement.update(view, kUnlimited);
    Refinement first(Domain{}, distance, {.maxLevel = 20});
    first.update(view, kUnlimited);
    Front expected = first.front();
    for (bool changed = true; changed;) {
        changed = false;
        for (const LatticePoint& centre : tests::splittable(expected))
            if (Diamond(centre).level < 7) {
                expected.refine(centre);
                changed = true;
            }
    }
    EXPECT_TRUE(refinement.front() == expected);
    const AnyCriterion none{{}};
    EXPECT_EQ(none.refineDistance(Diamond(kRootDiamond)), kNever);
}

TEST(BiasedCriterion, scalesDistancesButNotDemandsWithoutOne)
{
    const auto half = [](const Diamond& diamond) {
        return diamond.centre.x < kLatticeEdge / 2 ? 0.5 : 1.0;
    };
    const auto distance = std::make_shared<DistanceCriterion>(1.0, 1.2);
    const BiasedCriterion biased(distance, half);
    const BiasedCriterion always(std::make_shared<UniformCriterion>(5), half);
    Front front;
    front.refine(tests::splittable(front).front());
    for (const LatticePoint& centre : tests::splittable(front)) {
        const Diamond diamond(centre);
        EXPECT_EQ(
            biased.refineDistance(diamond), half(diamond) * distance->refineDistance(diamond));
        EXPECT_EQ(always.refineDistance(diamond), kAlways);
    }
}

TEST(DistanceCriterion, shrinksByItsBaseFromLevelToLevel)
{
    const DistanceCriterion quick(8.0, 2.0, 0.6);
    const DistanceCriterion standard(8.0, 2.0);
    LatticePoint centre = kRootDiamond;
    for (int level = 0; level < 20; ++level) {
        const Diamond diamond(centre);
        ASSERT_EQ(diamond.level, level);
        EXPECT_NEAR(quick.refineDistance(diamond), 16 * std::pow(0.6, level), 1e-12);
        EXPECT_NEAR(standard.refineDistance(diamond), 16 * std::exp2(-level / 3.0), 1e-12);
        centre = *childrenOf(diamond).begin();
    }
}

TEST(Refinement, keepsThePictureAndLeavesTheRestCoarserIfAskedTo)
{
    const auto criterion = std::make_shared<DistanceCriterion>(1.0, 4.0);
    const double tangent = std::tan(0.5 * View{}.verticalFieldOfView);
    const double cone = std::atan(tangent * std::hypot(1.0, 1280.0 / 720.0));
    auto generator = tests::random(52);
    Refinement turning(Domain{}, criterion, {.maxLevel = 24, .hysteresis = 1, .offScreen = 0.25});
    glm::dvec3 eye(0.4, 0.4, 0.4);
    for (int i = 0; i < tests::trials(8); ++i) {
        eye += 0.02 * glm::dvec3(
                          tests::uniform(generator, -1, 1),
                          tests::uniform(generator, -1, 1),
                          tests::uniform(generator, -1, 1));
        const glm::dvec3 forward(
            tests::uniform(generator, -1, 1),
            tests::uniform(generator, -1, 1),
            tests::uniform(generator, -1, 1));
        const View view = viewFrom(eye, forward);
        Refinement whole(Domain{}, criterion, {.maxLevel = 24, .hysteresis = 1});
        whole.update(view, kUnlimited);
        turning.update(view, kUnlimited);
        EXPECT_LT(turning.front().cellCount(), whole.front().cellCount());
        EXPECT_EQ(tests::nonConformingFaces(turning.front()), 0U);
        // all that touches the picture's cone is as fine as ever
        std::size_t missing = 0;
        whole.front().forEachDiamond([&](const LatticePoint& centre) {
            if (!whole.front().isSplit(centre) || turning.front().isSplit(centre))
                return;
            const glm::dvec3 to = placeOf(centre) - eye;
            const double distance = glm::length(to);
            const double angle =
                std::acos(std::clamp(glm::dot(to / distance, glm::normalize(forward)), -1.0, 1.0));
            const double wide =
                distance > radiusOf(centre) ? std::asin(radiusOf(centre) / distance) : 4.0;
            // a parent is split for its children's sake, wherever it lies
            if (distance - radiusOf(centre) < criterion->refineDistance(Diamond(centre)) &&
                angle - wide < cone - 1e-9)
                ++missing;
        });
        EXPECT_EQ(missing, 0U);
        // and the front depends on the view, not on the turns that led to it
        Refinement fresh(Domain{}, criterion, {.maxLevel = 24, .hysteresis = 1, .offScreen = 0.25});
        fresh.update(view, kUnlimited);
        EXPECT_TRUE(turning.front() == fresh.front()) << i;
        // a small turn changes nothing
        if (turning.update(viewFrom(eye, glm::normalize(forward) + glm::dvec3(1e-9)), kUnlimited)
                .empty())
            continue;
        ADD_FAILURE() << "a turn by next to nothing made work";
    }
}

TEST(CappedCriterion, takesAwayWhatIsBeyondItsReachAndNothingElse)
{
    const auto open = std::make_shared<DistanceCriterion>(1.0, 3.0);
    auto random = tests::random(71);
    std::size_t saved = 0;
    for (int trial = 0; trial < 12; ++trial) {
        const auto place = [&] { return tests::uniform(random, -0.2, 1.2); };
        const glm::dvec3 eye(place(), place(), place());
        const double reach = tests::uniform(random, 0.0, 0.4);
        const Front all = frontOf(open, viewFrom(eye));
        const Front near = frontOf(std::make_shared<CappedCriterion>(open, reach), viewFrom(eye));
        EXPECT_EQ(tests::nonConformingFaces(near), 0U);
        const auto distance = [&](const LatticePoint& centre) {
            return std::max(0.0, glm::distance(placeOf(centre), eye) - radiusOf(centre));
        };
        std::size_t lost = 0;
        std::size_t wasted = 0;
        std::size_t invented = 0;
        near.forEachCell([&](const CellId& id, const Tetrahedron& cell) {
            const bool isWithin = std::ranges::any_of(cell.corner, [&](const LatticePoint& corner) {
                return glm::distance(placeOf(corner), eye) < reach * (1 - 1e-9);
            });
            const double wanted = open->refineDistance(Diamond(id.spine));
            lost +=
                isWithin && cell.level < 40 && distance(id.spine) < wanted * (1 - 1e-9) ? 1U : 0U;
        });
        near.forEachDiamond([&](const LatticePoint& centre) {
            invented += near.isSplit(centre) && !all.isSplit(centre) ? 1U : 0U;
            // what nothing depends on was not split for conformity
            wasted += near.isMergeable(centre) && distance(centre) > reach * (1 + 1e-9) ? 1U : 0U;
        });
        EXPECT_EQ(lost, 0U) << "what is within reach has all its detail";
        EXPECT_EQ(invented, 0U);
        EXPECT_EQ(wasted, 0U) << "what is beyond has none of its own";
        saved += all.cellCount() - near.cellCount();
    }
    EXPECT_GT(saved, 10'000U);
}

TEST(CappedCriterion, alsoCapsWhatIsAlwaysRefinedAndLeavesWhatNeverIs)
{
    Focus focus;
    focus.box = {{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}};
    focus.radius = 1;
    focus.error = 0.05;
    const auto always = std::make_shared<FocusCriterion>(Domain{}, focus, errorOf);
    const CappedCriterion capped(always, 0.75);
    EXPECT_EQ(capped.refineDistance(Diamond(kRootDiamond)), 0.75);
    const auto never = std::make_shared<UniformCriterion>(0);
    EXPECT_EQ(CappedCriterion(never, 0.75).refineDistance(Diamond(kRootDiamond)), kNever);
    const auto far = std::make_shared<DistanceCriterion>(1.0, 0.5);
    EXPECT_EQ(CappedCriterion(far, 0.75).refineDistance(Diamond(kRootDiamond)), 0.5);
}

TEST(Refinement, keepsItsAppointmentsAfterAJourneyToTheEndOfTheWorldAndBack)
{
    // A path so long that small steps would be lost in it, and one that is not finite.
    const auto criterion = std::make_shared<DistanceCriterion>(1.0, 1.5);
    for (const double away : {1e7, 1e13, 1e300}) {
        Refinement refinement(Domain{}, criterion, {.maxLevel = 60});
        glm::dvec3 eye(0.3, 0.4, 0.5);
        refinement.update(viewFrom(eye), kUnlimited);
        refinement.update(viewFrom(glm::dvec3(away)), kUnlimited);
        EXPECT_LE(refinement.front().cellCount(), 48U);
        // steps of the size of the finest cells
        for (int i = 0; i < 20; ++i) {
            eye.x += 1e-6;
            refinement.update(viewFrom(eye), kUnlimited);
        }
        Refinement fresh(Domain{}, criterion, {.maxLevel = 60});
        fresh.update(viewFrom(eye), kUnlimited);
        std::size_t missing = 0;
        fresh.front().forEachDiamond([&](const LatticePoint& centre) {
            missing +=
                fresh.front().isSplit(centre) && !refinement.front().isSplit(centre) ? 1U : 0U;
        });
        EXPECT_EQ(missing, 0U) << away;
    }
}

} // namespace
} // namespace isofront::hierarchy

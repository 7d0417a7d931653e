#include "FrontChecks.h"
#include "support/Random.h"

#include <isofront/hierarchy/Refinement.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace isofront::hierarchy {
namespace {

constexpr RefinementBudget kUnlimited{
    std::numeric_limits<std::size_t>::max(), std::numeric_limits<std::size_t>::max()};

View viewFrom(const glm::dvec3& eye)
{
    View view;
    view.eye = eye;
    return view;
}

Refinement distanceRefinement(double strength, int maxLevel, Domain domain = {})
{
    return {
        domain, std::make_shared<DistanceCriterion>(domain.edge, strength), {.maxLevel = maxLevel}};
}

TEST(Refinement, growsLinearlyWithTheLogarithmOfTheDomain)
{
    // The finest cell stays as large as it is while the domain doubles: the cells around it are the
    // same, and each doubling adds one shell.
    for (const double strength : {1.0, 2.0}) {
        std::vector<double> cells;
        for (int doublings = 6; doublings <= 12; ++doublings) {
            const double edge = std::ldexp(1.0, doublings);
            const Domain domain{glm::dvec3(-edge / 2), edge};
            Refinement refinement = distanceRefinement(strength, 3 * doublings, domain);
            refinement.update(viewFrom({0.3, 0.21, 0.13}), kUnlimited);
            ASSERT_TRUE(refinement.isSettled());
            cells.push_back(static_cast<double>(refinement.front().cellCount()));
        }
        const double increment = cells.back() - cells[cells.size() - 2];
        EXPECT_GT(increment, 100);
        for (std::size_t i = 2; i < cells.size(); ++i)
            EXPECT_EQ(cells[i] - cells[i - 1], increment) << "K = " << strength << ", " << i;
    }
}

TEST(Refinement, splitsExactlyWhatTheCriterionAsksForAndItsClosure)
{
    auto generator = tests::random(31);
    for (int trial = 0; trial < 10; ++trial) {
        const glm::dvec3 eye(
            tests::uniform(generator, -0.2, 1.2),
            tests::uniform(generator, -0.2, 1.2),
            tests::uniform(generator, -0.2, 1.2));
        Refinement refinement = distanceRefinement(1.5, 24);
        refinement.update(viewFrom(eye), kUnlimited);

        // by brute force: every diamond within reach, in any order
        Front expected;
        const DistanceCriterion criterion(1.0, 1.5);
        for (bool changed = true; changed;) {
            changed = false;
            for (const LatticePoint& centre : tests::splittable(expected)) {
                const Diamond diamond(centre);
                const glm::dvec3 c =
                    glm::dvec3(centre.x, centre.y, centre.z) / double(kLatticeEdge);
                const double distance =
                    std::max(0.0, glm::distance(c, eye) - diamond.radius() / kLatticeEdge);
                if (diamond.level < 24 && distance < criterion.refineDistance(diamond)) {
                    expected.refine(centre);
                    changed = true;
                }
            }
        }
        EXPECT_TRUE(refinement.front() == expected) << "trial " << trial;
        EXPECT_EQ(tests::nonConformingFaces(refinement.front()), 0U);
    }
}

TEST(Refinement, settlesAndThenDoesNothing)
{
    Refinement refinement = distanceRefinement(2.0, 40);
    const View view = viewFrom({0.31, 0.52, 0.47});
    EXPECT_FALSE(refinement.update(view, kUnlimited).empty());
    for (int i = 0; i < 3; ++i)
        EXPECT_TRUE(refinement.update(view, kUnlimited).empty());
}

TEST(Refinement, ignoresAViewerWhoWaversWithinTheHysteresis)
{
    const auto operationsWith = [](double hysteresis) {
        Refinement refinement(
            Domain{},
            std::make_shared<DistanceCriterion>(1.0, 2.0),
            {.maxLevel = 24, .hysteresis = hysteresis});
        const glm::dvec3 a(0.401, 0.503, 0.607);
        const glm::dvec3 b = a + glm::dvec3(0.0008, 0.0006, -0.0004);
        for (const glm::dvec3& eye : {a, b, a, b})
            refinement.update(viewFrom(eye), kUnlimited);
        std::size_t operations = 0;
        for (int i = 0; i < 20; ++i)
            operations += refinement.update(viewFrom(i % 2 == 0 ? a : b), kUnlimited).size();
        return operations;
    };
    EXPECT_EQ(operationsWith(1.2599210498948732), 0U);
    EXPECT_GT(operationsWith(1.0), 0U);
}

TEST(Refinement, endsAfterAnyPathWithinHysteresisOfTheFrontBuiltFromScratch)
{
    auto generator = tests::random(32);
    Refinement refinement = distanceRefinement(1.2, 20);
    glm::dvec3 eye(0.5);
    for (int i = 0; i < 200; ++i) {
        const bool teleport = i % 40 == 39;
        const double reach = teleport ? 0.5 : 0.02;
        for (auto* coordinate : {&eye.x, &eye.y, &eye.z})
            *coordinate =
                std::clamp(*coordinate + tests::uniform(generator, -reach, reach), 0.0, 1.0);
        refinement.update(viewFrom(eye), kUnlimited);
    }
    Refinement fresh = distanceRefinement(1.2, 20);
    fresh.update(viewFrom(eye), kUnlimited);
    // all that a fresh front splits is split, and what is split beyond that lies in the band
    std::size_t missing = 0;
    fresh.front().forEachDiamond([&](const LatticePoint& centre) {
        missing += fresh.front().isSplit(centre) && !refinement.front().isSplit(centre) ? 1U : 0U;
    });
    EXPECT_EQ(missing, 0U);
    for (const LatticePoint& centre : tests::mergeable(refinement.front()))
        EXPECT_GE(refinement.urgency(centre) * 1.26, 1.0);
    EXPECT_EQ(tests::nonConformingFaces(refinement.front()), 0U);

    // and far away everything merges again, but for what the distance still asks for
    refinement.update(viewFrom(glm::dvec3(1e12)), kUnlimited);
    EXPECT_LE(refinement.front().cellCount(), 48U);
}

TEST(Refinement, boundsTheWorkOfAnUpdateAndGoesOnInTheNext)
{
    Refinement refinement = distanceRefinement(3.0, 30);
    const View view = viewFrom({0.3, 0.4, 0.5});
    std::size_t updates = 0;
    while (!refinement.isSettled()) {
        const auto changes = refinement.update(view, {.tests = 500, .operations = 50});
        // a closure is not cut in two: 29 a level at the very most
        ASSERT_LE(changes.size(), 50U + 29U * 30U);
        ASSERT_LT(++updates, 10000U);
    }
    EXPECT_GT(updates, 20U);
    Refinement whole = distanceRefinement(3.0, 30);
    whole.update(view, kUnlimited);
    EXPECT_TRUE(refinement.front() == whole.front());
}

TEST(Refinement, refusesViewsThatAreNotNumbers)
{
    Refinement refinement = distanceRefinement(1.0, 30);
    refinement.update(viewFrom({0.5, 0.5, 0.5}), kUnlimited);
    const std::size_t cells = refinement.front().cellCount();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(refinement.update(viewFrom({nan, 0, 0}), kUnlimited).empty());
    EXPECT_TRUE(refinement.update(viewFrom({0, infinite, 0}), kUnlimited).empty());
    EXPECT_EQ(refinement.refusedViews(), 2U);
    EXPECT_EQ(refinement.front().cellCount(), cells);
}

TEST(Refinement, stopsAtTheLevelCapWithTheViewerOnALatticePoint)
{
    Refinement refinement = distanceRefinement(1.0, kMaxLevel);
    refinement.update(viewFrom({0.5, 0.5, 0.5}), kUnlimited);
    int deepest = 0;
    refinement.front().forEachCell(
        [&](const CellId&, const Tetrahedron& cell) { deepest = std::max(deepest, cell.level); });
    EXPECT_EQ(deepest, kMaxLevel);
    EXPECT_EQ(tests::nonConformingFaces(refinement.front()), 0U);
}

TEST(Refinement, takesDistancesThroughTheWorldsMap)
{
    // the same scene, once in a cube of edge 1 and once stretched to 1000 and turned about z
    Domain stretched;
    stretched.worldFromField.linear = glm::dmat3(0, 1000, 0, -1000, 0, 0, 0, 0, 1000);
    stretched.worldFromField.translation = {5e6, -2e6, 1e6};
    const glm::dvec3 eye(0.3, 0.6, 0.2);
    Refinement plain = distanceRefinement(2.0, 24);
    Refinement turned(
        stretched, std::make_shared<DistanceCriterion>(1000.0, 2.0), {.maxLevel = 24});
    plain.update(viewFrom(eye), kUnlimited);
    turned.update(viewFrom(stretched.worldFromField.point(eye)), kUnlimited);
    EXPECT_TRUE(plain.front() == turned.front());
}

TEST(ProjectedErrorCriterion, refinesUntilTheProjectedErrorIsSmallAndNeverWhereThereIsNone)
{
    View view = viewFrom({0.5, 0.5, -1.0});
    const double pixels = 2.0;
    // a surface in the lower half only, whose error is a tenth of the cell's size
    const auto estimate = [](const Diamond& diamond, DiamondState) {
        return diamond.centre.x < kLatticeEdge / 2 ? 0.1 * std::exp2(-diamond.level / 3.0) : 0.0;
    };
    Refinement refinement(
        Domain{},
        std::make_shared<ProjectedErrorCriterion>(estimate, view.pixelsPerUnit(), pixels),
        {.maxLevel = 60});
    // the root's centre lies in the upper half: split it by hand through a first, uniform criterion
    refinement.setCriterion(std::make_shared<UniformCriterion>(3));
    refinement.update(view, kUnlimited);
    refinement.setCriterion(
        std::make_shared<ProjectedErrorCriterion>(estimate, view.pixelsPerUnit(), pixels));
    refinement.update(view, kUnlimited);
    refinement.front().forEachDiamond([&](const LatticePoint& centre) {
        if (refinement.front().isSplit(centre))
            return;
        EXPECT_LE(refinement.urgency(centre), 1.0);
    });
    EXPECT_GT(refinement.front().cellCount(), 100U);
}

} // namespace
} // namespace isofront::hierarchy

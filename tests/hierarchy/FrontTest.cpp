#include "FrontChecks.h"
#include "support/Random.h"

#include <isofront/hierarchy/Front.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace isofront::hierarchy {
namespace {

TEST(Front, staysConformingThroughThousandsOfRandomSplitsAndMerges)
{
    auto generator = tests::random(21);
    Front front;
    std::size_t operations = 0;
    for (int round = 0; round < 40 * tests::intensity(); ++round) {
        for (int i = 0; i < 100; ++i) {
            const bool coarsen = tests::below(generator, 3) == 0;
            const auto candidates = coarsen ? tests::mergeable(front) : tests::splittable(front);
            if (candidates.empty())
                continue;
            const LatticePoint& chosen = candidates[tests::below(generator, candidates.size())];
            if (coarsen) {
                front.merge(chosen);
                ++operations;
            } else {
                operations += front.refine(chosen).size();
            }
        }
        ASSERT_EQ(tests::nonConformingFaces(front), 0U) << "round " << round;
        ASSERT_TRUE(tests::tilesTheDomain(front)) << "round " << round;
    }
    EXPECT_GT(operations, 4000U);

    // everything that can be merged, until nothing is left to merge: the root, bit for bit
    while (front.splitCount() > 0)
        for (const LatticePoint& centre : tests::mergeable(front))
            if (front.isMergeable(centre))
                front.merge(centre);
    EXPECT_TRUE(front == Front());
    EXPECT_EQ(front.cellCount(), 6U);
}

TEST(Front, isCompleteExactlyWhereAllParentsAreSplit)
{
    auto generator = tests::random(22);
    Front front;
    for (int i = 0; i < 300; ++i) {
        const auto candidates = tests::splittable(front);
        front.refine(candidates[tests::below(generator, candidates.size())]);
    }
    front.forEachDiamond([&](const LatticePoint& centre) {
        bool parentsSplit = true;
        for (const LatticePoint& parent : parentsOf(Diamond(centre)))
            parentsSplit = parentsSplit && front.isSplit(parent);
        if (front.isSplit(centre))
            EXPECT_TRUE(parentsSplit);
        else
            EXPECT_EQ(front.isComplete(centre), parentsSplit);
    });
}

TEST(Front, isTheSameForEveryOrderOfRequests)
{
    auto generator = tests::random(23);
    std::vector<LatticePoint> requests;
    for (int i = 0; i < 132; ++i) {
        Tetrahedron cell = rootTetrahedra()[tests::below(generator, 6)];
        const auto depth = 5 + static_cast<int>(tests::below(generator, 25));
        while (cell.level < depth)
            cell = cell.bisected()[tests::below(generator, 2)];
        requests.push_back(cell.spineCentre());
    }
    Front first;
    for (const LatticePoint& request : requests)
        first.refine(request);
    EXPECT_EQ(tests::nonConformingFaces(first), 0U);
    for (int order = 0; order < 5; ++order) {
        std::shuffle(requests.begin(), requests.end(), generator);
        Front other;
        for (const LatticePoint& request : requests)
            other.refine(request);
        ASSERT_TRUE(first == other);
        ASSERT_EQ(first.splitCount(), other.splitCount());
    }
}

TEST(Front, reachesTheDeepestLevelAndComesBack)
{
    auto generator = tests::random(24);
    for (int trial = 0; trial < 4; ++trial) {
        Tetrahedron cell = rootTetrahedra()[tests::below(generator, 6)];
        while (cell.level < kMaxLevel - 1)
            cell = cell.bisected()[tests::below(generator, 2)];
        Front front;
        const std::size_t splits = front.refine(cell.spineCentre()).size();
        // linear in the level: about 26 to 29 a level, inside the domain
        EXPECT_GT(splits, 91U);
        EXPECT_LT(splits, 3000U);
        EXPECT_TRUE(front.refine(cell.spineCentre()).empty()) << "a second request does nothing";
        int deepest = 0;
        front.forEachCell(
            [&](const CellId&, const Tetrahedron& t) { deepest = std::max(deepest, t.level); });
        EXPECT_EQ(deepest, kMaxLevel);
        EXPECT_EQ(tests::nonConformingFaces(front), 0U);
        EXPECT_TRUE(tests::tilesTheDomain(front));
        while (front.splitCount() > 0)
            for (const LatticePoint& centre : tests::mergeable(front))
                front.merge(centre);
        EXPECT_TRUE(front == Front());
    }
}

} // namespace
} // namespace isofront::hierarchy

#include "Crosshair.h"

#include "CrosshairKernel.h"
#include "TriangleParts.h"
#include "fields/FieldChecks.h"
#include "support/Random.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace isofront::voxels {
namespace {

using Cube = std::array<std::int64_t, 3>;
constexpr VoxelRange kAll{{-40, -40, -40}, {40, 40, 40}};

/// Corners on voxels' borders and middles more often than not, where ties have to be broken.
LatticePoint anyPoint(std::mt19937_64& random, std::int64_t reach)
{
    LatticePoint point{};
    for (std::int64_t& c : point) {
        const auto voxel =
            static_cast<std::int64_t>(tests::below(random, static_cast<std::size_t>(2 * reach))) -
            reach;
        const std::size_t kind = tests::below(random, 4);
        c = voxel * kSteps + (kind == 0 ? 0
                              : kind == 1
                                  ? kSteps / 2
                                  : static_cast<std::int64_t>(tests::below(random, kSteps)));
    }
    return point;
}

TEST(Crosshair, closedSurfacesAreEnteredAsOftenAsTheyAreLeft)
{
    auto random = tests::random(1);
    for (int trial = 0; trial < tests::trials(300); ++trial) {
        std::array<LatticePoint, 4> corners{};
        for (LatticePoint& corner : corners)
            corner = anyPoint(random, 12);
        std::map<std::array<std::int64_t, 3>, int> crossings; // of lines
        for (const auto& face : {std::array{0U, 1U, 2U}, {0U, 3U, 1U}, {1U, 3U, 2U}, {2U, 3U, 0U}})
            forEachCrosshair(
                {corners[face[0]], corners[face[1]], corners[face[2]]},
                kAll,
                [&](auto x, auto y, auto z, std::size_t axis) {
                    Cube line{x, y, z};
                    line[axis] = 1000 + static_cast<std::int64_t>(axis);
                    ++crossings[line];
                });
        for (const auto& [line, count] : crossings)
            EXPECT_EQ(count % 2, 0) << trial;
    }
}

/// The distance along a line through a voxel's middle, in rationals of 128 bits: by definition.
TEST(Crosshair, isWhereTheLineMeetsTheTriangle)
{
    auto random = tests::random(2);
    for (int trial = 0; trial < tests::trials(200); ++trial) {
        const LatticeTriangle triangle{
            anyPoint(random, 4), anyPoint(random, 4), anyPoint(random, 4)};
        const auto area = doubleArea(triangle);
        std::multiset<Cube> found;
        forEachCrosshair(triangle, kAll, [&](auto x, auto y, auto z, std::size_t) {
            found.insert({x, y, z});
        });
        std::multiset<Cube> sure;     // strictly inside, along each axis
        std::multiset<Cube> possible; // edges included
        for (std::size_t w = 0; w < 3; ++w) {
            if (area[w] == 0)
                continue;
            const std::size_t u = (w + 1) % 3;
            const std::size_t v = (w + 2) % 3;
            for (std::int64_t i = -6; i < 6; ++i)
                for (std::int64_t j = -6; j < 6; ++j) {
                    const std::int64_t pu = i * kSteps + kSteps / 2;
                    const std::int64_t pv = j * kSteps + kSteps / 2;
                    std::array<std::int64_t, 3> part{};
                    for (std::size_t k = 0; k < 3; ++k) {
                        const auto& a = triangle[(k + 1) % 3];
                        const auto& b = triangle[(k + 2) % 3];
                        part[k] = (a[u] - pu) * (b[v] - pv) - (a[v] - pv) * (b[u] - pu);
                    }
                    const auto sign = [](std::int64_t x) { return (x > 0) - (x < 0); };
                    const int side = sign(area[w]);
                    bool in = true;
                    bool on = true;
                    for (const std::int64_t p : part) {
                        in = in && sign(p) == side;
                        on = on && sign(p) != -side;
                    }
                    if (!on)
                        continue;
                    Wide sum = 0;
                    for (std::size_t k = 0; k < 3; ++k)
                        sum += static_cast<Wide>(part[k]) * triangle[k][w];
                    Cube cube{};
                    cube[u] = i;
                    cube[v] = j;
                    cube[w] = static_cast<std::int64_t>(
                        floorDivide<Wide>(side * sum, static_cast<Wide>(side * area[w]) * kSteps));
                    possible.insert(cube);
                    if (in)
                        sure.insert(cube);
                }
        }
        EXPECT_TRUE(std::ranges::includes(found, sure)) << trial;
        EXPECT_TRUE(std::ranges::includes(possible, found)) << trial;
    }
}

/// Of small triangles several rows are looked at together.
TEST(Crosshair, isTheSameForSeveralRowsAtATimeOnAllInstructionSets)
{
    auto random = tests::random(4);
    std::vector<LatticeTriangle> triangles;
    while (triangles.size() < static_cast<std::size_t>(tests::trials(2'000))) {
        const std::int64_t reach = tests::below(random, 2) == 0 ? 2 : 8;
        LatticeTriangle triangle{
            anyPoint(random, reach), anyPoint(random, reach), anyPoint(random, reach)};
        if (hasSmallCrosshairs(triangle))
            triangles.push_back(triangle);
    }
    const VoxelRange within{{-3, -7, -8}, {8, 5, 2}};
    fields::test::onEveryInstructionSet([&](const std::string& set) {
        std::size_t hits = 0;
        for (const LatticeTriangle& triangle : triangles) {
            std::multiset<Cube> expected;
            forEachCrosshair(triangle, within, [&](auto x, auto y, auto z, std::size_t) {
                expected.insert({x, y, z});
            });
            CrosshairHits places{};
            const std::size_t count = findCrosshairs(triangle, within, places);
            std::multiset<Cube> found;
            for (std::size_t i = 0; i < count; ++i) {
                Cube cube = within.low;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    cube[axis] += places[i] >> (kPlaceBits * axis) & ((1 << kPlaceBits) - 1);
                found.insert(cube);
            }
            EXPECT_EQ(found, expected) << set;
            hits += found.size();
        }
        EXPECT_GT(hits, triangles.size()) << set;
    });
    LatticeTriangle large{{{0, 0, 0}, {16 * kSteps, 0, 0}, {0, 1, 0}}};
    EXPECT_FALSE(hasSmallCrosshairs(large));
}

TEST(Crosshair, isTouchedByTheTriangle)
{
    auto random = tests::random(3);
    std::vector<TrianglePart> scratch;
    for (int trial = 0; trial < tests::trials(500); ++trial) {
        const LatticeTriangle triangle{
            anyPoint(random, 8), anyPoint(random, 8), anyPoint(random, 8)};
        std::set<Cube> touched;
        forEachTouched(
            triangle, kAll, false, scratch, [&](auto x, auto y, auto z, const TrianglePart&) {
                touched.insert({x, y, z});
            });
        forEachCrosshair(triangle, kAll, [&](auto x, auto y, auto z, std::size_t) {
            EXPECT_TRUE(touched.contains({x, y, z})) << trial;
        });
    }
}

} // namespace
} // namespace isofront::voxels

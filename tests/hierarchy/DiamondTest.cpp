#include "support/Random.h"

#include <isofront/hierarchy/Diamond.h>
#include <isofront/hierarchy/Front.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace isofront::hierarchy {
namespace {

__extension__ typedef __int128 Integer; // products of three 32-bit coordinates

Integer squaredLength(const LatticePoint& a, const LatticePoint& b)
{
    Integer sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Integer d = Integer{a[axis]} - Integer{b[axis]};
        sum += d * d;
    }
    return sum;
}

bool isInterior(const Diamond& diamond)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (diamond.centre[axis] < diamond.halfEdge ||
            diamond.centre[axis] > kLatticeEdge - diamond.halfEdge)
            return false;
    return true;
}

/// All tetrahedra of each level by explicit bisection, grouped by the centre of their spine: the
/// independent reference for everything that Diamond derives from bits.
std::map<LatticePoint, std::vector<Tetrahedron>> diamondsOfLevel(int level)
{
    std::vector<Tetrahedron> cells;
    for (const Tetrahedron& root : rootTetrahedra())
        cells.push_back(root);
    for (int l = 0; l < level; ++l) {
        std::vector<Tetrahedron> halves;
        for (const Tetrahedron& cell : cells)
            for (const Tetrahedron& half : cell.bisected())
                halves.push_back(half);
        cells.swap(halves);
    }
    std::map<LatticePoint, std::vector<Tetrahedron>> diamonds;
    for (const Tetrahedron& cell : cells)
        diamonds[cell.spineCentre()].push_back(cell);
    return diamonds;
}

TEST(Diamond, derivesFromItsCentreWhatExplicitBisectionGives)
{
    std::size_t all = 0;
    std::array<std::size_t, 12> interior{};
    for (int level = 0; level < 12; ++level) {
        for (auto& [centre, expected] : diamondsOfLevel(level)) {
            ++all;
            const Diamond diamond(centre);
            ASSERT_EQ(diamond.level, level);
            const DiamondTetrahedra got = tetrahedraOf(diamond);
            ASSERT_EQ(got.size(), expected.size());
            for (std::size_t i = 0; i < got.size(); ++i) {
                ASSERT_TRUE(std::ranges::find(expected, got.tetrahedron(i)) != expected.end());
                ASSERT_EQ(cellIdOf(got.tetrahedron(i)), (CellId{centre, got.index(i)}));
                ASSERT_EQ(tetrahedronOf({centre, got.index(i)}), got.tetrahedron(i));
            }
            if (isInterior(diamond)) {
                ++interior[static_cast<std::size_t>(level)];
                constexpr std::array<std::size_t, 3> kTetrahedra{6, 4, 8};
                constexpr std::array<std::size_t, 3> kVertices{8, 6, 10};
                constexpr std::array<std::size_t, 3> kParents{3, 2, 4};
                const auto c = static_cast<std::size_t>(diamond.congruenceClass());
                std::set<LatticePoint> vertices;
                for (const Tetrahedron& t : expected)
                    vertices.insert(t.corner.begin(), t.corner.end());
                ASSERT_EQ(got.size(), kTetrahedra[c]);
                ASSERT_EQ(vertices.size(), kVertices[c]);
                ASSERT_EQ(parentsOf(diamond).size(), level == 0 ? 0 : kParents[c]);
                ASSERT_EQ(childrenOf(diamond).size(), kTetrahedra[c]);
            }
            for (const Tetrahedron& t : expected)
                for (const LatticePoint& corner : t.corner)
                    ASSERT_LE(
                        std::sqrt(static_cast<double>(squaredLength(corner, centre))),
                        diamond.radius() * (1 + 1e-12));
        }
    }
    EXPECT_EQ(all, 4905U);
    // 585 / 1500 / 1290 interior diamonds of the three classes over cube levels 0 to 3
    EXPECT_EQ(interior[0] + interior[3] + interior[6] + interior[9], 585U);
    EXPECT_EQ(interior[1] + interior[4] + interior[7] + interior[10], 1500U);
    EXPECT_EQ(interior[2] + interior[5] + interior[8] + interior[11], 1290U);
}

TEST(Diamond, hasAsChildrenAndParentsThoseOfItsTetrahedra)
{
    for (int level = 0; level < 9; ++level)
        for (const auto& [centre, cells] : diamondsOfLevel(level)) {
            std::set<LatticePoint> expected;
            for (const Tetrahedron& cell : cells)
                for (const Tetrahedron& half : cell.bisected())
                    expected.insert(half.spineCentre());
            const LatticePoints got = childrenOf(Diamond(centre));
            ASSERT_EQ(std::set<LatticePoint>(got.begin(), got.end()), expected);
            for (const LatticePoint& child : got) {
                const LatticePoints parents = parentsOf(Diamond(child));
                ASSERT_TRUE(std::find(parents.begin(), parents.end(), centre) != parents.end());
            }
        }
}

TEST(Diamond, isItsChildrensParentAtEveryDepth)
{
    auto generator = tests::random(11);
    for (int trial = 0; trial < 2000 * tests::intensity(); ++trial) {
        Tetrahedron cell = rootTetrahedra()[tests::below(generator, 6)];
        while (cell.level < kMaxLevel) {
            const Diamond diamond(cell.spineCentre());
            ASSERT_EQ(diamond.level, cell.level);
            ASSERT_EQ(diamond.spineBegin, cell.corner[0]);
            ASSERT_EQ(diamond.spineFinish, cell.corner[cell.spineEnd()]);
            const Tetrahedron half = cell.bisected()[tests::below(generator, 2)];
            const LatticePoints children = childrenOf(diamond);
            ASSERT_TRUE(
                std::find(children.begin(), children.end(), half.spineCentre()) != children.end());
            const LatticePoints parents = parentsOf(Diamond(half.spineCentre()));
            ASSERT_TRUE(std::find(parents.begin(), parents.end(), diamond.centre) != parents.end());
            cell = half;
        }
        ASSERT_EQ(Diamond(cell.spineCentre()).level, kMaxLevel);
    }
}

TEST(Tetrahedron, hasOneOfThreeShapesAndHalfItsParentsVolume)
{
    // squared edge lengths over the longest, in twenty-fourths, sorted
    const std::array<std::multiset<int>, 3> shapes{
        std::multiset<int>{8, 8, 8, 16, 16, 24}, {9, 9, 9, 12, 12, 24}, {6, 12, 12, 18, 18, 24}};
    auto generator = tests::random(12);
    for (int trial = 0; trial < 500; ++trial) {
        Tetrahedron cell = rootTetrahedra()[tests::below(generator, 6)];
        Integer volume = 0;
        while (true) {
            const Integer longest = squaredLength(cell.corner[0], cell.corner[cell.spineEnd()]);
            std::multiset<int> lengths;
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t j = i + 1; j < 4; ++j) {
                    const Integer squared = squaredLength(cell.corner[i], cell.corner[j]);
                    ASSERT_EQ(squared * 24 % longest, 0);
                    lengths.insert(static_cast<int>(squared * 24 / longest));
                    // the spine is the only longest edge
                    const bool isSpine = i == 0 && j == cell.spineEnd();
                    ASSERT_EQ(squared == longest, isSpine);
                }
            ASSERT_EQ(lengths, shapes[static_cast<std::size_t>(cell.level % 3)]);

            std::array<std::array<Integer, 3>, 3> d{};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    d[i][axis] = Integer{cell.corner[i + 1][axis]} - Integer{cell.corner[0][axis]};
            const Integer determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                                        d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                                        d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
            ASSERT_EQ(determinant < 0, cell.isMirrored());
            const Integer magnitude = determinant < 0 ? -determinant : determinant;
            if (cell.level > 0) {
                ASSERT_EQ(2 * magnitude, volume);
            }
            volume = magnitude;
            if (cell.level == kMaxLevel)
                break;
            cell = cell.bisected()[tests::below(generator, 2)];
        }
    }
}

} // namespace
} // namespace isofront::hierarchy

#include "TriangleParts.h"

#include "TriangleSlices.h"
#include "fields/FieldChecks.h"
#include "support/Random.h"

#include <gtest/gtest.h>

#include <map>

namespace isofront::voxels {
namespace {

using Cube = std::array<std::int64_t, 3>;
constexpr VoxelRange kRange{{-6, -4, -9}, {10, 12, 7}};

/// Corners on voxels' borders more often than not, where what is touched is hard to tell, and
/// often in one plane with others.
LatticePoint anyPoint(std::mt19937_64& random, std::int64_t reach)
{
    LatticePoint point{};
    for (std::int64_t& c : point) {
        const auto voxel =
            static_cast<std::int64_t>(tests::below(random, static_cast<std::size_t>(2 * reach))) -
            reach;
        const std::size_t kind = tests::below(random, 5);
        c = voxel * kSteps;
        if (kind == 0)
            c += static_cast<std::int64_t>(tests::below(random, 3)) - 1; // all but on the border
        else if (kind > 2)
            c += static_cast<std::int64_t>(tests::below(random, kSteps));
    }
    return point;
}

/// From tiny ones, and such that are but lines or points, to those that reach far out of the range.
LatticeTriangle anyTriangle(std::mt19937_64& random)
{
    const std::array<std::int64_t, 5> reaches{1, 4, 12, 300, 60'000};
    const std::int64_t reach = reaches[tests::below(random, reaches.size())];
    LatticeTriangle triangle{
        anyPoint(random, reach), anyPoint(random, reach), anyPoint(random, reach)};
    switch (tests::below(random, 8)) {
    case 0: // a point, or nearly
        triangle[1] = triangle[0];
        break;
    case 1: // a line
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t third = (triangle[1][axis] - triangle[0][axis]) / 3;
            triangle[1][axis] = triangle[0][axis] + 3 * third;
            triangle[2][axis] = triangle[0][axis] + 2 * third;
        }
        break;
    case 2: { // across an axis
        const std::size_t axis = tests::below(random, 3);
        triangle[2][axis] = triangle[1][axis] = triangle[0][axis];
        break;
    }
    case 3: // a needle
        for (std::size_t axis = 0; axis < 3; ++axis)
            triangle[2][axis] =
                triangle[1][axis] + static_cast<std::int64_t>(tests::below(random, 3)) - 1;
        break;
    default:
        break;
    }
    return triangle;
}

struct Divided {
    std::map<Cube, TrianglePart> parts;
    bool areDistinct = true;
};

Divided divided(const LatticeTriangle& triangle, const VoxelRange& within, bool centroids)
{
    Divided result;
    std::vector<TrianglePart> scratch;
    forEachTouched(
        triangle,
        within,
        centroids,
        scratch,
        [&](std::int64_t x, std::int64_t y, std::int64_t z, const TrianglePart& part) {
            const bool isNew = result.parts.emplace(Cube{x, y, z}, part).second;
            result.areDistinct = result.areDistinct && isNew;
        });
    return result;
}

std::array<glm::dvec3, 3> cornersOf(const LatticeTriangle& triangle)
{
    std::array<glm::dvec3, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[k][static_cast<glm::length_t>(axis)] =
                static_cast<double>(triangle[k][axis]) / static_cast<double>(kSteps);
    return corners;
}

TEST(TriangleParts, areThoseOfExactlyTheCubesThatTheTriangleMeets)
{
    auto random = tests::random(11);
    std::size_t touching = 0;
    for (int trial = 0; trial < tests::trials(1'000); ++trial) {
        const LatticeTriangle triangle = anyTriangle(random);
        const Divided found = divided(triangle, kRange, trial % 2 == 0);
        EXPECT_TRUE(found.areDistinct) << trial;
        Cube cube{};
        for (cube[0] = kRange.low[0]; cube[0] < kRange.high[0]; ++cube[0])
            for (cube[1] = kRange.low[1]; cube[1] < kRange.high[1]; ++cube[1])
                for (cube[2] = kRange.low[2]; cube[2] < kRange.high[2]; ++cube[2]) {
                    ASSERT_EQ(found.parts.contains(cube), touches(triangle, cube))
                        << trial << ": " << cube[0] << ", " << cube[1] << ", " << cube[2];
                }
        for (const auto& [place, part] : found.parts)
            touching += part.area == 0 ? 1U : 0U;
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(touching, 1'000U);
    }
}

/// The same by cutting polygons out of the triangle.
TEST(TriangleParts, haveTheAreasAndCentroidsOfThePolygonsThatCutsLeave)
{
    auto random = tests::random(12);
    double most = 0;
    for (int trial = 0; trial < tests::trials(1'000); ++trial) {
        const LatticeTriangle triangle = anyTriangle(random);
        const std::array<glm::dvec3, 3> corners = cornersOf(triangle);
        const glm::dvec3 area = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double size = glm::length(area);
        const glm::dvec3 normal = size > 0 ? area / size : glm::dvec3(0);
        const Divided plain = divided(triangle, kRange, false);
        const Divided found = divided(triangle, kRange, true);
        ASSERT_EQ(plain.parts.size(), found.parts.size());
        // numbers of that size are rounded as much
        const double tolerance = 1e-10 * (1 + glm::length(corners[0]) + glm::length(corners[1]));
        std::map<Cube, double> expected;
        forEachPiece(corners, kRange, [&](auto x, auto y, auto z, const Piece& piece) {
            const Piece::Mass mass = piece.mass(normal);
            expected[{x, y, z}] = mass.area;
            const auto part = found.parts.find({x, y, z});
            if (part == found.parts.end() || mass.area < 1e-3)
                return;
            const double off = glm::length(part->second.offset - (mass.centroid - corners[0]));
            EXPECT_LT(off, 1e3 * tolerance) << trial;
            most = std::max(most, off);
        });
        for (const auto& [cube, part] : found.parts) {
            ASSERT_TRUE(expected.contains(cube)) << trial;
            EXPECT_NEAR(part.area, expected.at(cube), tolerance) << trial;
            EXPECT_EQ(part.area, plain.parts.at(cube).area);
        }
        for (const auto& [cube, size_of] : expected)
            if (!found.parts.contains(cube)) {
                EXPECT_LT(size_of, tolerance) << trial;
            }
    }
    EXPECT_GT(most, 0);
}

TEST(TriangleParts, addUpToTheTriangle)
{
    auto random = tests::random(13);
    constexpr VoxelRange kAll{{-20, -20, -20}, {20, 20, 20}};
    for (int trial = 0; trial < tests::trials(1'000); ++trial) {
        const LatticeTriangle triangle{
            anyPoint(random, 12), anyPoint(random, 12), anyPoint(random, 12)};
        const std::array<glm::dvec3, 3> corners = cornersOf(triangle);
        const double size =
            0.5 * glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        double sum = 0;
        glm::dvec3 moment(0);
        double slivers = 0; // whose offsets are known to within a voxel
        for (const auto& [cube, part] : divided(triangle, kAll, true).parts) {
            sum += part.area;
            moment += part.area * part.offset;
            slivers += part.area < kSurelyTouched ? part.area : 0;
        }
        EXPECT_NEAR(sum, size, 1e-11 * (1 + size)) << trial;
        const glm::dvec3 centroid = (corners[1] - corners[0] + corners[2] - corners[0]) / 3.0;
        EXPECT_LT(glm::length(moment - size * centroid), 1e-9 * (1 + size) + 2 * slivers) << trial;
    }
}

TEST(TriangleParts, areTheSameBitsOnAllInstructionSets)
{
    std::vector<LatticeTriangle> triangles;
    auto random = tests::random(14);
    for (int i = 0; i < tests::trials(300); ++i)
        triangles.push_back(anyTriangle(random));
    std::vector<Divided> first;
    fields::test::onEveryInstructionSet([&](const std::string& set) {
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            Divided own = divided(triangles[i], kRange, true);
            if (first.size() <= i)
                first.push_back(std::move(own));
            else {
                ASSERT_EQ(own.parts.size(), first[i].parts.size()) << set;
                for (const auto& [cube, part] : first[i].parts) {
                    ASSERT_TRUE(own.parts.contains(cube));
                    EXPECT_EQ(own.parts.at(cube).area, part.area) << set;
                    EXPECT_EQ(own.parts.at(cube).offset, part.offset) << set;
                }
            }
        }
    });
    EXPECT_FALSE(first.empty());
}

} // namespace
} // namespace isofront::voxels

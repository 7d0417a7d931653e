#include <isofront/extractor/MarchingCubesTable.h>
#include <isofront/extractor/VolumeMesh.h>
#include <isofront/hierarchy/Diamond.h>

#include <glm/vec3.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <numeric>
#include <set>
#include <vector>

namespace isofront::extractor {
namespace {

TEST(MarchingCubesTable, hasTheKnownNumbersOfTriangles)
{
    const MarchingCubesTable& table = MarchingCubesTable::instance();
    std::array<int, 6> histogram{};
    int total = 0;
    for (unsigned c = 0; c < 256; ++c) {
        const int triangles = table[static_cast<std::uint8_t>(c)].triangles;
        ASSERT_LE(triangles, 5);
        ++histogram[static_cast<std::size_t>(triangles)];
        total += triangles;
    }
    EXPECT_EQ(total, 820);
    EXPECT_EQ(histogram, (std::array<int, 6>{2, 16, 50, 80, 76, 32}));
}

TEST(MarchingCubesTable, usesExactlyTheEdgesWhoseEndsDiffer)
{
    for (unsigned c = 0; c < 256; ++c) {
        std::set<std::uint8_t> used;
        const auto& entry = MarchingCubesTable::instance()[static_cast<std::uint8_t>(c)];
        for (std::size_t i = 0; i < entry.triangles; ++i)
            used.insert(entry.edge[i].begin(), entry.edge[i].end());
        for (std::uint8_t e = 0; e < 12; ++e) {
            const bool differ =
                ((c >> kHexahedronEdges[e][0]) & 1U) != ((c >> kHexahedronEdges[e][1]) & 1U);
            ASSERT_EQ(used.contains(e), differ);
        }
    }
}

/// Each line between two edges of the hexahedron, with how often triangles run along it each way.
std::map<std::array<std::uint8_t, 2>, std::array<int, 2>> linesOf(unsigned configuration)
{
    std::map<std::array<std::uint8_t, 2>, std::array<int, 2>> lines;
    const auto& entry = MarchingCubesTable::instance()[static_cast<std::uint8_t>(configuration)];
    for (std::size_t i = 0; i < entry.triangles; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint8_t a = entry.edge[i][k];
            const std::uint8_t b = entry.edge[i][(k + 1) % 3];
            ++lines[{std::min(a, b), std::max(a, b)}][a < b ? 0 : 1];
        }
    return lines;
}

TEST(MarchingCubesTable, letsNeighboursMeetInTheSameLinesRunTheOtherWay)
{
    // the lines on a side, as ordered pairs of points on its edges, named by corners of the side
    const auto linesOnSide = [](unsigned configuration, std::size_t side) {
        std::set<std::array<int, 2>> result;
        const auto& corners = kHexahedronFaces[side];
        std::map<std::uint8_t, int> name;
        for (int i = 0; i < 4; ++i)
            name[hexahedronEdge(
                corners[static_cast<std::size_t>(i)],
                corners[static_cast<std::size_t>((i + 1) % 4)])] = i;
        for (const auto& [line, uses] : linesOf(configuration)) {
            if (!name.contains(line[0]) || !name.contains(line[1]))
                continue;
            // a line within a side is the border of exactly one triangle
            EXPECT_EQ(uses[0] + uses[1], 1) << configuration;
            const bool forward = uses[0] == 1;
            result.insert(
                forward ? std::array{name[line[0]], name[line[1]]}
                        : std::array{name[line[1]], name[line[0]]});
        }
        return result;
    };
    // side 1 (high x) of one hexahedron is side 0 (low x) of the next; y and z likewise
    constexpr std::array<std::array<std::size_t, 2>, 3> kOpposite{{{1, 0}, {3, 2}, {5, 4}}};
    for (const auto& [high, low] : kOpposite)
        for (unsigned signs = 0; signs < 16; ++signs) {
            // the same four corners seen from both hexahedra; all fillings of the other four agree
            const auto configurationsWith = [&](std::size_t side, bool mirrored) {
                std::vector<unsigned> result;
                for (unsigned c = 0; c < 256; ++c) {
                    bool fits = true;
                    for (unsigned i = 0; i < 4; ++i) {
                        const unsigned at = mirrored ? (4 - i) % 4 : i;
                        fits =
                            fits && ((c >> kHexahedronFaces[side][i]) & 1U) == ((signs >> at) & 1U);
                    }
                    if (fits)
                        result.push_back(c);
                }
                return result;
            };
            std::set<std::set<std::array<int, 2>>> seen;
            for (const unsigned c : configurationsWith(high, false))
                seen.insert(linesOnSide(c, high));
            ASSERT_EQ(seen.size(), 1U);
            for (const unsigned c : configurationsWith(low, true)) {
                std::set<std::array<int, 2>> turned;
                for (const auto& [a, b] : linesOnSide(c, low))
                    turned.insert({3 - b, 3 - a}); // edge i of one cycle is edge 3 - i of the other
                ASSERT_EQ(turned, *seen.begin());
            }
        }
}

class VolumeMeshTest : public testing::TestWithParam<int> {};

TEST_P(VolumeMeshTest, hasTheCountsOfTheClosedForms)
{
    const auto n = static_cast<std::size_t>(GetParam());
    const VolumeMesh& mesh = VolumeMesh::ofSize(GetParam());
    EXPECT_EQ(mesh.vertexCount(), 4 * n * n * n + 6 * n * n + 4 * n + 1);
    EXPECT_EQ(mesh.edges.size(), 12 * n * n * n + 12 * n * n + 4 * n);
    EXPECT_EQ(mesh.hexahedra.size(), 4 * n * n * n);
    std::array<std::size_t, 5> byZeros{};
    for (const FeatureMask feature : mesh.vertexFeature)
        ++byZeros[static_cast<std::size_t>(std::popcount(static_cast<unsigned>(feature)))];
    EXPECT_EQ(byZeros[1] + byZeros[2] + byZeros[3], 12 * n * n + 2);
    EXPECT_EQ(byZeros[2] + 2 * byZeros[3] / 4 * 6, 6 * (2 * n + 1))
        << "points on edges, ends shared";
    EXPECT_EQ(byZeros[3], 4U);
    for (const auto& face : mesh.boundary) {
        EXPECT_EQ(face.size(), 3 * n * n);
        std::set<std::uint16_t> points;
        for (const BoundaryQuad& quad : face)
            points.insert(quad.vertex.begin(), quad.vertex.end());
        EXPECT_EQ(points.size(), 3 * n * n + 3 * n + 1);
    }
    for (const auto& w : mesh.weights)
        ASSERT_EQ(std::accumulate(w.begin(), w.end(), 0U), mesh.denominator());
}

TEST_P(VolumeMeshTest, fillsTheTetrahedronWithHexahedraThatAreNotInverted)
{
    const VolumeMesh& mesh = VolumeMesh::ofSize(GetParam());
    // in the coordinates of weights 1 to 3 the tetrahedron has volume 1/6
    double volume = 0;
    const auto point = [&](std::uint16_t v) {
        const auto& w = mesh.weights[v];
        return glm::dvec3(w[1], w[2], w[3]) / double(mesh.denominator());
    };
    const auto determinant = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        return a.x * (b.y * c.z - b.z * c.y) - a.y * (b.x * c.z - b.z * c.x) +
               a.z * (b.x * c.y - b.y * c.x);
    };
    for (const Hexahedron& h : mesh.hexahedra) {
        for (unsigned m = 0; m < 8; ++m) {
            const glm::dvec3 o = point(h.vertex[m]);
            double jacobian = determinant(
                point(h.vertex[m ^ 1U]) - o,
                point(h.vertex[m ^ 2U]) - o,
                point(h.vertex[m ^ 4U]) - o);
            if (std::popcount(m) % 2 == 1)
                jacobian = -jacobian;
            ASSERT_GT(jacobian, 0);
        }
        // sides are planar, so six tetrahedra around a diagonal fill the hexahedron
        constexpr std::array<std::array<unsigned, 2>, 6> kKuhn{
            {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}};
        const glm::dvec3 o = point(h.vertex[0]);
        for (const auto& [a, b] : kKuhn)
            volume += determinant(
                          point(h.vertex[a]) - o, point(h.vertex[b]) - o, point(h.vertex[7]) - o) /
                      6;
    }
    EXPECT_NEAR(volume, 1.0 / 6, 1e-12);
}

TEST_P(VolumeMeshTest, visitsHexahedraAlongAHilbertCurveFromEachCorner)
{
    const auto n = static_cast<std::size_t>(GetParam());
    const VolumeMesh& mesh = VolumeMesh::ofSize(GetParam());
    std::set<std::array<std::uint16_t, 8>> distinct;
    for (std::size_t corner = 0; corner < 4; ++corner)
        for (std::size_t i = 0; i < n * n * n; ++i) {
            const Hexahedron& h = mesh.hexahedra[corner * n * n * n + i];
            distinct.insert(h.vertex);
            if (i == 0) {
                EXPECT_EQ(mesh.weights[h.vertex[0]][corner], mesh.denominator());
                continue;
            }
            const Hexahedron& before = mesh.hexahedra[corner * n * n * n + i - 1];
            int shared = 0;
            for (const std::uint16_t v : h.vertex)
                shared += static_cast<int>(std::ranges::count(before.vertex, v));
            ASSERT_EQ(shared, 4) << "consecutive hexahedra share a side";
        }
    EXPECT_EQ(distinct.size(), 4 * n * n * n);
}

INSTANTIATE_TEST_SUITE_P(Sizes, VolumeMeshTest, testing::Values(1, 2, 4, 8, 16));

TEST(VolumeMesh, knowsWhichSizesItCanHave)
{
    for (const int size : {-4, 0, 3, 5, 6, 7, 12, 17, 32, 1 << 30})
        EXPECT_FALSE(VolumeMesh::isValidSize(size)) << size;
    for (const int size : {1, 2, 4, 8, 16})
        EXPECT_TRUE(VolumeMesh::isValidSize(size)) << size;
}

} // namespace
} // namespace isofront::extractor

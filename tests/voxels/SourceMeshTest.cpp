#include "support/Random.h"
#include "voxels/Models.h"

#include <isofront/voxels/SourceMesh.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <vector>

namespace isofront::voxels {
namespace {

using Point = std::array<std::int64_t, 3>; // steps

/// All cells of a source, block by block.
struct CutModel {
    VoxelLattice lattice;
    std::vector<SourceCell> cells;

    [[nodiscard]] static Point placeOf(const SourceCell& cell, std::uint16_t index)
    {
        Point point{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = std::int64_t{cell.place[static_cast<glm::length_t>(axis)]} *
                              (std::int64_t{kSourceSteps} << kSourceCellBits) +
                          cell.vertices[index].place[axis];
        return point;
    }
    [[nodiscard]] glm::dvec3 worldOf(const Point& p) const
    {
        const double step = lattice.edge / kSourceSteps;
        return lattice.origin + step * glm::dvec3(double(p[0]), double(p[1]), double(p[2]));
    }
    /// @param body  called with the corners of each triangle
    template <typename Body>
    void forEachTriangle(const Body& body) const
    {
        for (const SourceCell& cell : cells)
            for (std::size_t i = 0; i < cell.indices.size(); i += 3)
                body(std::array<Point, 3>{
                    placeOf(cell, cell.indices[i]),
                    placeOf(cell, cell.indices[i + 1]),
                    placeOf(cell, cell.indices[i + 2])});
    }
};

VoxelLattice latticeOf(const TriangleModel& model, std::uint32_t resolution)
{
    return latticeFor(inspect(model).bounds, resolution);
}

CutModel cutAll(const TriangleModel& model, std::uint32_t resolution, std::uint32_t blockBits)
{
    CutModel result{latticeOf(model, resolution), {}};
    const glm::uvec3 blocks((resolution >> blockBits) + 1U);
    const auto source = SourceMesh::create(model, result.lattice, blockBits, blocks);
    EXPECT_TRUE(source) << source.error().message;
    glm::uvec3 at(0U, 0U, 0U);
    for (at.z = 0; at.z < blocks.z; ++at.z)
        for (at.y = 0; at.y < blocks.y; ++at.y)
            for (at.x = 0; at.x < blocks.x; ++at.x) {
                std::vector<SourceCell> cells = source->cut(at);
                EXPECT_TRUE(cells.empty() || source->trianglesNear(at) > 0);
                for (SourceCell& cell : cells) {
                    for (glm::length_t axis = 0; axis < 3; ++axis)
                        EXPECT_EQ(cell.place[axis] >> (blockBits - kSourceCellBits), at[axis]);
                    for (const SourceVertex& vertex : cell.vertices)
                        EXPECT_LE(
                            std::max({vertex.place[0], vertex.place[1], vertex.place[2]}), 32768);
                    result.cells.push_back(std::move(cell));
                }
            }
    return result;
}

/// Edges that don't have as many triangles of one direction as of the other.
std::size_t openEdges(const CutModel& cut)
{
    std::map<std::pair<Point, Point>, int> edges;
    cut.forEachTriangle([&](const std::array<Point, 3>& corners) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Point& a = corners[i];
            const Point& b = corners[(i + 1) % 3];
            edges[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    });
    std::size_t open = 0;
    for (const auto& [edge, balance] : edges)
        open += balance != 0 ? 1U : 0U;
    return open;
}

double volumeOf(const CutModel& cut)
{
    double volume = 0;
    const glm::dvec3 middle = cut.lattice.origin;
    cut.forEachTriangle([&](const std::array<Point, 3>& corners) {
        const glm::dvec3 a = cut.worldOf(corners[0]) - middle;
        const glm::dvec3 b = cut.worldOf(corners[1]) - middle;
        const glm::dvec3 c = cut.worldOf(corners[2]) - middle;
        volume += glm::dot(a, glm::cross(b, c)) / 6;
    });
    return volume;
}

double volumeOf(const TriangleModel& model)
{
    double volume = 0;
    for (const auto& t : model.triangles)
        volume +=
            glm::dot(
                model.positions[t[0]], glm::cross(model.positions[t[1]], model.positions[t[2]])) /
            6;
    return volume;
}

/// A box turned in space, of twelve large triangles.
TriangleModel turnedBox(std::mt19937_64& random)
{
    const auto any = [&] {
        return glm::normalize(glm::dvec3(
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1)));
    };
    const glm::dvec3 x = any();
    const glm::dvec3 y = glm::normalize(glm::cross(x, any()));
    const glm::dvec3 z = glm::cross(x, y);
    TriangleModel model;
    for (unsigned corner = 0; corner < 8; ++corner)
        model.positions.push_back(
            ((corner & 1U) != 0 ? x : -x) + ((corner & 2U) != 0 ? 0.7 * y : -0.7 * y) +
            ((corner & 4U) != 0 ? 0.4 * z : -0.4 * z));
    model.triangles = {
        {0, 2, 1},
        {1, 2, 3},
        {4, 5, 6},
        {5, 7, 6},
        {0, 1, 4},
        {1, 5, 4},
        {2, 6, 3},
        {3, 6, 7},
        {0, 4, 2},
        {2, 4, 6},
        {1, 3, 5},
        {3, 7, 5}};
    return model;
}

TEST(SourceMeshes, ofClosedModelsAreClosedAcrossCellsAndBlocks)
{
    const TriangleModel sphere = tests::hillySphere(40, 3, 0.4, {1e3, 2, -5});
    for (const std::uint32_t blockBits : {5U, 6U}) {
        const CutModel cut = cutAll(sphere, 150, blockBits);
        EXPECT_EQ(openEdges(cut), 0U);
    }
    auto random = tests::random(7);
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        TriangleModel box = turnedBox(random);
        EXPECT_EQ(openEdges(cutAll(box, 200, 5)), 0U) << trial;
        // cut at every voxel
        box.textures.push_back({{.width = 1, .height = 1, .rgba = {9, 8, 7, 255}}});
        box.textureOf.assign(box.triangles.size(), 0);
        box.textureCorners.resize(box.triangles.size());
        const CutModel fine = cutAll(box, 70, 5);
        EXPECT_EQ(openEdges(fine), 0U) << trial;
        EXPECT_GT(fine.cells.size(), 6U);
        // and where only every other triangle has a texture
        for (std::size_t i = 0; i < box.textureOf.size(); i += 2)
            box.textureOf[i] = kNoTexture;
        EXPECT_EQ(openEdges(cutAll(box, 70, 5)), 0U) << trial;
    }
}

TEST(SourceMeshes, knowWhetherTheyHaveAnInside)
{
    const auto isClosed = [](const TriangleModel& model) {
        const auto source = SourceMesh::create(model, latticeOf(model, 60), 6, {1U, 1U, 1U});
        EXPECT_TRUE(source) << source.error().message;
        return source->isClosed();
    };
    const auto turned = [](TriangleModel model) {
        for (auto& corners : model.triangles)
            std::swap(corners[1], corners[2]);
        return model;
    };
    const auto both = [](TriangleModel one, const TriangleModel& other) {
        const auto first = static_cast<std::uint32_t>(one.positions.size());
        one.positions.insert(one.positions.end(), other.positions.begin(), other.positions.end());
        for (const auto& corners : other.triangles)
            one.triangles.push_back({first + corners[0], first + corners[1], first + corners[2]});
        return one;
    };
    const TriangleModel sphere = tests::hillySphere(20, 1, 0.2);
    EXPECT_TRUE(isClosed(sphere));
    EXPECT_FALSE(isClosed(turned(sphere)));
    const TriangleModel beside = tests::hillySphere(20, 1, 0.2, {5, 0, 0});
    EXPECT_TRUE(isClosed(both(sphere, beside)));
    EXPECT_FALSE(isClosed(both(sphere, turned(beside)))) << "one part shows its inside";

    TriangleModel soup; // no two triangles share a position by its number
    for (const auto& corners : sphere.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        for (const std::uint32_t corner : corners)
            soup.positions.push_back(sphere.positions[corner]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_TRUE(isClosed(soup));
    soup.triangles.push_back({0, 0, 1});
    EXPECT_TRUE(isClosed(soup)) << "without area";

    auto random = tests::random(12);
    for (int trial = 0; trial < 10; ++trial) {
        TriangleModel open = sphere;
        const std::size_t any = random() % open.triangles.size();
        open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(any));
        EXPECT_FALSE(isClosed(open)) << any;
        TriangleModel flipped = sphere;
        std::swap(flipped.triangles[any][0], flipped.triangles[any][1]);
        EXPECT_FALSE(isClosed(flipped)) << any;
    }
    TriangleModel damaged = sphere;
    damaged.triangles.push_back({0, 1, 1000000});
    EXPECT_FALSE(isClosed(damaged));
}

TEST(SourceMeshes, enclosePracticallyTheSameVolume)
{
    const TriangleModel sphere = tests::hillySphere(30, 3, 0.4);
    const double expected = volumeOf(sphere);
    const CutModel cut = cutAll(sphere, 120, 6);
    // of a step in 120 voxels of 1024 steps
    EXPECT_NEAR(volumeOf(cut), expected, 1e-5 * expected);
}

TEST(SourceMeshes, areTheSameHoweverLargeTheirBlocksAre)
{
    auto random = tests::random(3);
    const TriangleModel box = turnedBox(random);
    const auto trianglesOf = [&](std::uint32_t blockBits) {
        std::multiset<std::array<Point, 3>> all;
        cutAll(box, 130, blockBits).forEachTriangle([&](const auto& t) { all.insert(t); });
        return all;
    };
    const auto small = trianglesOf(5);
    EXPECT_GT(small.size(), 100U);
    EXPECT_EQ(trianglesOf(6), small);
    EXPECT_EQ(trianglesOf(8), small);
}

TEST(SourceMeshes, haveSmoothNormalsButNotAcrossCreases)
{
    const TriangleModel sphere = tests::hillySphere(60, 3, 0);
    for (const CutModel cut = cutAll(sphere, 100, 5); const SourceCell& cell : cut.cells)
        for (std::uint16_t i = 0; i < cell.vertices.size(); ++i) {
            const glm::dvec3 out = glm::normalize(cut.worldOf(CutModel::placeOf(cell, i)));
            EXPECT_GT(glm::dot(out, glm::normalize(unpackNormal(cell.vertices[i].normal))), 0.999);
        }
    auto random = tests::random(5);
    const TriangleModel box = turnedBox(random);
    std::vector<glm::dvec3> sides;
    for (const auto& t : box.triangles)
        sides.push_back(glm::normalize(glm::cross(
            box.positions[t[1]] - box.positions[t[0]], box.positions[t[2]] - box.positions[t[0]])));
    for (const CutModel cut = cutAll(box, 100, 5); const SourceCell& cell : cut.cells)
        for (const SourceVertex& vertex : cell.vertices) {
            const glm::dvec3 normal = glm::normalize(unpackNormal(vertex.normal));
            EXPECT_TRUE(std::ranges::any_of(
                sides, [&](const glm::dvec3& side) { return glm::dot(side, normal) > 0.9999; }));
        }
}

TEST(SourceMeshes, haveNormalsWhereVeryManyTrianglesMeet)
{
    // at a flat cone's tip: to ask each of them for each would take minutes
    constexpr std::uint32_t kMany = 40'000;
    TriangleModel cone;
    cone.positions.emplace_back(0, 0, 0.1);
    for (std::uint32_t i = 0; i < kMany; ++i) {
        const double angle = 2 * std::numbers::pi * i / kMany;
        cone.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
        cone.triangles.push_back({0, 1 + i, 1 + (i + 1) % kMany});
    }
    for (const CutModel cut = cutAll(cone, 60, 5); const SourceCell& cell : cut.cells)
        for (const SourceVertex& vertex : cell.vertices)
            ASSERT_GT(glm::normalize(unpackNormal(vertex.normal)).z, 0.9);
    // nor is each asked whether it closes what each of the others opens
    cone.positions.emplace_back(0, 0, -0.1);
    for (std::uint32_t i = 0; i < kMany; ++i)
        cone.triangles.push_back({kMany + 1, 1 + (i + 1) % kMany, 1 + i});
    const auto source = SourceMesh::create(cone, latticeOf(cone, 60), 6, {1U, 1U, 1U});
    ASSERT_TRUE(source);
    EXPECT_TRUE(source->isClosed());
}

TEST(SourceMeshes, carryColoursToTheirCuts)
{
    // grey by height: linear in light within each triangle
    TriangleModel model;
    model.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.2}};
    model.triangles = {{0, 1, 2}, {0, 2, 3}};
    model.colours = {0xff000000U, 0xffffffffU, 0xffffffffU, 0xff000000U};
    const CutModel cut = cutAll(model, 100, 5);
    std::size_t between = 0;
    for (const SourceCell& cell : cut.cells)
        for (std::uint16_t i = 0; i < cell.vertices.size(); ++i) {
            const double x = cut.worldOf(CutModel::placeOf(cell, i)).x;
            const std::uint32_t colour = cell.vertices[i].colour;
            const double s = (colour & 0xffU) / 255.0;
            const double light = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
            EXPECT_NEAR(light, x, 0.01);
            EXPECT_EQ(colour >> 24U, 255U);
            EXPECT_EQ(colour & 0xffU, colour >> 16U & 0xffU);
            between += x > 0.1 && x < 0.9 ? 1U : 0U;
        }
    EXPECT_GT(between, 10U);
}

TEST(SourceMeshes, leaveOutWhatIsNoTriangle)
{
    TriangleModel model = tests::hillySphere(8, 1, 0);
    const VoxelLattice lattice = latticeOf(model, 64);
    const glm::uvec3 blocks(2U, 2U, 2U);
    const auto count = [&](const TriangleModel& of) {
        const auto source = SourceMesh::create(of, lattice, 5, blocks);
        EXPECT_TRUE(source);
        std::size_t triangles = 0;
        for (std::uint32_t i = 0; i < 8; ++i)
            for (const SourceCell& cell : source->cut({i & 1U, i >> 1U & 1U, i >> 2U}))
                triangles += cell.indices.size() / 3;
        return triangles;
    };
    const std::size_t sound = count(model);
    TriangleModel damaged = model;
    damaged.positions.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
    damaged.positions.emplace_back(0, std::numeric_limits<double>::infinity(), 0);
    damaged.positions.emplace_back(1e300, 1e300, -1e300);
    const auto first = static_cast<std::uint32_t>(model.positions.size());
    damaged.triangles.push_back({0, 1, first});
    damaged.triangles.push_back({0, first + 1, 2});
    damaged.triangles.push_back({0, 1, first + 2});
    // and one that could be a place on the lattice's far side, or far beyond it
    damaged.positions.push_back(lattice.origin - 2.001 * kMaxResolution * lattice.edge);
    damaged.triangles.push_back({0, 1, first + 3});
    damaged.triangles.push_back({0, 1, 0xffffffffU});
    damaged.triangles.push_back({5, 5, 5});
    EXPECT_EQ(count(damaged), sound);

    damaged.colours.assign(3, 0);
    EXPECT_EQ(
        SourceMesh::create(damaged, lattice, 5, blocks).error().code, core::ErrorCode::badData);
    EXPECT_EQ(SourceMesh::create(model, lattice, 4, blocks).error().code, core::ErrorCode::usage);
    EXPECT_EQ(
        SourceMesh::create(model, lattice, 5, {0U, 1U, 1U}).error().code, core::ErrorCode::usage);
    EXPECT_EQ(count({}), 0U);
}

} // namespace
} // namespace isofront::voxels

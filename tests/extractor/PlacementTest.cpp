#include "extractor/CellChecks.h"
#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>
#include <isofront/extractor/MarchingCubesTable.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

namespace isofront::extractor {
namespace {

const glm::dvec3 kCentre(0.503, 0.491, 0.507);
const glm::dvec3 kShift(0.0131, 0.0277, 0.0419);

/// A surface whose distance is known well enough to measure by.
struct Shape {
    const char* name;
    std::function<double(const glm::dvec3&)> value;    ///< positive inside
    std::function<double(const glm::dvec3&)> distance; ///< from the surface, near it
    bool meetsWalls = false;
};

std::vector<Shape> shapes()
{
    const auto ball = [](const glm::dvec3& p) { return tests::sphere(p, kCentre, 0.37); };
    const auto ring = [](const glm::dvec3& p) { return tests::torus(p, kCentre, 0.3, 0.1); };
    const auto gyroid = [](const glm::dvec3& p) { return tests::gyroid(p + kShift, 2.0); };
    const auto gyroidDistance = [gyroid](const glm::dvec3& p) {
        constexpr double kScale = 4 * std::numbers::pi;
        const glm::dvec3 q = (p + kShift) * kScale;
        const glm::dvec3 gradient =
            kScale * glm::dvec3(
                         std::cos(q.x) * std::cos(q.y) - std::sin(q.z) * std::sin(q.x),
                         std::cos(q.y) * std::cos(q.z) - std::sin(q.x) * std::sin(q.y),
                         std::cos(q.z) * std::cos(q.x) - std::sin(q.y) * std::sin(q.z));
        return gyroid(p) / glm::length(gradient);
    };
    return {
        {"sphere", ball, ball}, {"torus", ring, ring}, {"gyroid", gyroid, gyroidDistance, true}};
}

/// The root of the mean squared distance, times the number of triangles: for a smooth surface it
/// doesn't depend on how fine the mesh is, only on how well its triangles are placed.
class Measure {
public:
    explicit Measure(const Shape& shape) : _shape(shape) {}

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
    {
        const glm::dvec3 centre = (a + b + c) / 3.0;
        const glm::dvec3 off = glm::abs(centre - 0.5);
        if (_shape.meetsWalls && std::max({off.x, off.y, off.z}) > 0.4)
            return; // what happens at walls is another matter
        const double weight = glm::length(glm::cross(b - a, c - a)) / 2;
        const auto squared = [&](double u, double v) {
            return std::pow(_shape.distance(u * a + v * b + (1 - u - v) * c), 2);
        };
        // Cowper's rule of seven points, exact for degree five
        constexpr double kA = 0.059715871789770;
        constexpr double kB = 0.470142064105115;
        constexpr double kC = 0.797426985353087;
        constexpr double kD = 0.101286507323456;
        _sum +=
            weight * (0.225 * squared(1.0 / 3, 1.0 / 3) +
                      0.132394152788506 * (squared(kA, kB) + squared(kB, kA) + squared(kB, kB)) +
                      0.125939180544827 * (squared(kC, kD) + squared(kD, kC) + squared(kD, kD)));
        _area += weight;
        ++_triangles;
    }
    [[nodiscard]] double result() const
    {
        return std::sqrt(_sum / _area) * static_cast<double>(_triangles);
    }

private:
    const Shape& _shape;
    double _sum = 0;
    double _area = 0;
    std::size_t _triangles = 0;
};

/// Marching cubes on a plain grid of n^3 cubes, the yardstick.
double marchingCubes(const Shape& shape, int n)
{
    const MarchingCubesTable& table = MarchingCubesTable::instance();
    constexpr std::array<std::array<unsigned, 2>, 12> kEdges{
        {{0, 1},
         {2, 3},
         {4, 5},
         {6, 7},
         {0, 2},
         {1, 3},
         {4, 6},
         {5, 7},
         {0, 4},
         {1, 5},
         {2, 6},
         {3, 7}}};
    Measure measure(shape);
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                std::array<glm::dvec3, 8> p;
                std::array<double, 8> f{};
                unsigned configuration = 0;
                for (unsigned m = 0; m < 8; ++m) {
                    p[m] = (glm::dvec3(i, j, k) + glm::dvec3(m & 1U, m >> 1U & 1U, m >> 2U)) /
                           double(n);
                    f[m] = shape.value(p[m]);
                    configuration |= (f[m] >= 0 ? 1U : 0U) << m;
                }
                const auto& entry = table[static_cast<std::uint8_t>(configuration)];
                for (std::size_t t = 0; t < entry.triangles; ++t) {
                    std::array<glm::dvec3, 3> corner;
                    for (std::size_t c = 0; c < 3; ++c) {
                        const auto [a, b] = kEdges[entry.edge[t][c]];
                        corner[c] = p[a] + f[a] / (f[a] - f[b]) * (p[b] - p[a]);
                    }
                    measure.add(corner[0], corner[1], corner[2]);
                }
            }
    return measure.result();
}

double cells(const Shape& shape, int level, const ExtractionSettings& settings)
{
    const auto field = std::make_shared<tests::FunctionField>(
        [&](const glm::dvec3& p, double) { return shape.value(p); }, 1e-4);
    const tests::GlobalMesh mesh =
        tests::extractFront(tests::uniformFront(level), CellExtractor(field, {}, settings));
    Measure measure(shape);
    for (const auto& t : mesh.triangles)
        measure.add(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    return measure.result();
}

TEST(Placement, alignedCellsAreWithinSixteenTenthsOfMarchingCubesAndBalancedOnesBetter)
{
    for (const Shape& shape : shapes()) {
        const double yardstick = marchingCubes(shape, 48);
        for (const int level : {8, 9}) {
            SCOPED_TRACE(testing::Message() << shape.name << " at level " << level);
            ExtractionSettings settings{.latticeSize = 4, .filterStrength = 0};
            const double plain = cells(shape, level, settings) / yardstick;
            settings.alignEdges = true;
            const double aligned = cells(shape, level, settings) / yardstick;
            settings.vertices = VertexPlacement::balanced;
            const double balanced = cells(shape, level, settings) / yardstick;
            settings.simplifyError = 0.01;
            const double simplified = cells(shape, level, settings) / yardstick;
            RecordProperty(std::string(shape.name) + std::to_string(level), std::to_string(plain));
            EXPECT_LT(aligned, 1.6);
            EXPECT_LT(aligned, 0.9 * plain);
            EXPECT_LT(balanced, aligned);
            EXPECT_LT(balanced, shape.meetsWalls ? 1.35 : 0.75) << "a saddle gains less";
            EXPECT_LT(simplified, 1.0);
            if (level != 9)
                continue;
            settings.smoothIterations = 1;
            settings.reproject = true;
            settings.simplifyError = 0.02;
            EXPECT_LT(cells(shape, level, settings) / yardstick, shape.meetsWalls ? 0.9 : 0.6);
            // borders of cells are locked, so larger cells come closer to what can be had
            settings.latticeSize = 8;
            settings.simplifyError = 0;
            EXPECT_LT(cells(shape, level - 3, settings) / yardstick, shape.meetsWalls ? 1.1 : 0.6);
        }
    }
}

std::shared_ptr<tests::FunctionField> wavy()
{
    return std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::gyroid(p, 1.3); }, 1e-4);
}

TEST(Placement, alignsEdgesInsideCellsOnly)
{
    const auto noise = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::hashed(p, 0, 29); });
    for (const auto& field : {wavy(), noise})
        for (const hierarchy::Tetrahedron& cell : hierarchy::rootTetrahedra()) {
            ExtractionSettings settings{.latticeSize = 8, .filterStrength = 0};
            const auto before = CellExtractor(field, {}, settings).extract(cell);
            settings.alignEdges = true;
            const auto after = CellExtractor(field, {}, settings).extract(cell);
            EXPECT_EQ(tests::positionsOf(*before), tests::positionsOf(*after));
            EXPECT_EQ(tests::borderEdges(*before), tests::borderEdges(*after));
            EXPECT_EQ(before->triangleCount(), after->triangleCount());
            EXPECT_EQ(tests::eulerNumber(*before), tests::eulerNumber(*after));
            EXPECT_EQ(tests::mostTrianglesAtAnEdge(*after), 2);
            EXPECT_NE(tests::edgeUses(*before), tests::edgeUses(*after));
        }
}

TEST(Placement, slidesBorderVerticesAlongTheirLatticeEdges)
{
    const CellExtractor plain(wavy(), {}, {.latticeSize = 8, .filterStrength = 0});
    const CellExtractor balanced(
        wavy(), {}, {.latticeSize = 8, .filterStrength = 0, .vertices = VertexPlacement::balanced});
    for (const hierarchy::Tetrahedron& cell : hierarchy::rootTetrahedra()) {
        CellTrace from;
        CellTrace to;
        const auto before = plain.extract(cell, &from);
        const auto after = balanced.extract(cell, &to);
        ASSERT_EQ(before->indices, after->indices) << "it's the same mesh, with moved vertices";
        ASSERT_EQ(from.borders.size(), to.borders.size());
        std::size_t moved = 0;
        for (std::size_t i = 0; i < from.borders.size(); ++i) {
            ASSERT_EQ(from.borders[i].key, to.borders[i].key);
            const glm::dvec3 a = tests::localPosition(before->vertices[from.borders[i].vertex]);
            const glm::dvec3 b = tests::localPosition(after->vertices[to.borders[i].vertex]);
            // the middle of the lattice edge [cell units]: the key is twice that, in sample units
            glm::dvec3 middle;
            for (std::size_t axis = 0; axis < 3; ++axis)
                middle[axis] = std::ldexp(
                                   double(from.borders[i].key[axis]) / (2.0 * 12 * 8 * 8 * 8),
                                   hierarchy::kGridBitsPerLatticeUnit - before->exponent) -
                               std::ldexp(
                                   double(before->low[axis]),
                                   hierarchy::kGridBitsPerLatticeUnit - before->exponent);
            // all three on one line, up to the snap
            const double area = glm::length(glm::cross(a - middle, b - middle));
            EXPECT_LE(area, 2 * (glm::distance(a, middle) + glm::distance(b, middle)) + 4);
            moved += a == b ? 0U : 1U;
        }
        EXPECT_GT(moved, from.borders.size() / 2);
    }
}

TEST(Placement, leavesNoCrackBetweenCellsOfMixedLevels)
{
    auto generator = tests::random(91);
    const auto ball = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::sphere(p, kCentre, 0.37); });
    for (const int n : {2, 4, 8}) {
        const tests::GlobalMesh mesh = tests::extractFront(
            tests::randomFront(generator, 3, 10, 8),
            CellExtractor(
                ball,
                {},
                {.latticeSize = n,
                 .cornerRadius = 1e-3,
                 .simplifyError = 0.1,
                 .vertices = VertexPlacement::balanced,
                 .alignEdges = true}));
        const auto defects = mesh.defects();
        EXPECT_EQ(defects.open, 0U);
        EXPECT_EQ(defects.nonManifold, 0U);
        EXPECT_EQ(defects.misoriented, 0U);
        EXPECT_EQ(defects.degenerate, 0U);
        EXPECT_EQ(mesh.differingCopies, 0U);
        EXPECT_EQ(mesh.eulerNumber(), 2);
        const double volume = 4.0 / 3 * std::numbers::pi * std::pow(0.37, 3);
        if (n == 8) {
            EXPECT_NEAR(mesh.volume(), volume, 1e-3 * volume);
        }
    }
}

} // namespace
} // namespace isofront::extractor

#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <queue>
#include <unordered_map>

namespace isofront::extractor {
namespace {

constexpr double kHuge = double(std::numeric_limits<float>::max());

/// All meshes of a front, in its order of cells.
std::vector<CellMesh> meshesOf(const hierarchy::Front& front, const CellExtractor& extractor)
{
    std::vector<std::pair<hierarchy::CellId, CellMesh>> cells;
    front.forEachCell([&](const hierarchy::CellId& id, const hierarchy::Tetrahedron& cell) {
        cells.emplace_back(id, *extractor.extract(cell));
    });
    std::ranges::sort(cells, {}, [](const auto& entry) { return entry.first; });
    std::vector<CellMesh> meshes;
    for (auto& [id, mesh] : cells)
        meshes.push_back(std::move(mesh));
    return meshes;
}

std::size_t expectSameBits(const std::vector<CellMesh>& a, const std::vector<CellMesh>& b)
{
    EXPECT_EQ(a.size(), b.size());
    std::size_t triangles = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        EXPECT_EQ(a[i].indices, b[i].indices) << i;
        EXPECT_EQ(a[i].vertices, b[i].vertices) << i;
        triangles += a[i].triangleCount();
    }
    return triangles;
}

/// A lumpy ball about the middle of a unit cube; its shape needs every bit of the position.
double lumpyBall(const glm::dvec3& p)
{
    const glm::dvec3 q = p - glm::dvec3(0.4921875, 0.5078125, 0.515625);
    return 0.33 - glm::length(q) + 0.1 * q.x * (1.0 - 4.0 * q.y * q.z) / (0.1 + glm::dot(q, q));
}

/// The ball in a domain of another size and place; scaling by powers of two changes no bit of it.
std::shared_ptr<tests::FunctionField>
lumpyBallIn(const hierarchy::Domain& domain, double scale = 1.0, double filtered = 0.0)
{
    return std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double radius) {
            return scale *
                   (lumpyBall((p - domain.origin) / domain.edge) - filtered * radius / domain.edge);
        },
        domain.edge * 0x1p-12);
}

hierarchy::Front mixedFront()
{
    auto generator = tests::random(61);
    return tests::randomFront(generator, 5, 12, 10);
}

TEST(Extremes, domainsOfAnySizeGiveTheSameMesh)
{
    const hierarchy::Front front = mixedFront();
    const auto extracted = [&](double edge) {
        const hierarchy::Domain domain{glm::dvec3(0.0), edge};
        return meshesOf(
            front,
            CellExtractor(
                lumpyBallIn(domain, 1.0, 0.125),
                domain,
                {.latticeSize = 4, .filterStrength = 1, .cornerRadius = 0x1p-10 * edge}));
    };
    const std::vector<CellMesh> one = extracted(1.0);
    for (const double powerOfTwo : {0x1p-20, 0x1p-60, 0x1p24, 0x1p43, 0x1p100})
        EXPECT_GT(expectSameBits(one, extracted(powerOfTwo)), 5000U) << powerOfTwo;
    for (const double edge : {1e-6, 1.34e7, 1e13}) {
        const std::vector<CellMesh> other = extracted(edge);
        for (std::size_t i = 0; i < one.size(); ++i)
            EXPECT_EQ(one[i].indices, other[i].indices) << edge; // rounding moves no sign
    }
}

TEST(Extremes, aShiftOfTheOriginByADyadicAmountChangesNothing)
{
    const hierarchy::Front front = mixedFront();
    const auto extracted = [&](const glm::dvec3& origin) {
        const hierarchy::Domain domain{origin, 1.0};
        return meshesOf(
            front,
            CellExtractor(lumpyBallIn(domain), domain, {.latticeSize = 4, .filterStrength = 0}));
    };
    const std::vector<CellMesh> here = extracted(glm::dvec3(0.0));
    EXPECT_GT(expectSameBits(here, extracted({1024.0, -4096.0, 8.0})), 5000U);
    // Further out a sample's coordinates lose bits: both cells of a face lose the same ones.
    const hierarchy::Domain far{{6.4e6, -4.7e6, 2.0e6}, 1.0};
    const CellExtractor extractor(lumpyBallIn(far), far, {.latticeSize = 4, .filterStrength = 0});
    const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
    EXPECT_EQ(mesh.defects().open, 0U);
    EXPECT_EQ(mesh.differingCopies, 0U);
    EXPECT_EQ(mesh.eulerNumber(), 2);
}

TEST(Extremes, fieldsOfAnyScaleGiveTheSameMesh)
{
    const hierarchy::Front front = mixedFront();
    const hierarchy::Domain domain{};
    const auto extracted = [&](double scale) {
        return meshesOf(
            front,
            CellExtractor(
                lumpyBallIn(domain, scale), domain, {.latticeSize = 4, .filterStrength = 0}));
    };
    const std::vector<CellMesh> one = extracted(1.0);
    for (const double powerOfTwo : {0x1p-100, 0x1p-30, 0x1p100})
        EXPECT_GT(expectSameBits(one, extracted(powerOfTwo)), 5000U) << powerOfTwo;
    for (const double scale : {1e-30, 1e30}) {
        const std::vector<CellMesh> other = extracted(scale);
        for (std::size_t i = 0; i < one.size(); ++i)
            EXPECT_EQ(one[i].indices, other[i].indices) << scale;
    }
    // Values that float can barely hold or not hold at all: no longer the same, still a closed
    // body. (Below 1e-45 all are zero, and what equals the isovalue is solid.)
    for (const double scale : {1e-40, 1e-42, 1e38, 1e40, 1e300}) {
        const CellExtractor extractor(
            lumpyBallIn(domain, scale), domain, {.latticeSize = 4, .filterStrength = 0});
        const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
        EXPECT_EQ(mesh.defects().open, 0U) << scale;
        EXPECT_EQ(mesh.defects().nonManifold, 0U) << scale;
        EXPECT_EQ(mesh.defects().degenerate, 0U) << scale;
        EXPECT_EQ(mesh.differingCopies, 0U) << scale;
        EXPECT_GT(mesh.triangles.size(), 1000U) << scale;
        EXPECT_NEAR(mesh.volume(), 0.17, 0.05) << scale;
    }
}

TEST(Extremes, aConstantFieldAtTheIsovalueIsSolid)
{
    const auto constant =
        std::make_shared<tests::FunctionField>([](const glm::dvec3&, double) { return 7.25; });
    for (const bool closed : {false, true}) {
        const CellExtractor extractor(
            constant,
            {},
            {.latticeSize = 4, .isovalue = 7.25, .filterStrength = 0, .closed = closed});
        const tests::GlobalMesh mesh = tests::extractFront(mixedFront(), extractor);
        EXPECT_EQ(mesh.triangles.empty(), !closed);
        EXPECT_EQ(mesh.defects().open, 0U);
        if (closed) {
            EXPECT_NEAR(mesh.volume(), 1.0, 1e-12);
        }
    }
    const CellExtractor above(
        constant,
        {},
        {.latticeSize = 4, .isovalue = std::nextafter(7.25, 8.0), .filterStrength = 0});
    EXPECT_TRUE(tests::extractFront(mixedFront(), above).triangles.empty());
}

TEST(Extremes, aFieldOfNothingButNaNIsEmptyAndSaysSo)
{
    const CellExtractor extractor(
        std::make_shared<tests::FunctionField>(
            [](const glm::dvec3&, double) { return std::numeric_limits<double>::quiet_NaN(); }),
        {},
        {.latticeSize = 4, .filterStrength = 0, .closed = true});
    for (const CellMesh& mesh : meshesOf(mixedFront(), extractor)) {
        EXPECT_TRUE(mesh.indices.empty());
        EXPECT_EQ(mesh.stats.sanitisedSamples, mesh.stats.samples);
        EXPECT_GT(mesh.stats.samples, 0U);
    }
}

TEST(Extremes, flatFieldsStillHaveUnitNormals)
{
    // A step: no slope anywhere but within the difference of a normal, and none there for most.
    const auto step = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return lumpyBall(p) >= 0 ? 1.0 : -1.0; }, 0x1p-40);
    const hierarchy::Front front = mixedFront();
    const CellExtractor extractor(
        step, {}, {.latticeSize = 4, .isovalue = 0.5, .filterStrength = 0});
    tests::GlobalMesh mesh = tests::extractFront(front, extractor);
    EXPECT_EQ(mesh.defects().open, 0U);
    EXPECT_EQ(mesh.differingCopies, 0U);
    std::size_t outward = 0;
    std::size_t all = 0;
    for (const CellMesh& cell : meshesOf(front, extractor))
        for (const CellVertex& vertex : cell.vertices) {
            const glm::dvec3 normal = fromOctahedral(vertex.normal);
            ASSERT_NEAR(glm::length(normal), 1.0, 1e-12);
            const glm::dvec3 at = hierarchy::Domain{}.fieldFromGrid(cell.gridPosition(vertex));
            outward += glm::dot(normal, at - glm::dvec3(0.49, 0.51, 0.515)) > 0 ? 1U : 0U;
            ++all;
        }
    EXPECT_GT(double(outward), 0.95 * double(all));
}

TEST(Extremes, aCheckerboardFillsACellWithTheMostTrianglesItCanHave)
{
    for (const int n : {1, 2, 4, 8, 16}) {
        // The lattice's graph has two colours; solid is where one of them is.
        const VolumeMesh& lattice = VolumeMesh::ofSize(n);
        std::vector<std::vector<std::uint16_t>> neighbours(lattice.vertexCount());
        for (const auto& [a, b] : lattice.edges) {
            neighbours[a].push_back(b);
            neighbours[b].push_back(a);
        }
        std::vector<int> colour(lattice.vertexCount(), -1);
        std::queue<std::uint16_t> queue({std::uint16_t{0}});
        colour[0] = 0;
        while (!queue.empty()) {
            const std::uint16_t v = queue.front();
            queue.pop();
            for (const std::uint16_t w : neighbours[v]) {
                if (colour[w] < 0) {
                    colour[w] = 1 - colour[v];
                    queue.push(w);
                }
                ASSERT_NE(colour[w], colour[v]);
            }
        }
        // Samples come in the order of the lattice, in one batch or several.
        const auto field = std::make_shared<tests::FunctionField>(
            [&, next = std::size_t{0}](const glm::dvec3&, double) mutable {
                return colour[next++ % colour.size()] == 0 ? 1.0 : -1.0;
            });
        const CellExtractor extractor(
            field, {}, {.latticeSize = n, .filterStrength = 0, .skipEmptyCells = false});
        const auto mesh = extractor.extract(hierarchy::rootTetrahedra()[0]);
        EXPECT_EQ(mesh->triangleCount(), static_cast<std::size_t>(16 * n * n * n)) << n;
        EXPECT_EQ(mesh->vertices.size(), lattice.edges.size()) << n;
        EXPECT_LE(mesh->vertices.size(), 65536U);
    }
}

TEST(Extremes, aSurfaceThroughLatticePlanesIsOneCleanSheet)
{
    struct Sheet {
        std::function<double(const glm::dvec3&)> field;
        double area;
    };
    const std::vector<Sheet> sheets{
        {[](const glm::dvec3& p) { return 0.5 - p.x; }, 1.0},
        {[](const glm::dvec3& p) { return p.y - 0.25; }, 1.0},
        {[](const glm::dvec3& p) { return 0.75 - p.z; }, 1.0},
        {[](const glm::dvec3& p) { return p.x - p.y; }, std::sqrt(2.0)}, // faces of cells
        {[](const glm::dvec3& p) { return p.z - p.y; }, std::sqrt(2.0)}};
    auto generator = tests::random(62);
    for (const hierarchy::Front& front :
         {tests::uniformFront(6), tests::randomFront(generator, 3, 10, 12)})
        for (const Sheet& sheet : sheets) {
            const CellExtractor extractor(
                std::make_shared<tests::FunctionField>(
                    [&](const glm::dvec3& p, double) { return sheet.field(p); }),
                {},
                {.latticeSize = 4, .filterStrength = 0});
            const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
            const auto defects = mesh.defects();
            EXPECT_EQ(defects.nonManifold, 0U);
            EXPECT_EQ(defects.misoriented, 0U);
            EXPECT_EQ(defects.degenerate, 0U);
            EXPECT_EQ(mesh.differingCopies, 0U);
            EXPECT_EQ(mesh.eulerNumber(), 1);
            double area = 0;
            for (const auto& t : mesh.triangles)
                area += 0.5 * glm::length(glm::cross(
                                  mesh.positions[t[1]] - mesh.positions[t[0]],
                                  mesh.positions[t[2]] - mesh.positions[t[0]]));
            // A crossing keeps 1/64 of a step away from samples, so a sheet is not quite flat.
            EXPECT_NEAR(area, sheet.area, 0.02 * sheet.area);
        }
}

TEST(Extremes, samplesEqualToTheIsovalueMakeNoTrianglesWithoutArea)
{
    // Integer data at an integer isovalue: a third of all samples are equal to it.
    auto generator = tests::random(63);
    for (const double isovalue : {0.0, 1.0, -1.0}) {
        const CellExtractor extractor(
            std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
                const glm::dvec3 d = glm::abs(p - glm::dvec3(0.5));
                if (std::max({d.x, d.y, d.z}) > 0.49)
                    return -9.0;
                return std::floor(5.0 * tests::gyroid(p, 1.5));
            }),
            {},
            {.latticeSize = 4, .isovalue = isovalue, .filterStrength = 0});
        const hierarchy::Front front = tests::randomFront(generator, 4, 10, 10);
        const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
        EXPECT_EQ(mesh.defects().degenerate, 0U);
        EXPECT_EQ(mesh.defects().open, 0U);
        EXPECT_EQ(mesh.defects().nonManifold, 0U);
        EXPECT_EQ(mesh.differingCopies, 0U);
        EXPECT_GT(mesh.triangles.size(), 1000U);
    }
}

TEST(Extremes, sheetsThinnerThanTheSpacingVanishOrTearButStayManifold)
{
    // A bubble whose wall gets thinner and thinner. Where it falls between samples it has holes,
    // with clean rims; it is never a surface that isn't one.
    std::size_t last = std::numeric_limits<std::size_t>::max();
    for (const double thickness : {0.1, 0.03, 0.01, 0.001, 1e-6}) {
        const CellExtractor extractor(
            std::make_shared<tests::FunctionField>([=](const glm::dvec3& p, double) {
                return thickness -
                       std::abs(0.37 - glm::distance(p, glm::dvec3(0.503, 0.491, 0.507)));
            }),
            {},
            {.latticeSize = 4, .filterStrength = 0});
        const tests::GlobalMesh mesh = tests::extractFront(tests::uniformFront(6), extractor);
        EXPECT_EQ(mesh.defects().open, 0U) << thickness;
        EXPECT_EQ(mesh.defects().nonManifold, 0U) << thickness;
        EXPECT_EQ(mesh.differingCopies, 0U) << thickness;
        EXPECT_LE(mesh.triangles.size(), last) << "it can only lose: " << thickness;
        last = mesh.triangles.size();
    }
    EXPECT_LT(last, 100U);
}

TEST(Extremes, hugeValuesNextToSmallOnesKeepTheirCrossings)
{
    // One side at the largest float, the other small: the crossing is clamped, never lost.
    for (const double inside : {1e-3, 1.0, kHuge})
        for (const double outside : {-1e-3, -kHuge, -std::numeric_limits<double>::infinity()}) {
            const CellExtractor extractor(
                std::make_shared<tests::FunctionField>([=](const glm::dvec3& p, double) {
                    return lumpyBall(p) >= 0 ? inside : outside;
                }),
                {},
                {.latticeSize = 4, .filterStrength = 0});
            const tests::GlobalMesh mesh = tests::extractFront(mixedFront(), extractor);
            EXPECT_EQ(mesh.defects().open, 0U);
            EXPECT_EQ(mesh.defects().degenerate, 0U);
            EXPECT_EQ(mesh.differingCopies, 0U);
            EXPECT_EQ(mesh.eulerNumber(), 2);
        }
}

TEST(Extremes, theDeepestCellsWorkAtEveryLatticeSize)
{
    auto generator = tests::random(64);
    for (const int n : {1, 4, 16}) {
        hierarchy::Tetrahedron cell = hierarchy::rootTetrahedra()[tests::below(generator, 6)];
        while (cell.level < hierarchy::kMaxLevel)
            cell = cell.bisected()[tests::below(generator, 2)];
        // The domain of a planet: the cell's corners are 6 mm apart.
        const hierarchy::Domain domain{{-6.7e6, -6.7e6, -6.7e6}, 1.34e7};
        const glm::dvec3 middle =
            0.25 *
            (domain.fieldFromLattice(cell.corner[0]) + domain.fieldFromLattice(cell.corner[1]) +
             domain.fieldFromLattice(cell.corner[2]) + domain.fieldFromLattice(cell.corner[3]));
        const CellExtractor extractor(
            std::make_shared<tests::FunctionField>(
                [=](const glm::dvec3& p, double) { return middle.z - p.z; }, 1e-3),
            domain,
            {.latticeSize = n, .filterStrength = 1, .cornerRadius = 1e-3});
        const auto mesh = extractor.extract(cell);
        ASSERT_TRUE(mesh);
        EXPECT_GT(mesh->triangleCount(), 0U) << n;
        for (const CellVertex& vertex : mesh->vertices) {
            const glm::dvec3 at = domain.fieldFromGrid(mesh->gridPosition(vertex));
            EXPECT_NEAR(at.z, middle.z, 2e-3) << "a vertex lies in its cell";
            EXPECT_GT(fromOctahedral(vertex.normal).z, 0.999);
        }
    }
}

} // namespace
} // namespace isofront::extractor

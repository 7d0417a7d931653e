#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

namespace isofront::extractor {
namespace {

/// How far the domain lies from the origin, as three different coordinates [m].
glm::dvec3 offsetOf(double metres)
{
    return metres * glm::dvec3(1.0, -0.7310585, 0.3141593);
}

/// A field of random values, solid nowhere near the walls of the domain: the surface is closed, and
/// every open edge is a crack.
std::shared_ptr<tests::FunctionField>
closedRandomField(const hierarchy::Domain& domain, std::uint64_t seed, bool threeValued)
{
    const glm::dvec3 centre = domain.origin + glm::dvec3(domain.edge / 2);
    return std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double radius) {
            const glm::dvec3 d = glm::abs(p - centre);
            if (std::max({d.x, d.y, d.z}) > 0.499 * domain.edge)
                return -1.0;
            const double value = tests::hashed(p, radius, seed);
            return threeValued ? std::floor(1.5 * (value + 1.0)) - 1.0 : value;
        },
        1e-3 * domain.edge);
}

void expectNoCracks(const tests::GlobalMesh& mesh)
{
    const auto defects = mesh.defects();
    EXPECT_EQ(defects.open, 0U);
    EXPECT_EQ(defects.nonManifold, 0U);
    EXPECT_EQ(defects.misoriented, 0U);
    EXPECT_EQ(defects.degenerate, 0U);
    EXPECT_EQ(mesh.differingCopies, 0U);
    EXPECT_GT(mesh.sharedCopies, 100U);
    EXPECT_GT(mesh.triangles.size(), 1000U);
}

struct BorderCase {
    double offset;
    int latticeSize;
    double filterStrength;
};

class Border : public testing::TestWithParam<BorderCase> {};

TEST_P(Border, hasNoCrackBetweenRandomCellsOfMixedLevels)
{
    const auto [offset, n, filterStrength] = GetParam();
    auto generator = tests::random(static_cast<std::uint64_t>(41 + n));
    for (int trial = 0; trial < tests::intensity(); ++trial)
        for (const bool threeValued : {false, true}) {
            const hierarchy::Domain domain{offsetOf(offset), trial % 2 == 0 ? 64.0 : 100.0 / 3.0};
            const std::size_t splits = n >= 16 ? 1 : n >= 8 ? 3 : 12;
            const hierarchy::Front front =
                tests::randomFront(generator, n >= 16 ? 1 : 2, 10, splits);
            const CellExtractor extractor(
                closedRandomField(domain, 7U + static_cast<std::uint64_t>(trial), threeValued),
                domain,
                {.latticeSize = n,
                 .isovalue = 0,
                 .filterStrength = filterStrength,
                 .cornerRadius = 1e-4 * domain.edge});
            SCOPED_TRACE(front.cellCount());
            expectNoCracks(tests::extractFront(front, extractor));
        }
}

INSTANTIATE_TEST_SUITE_P(
    OffsetsAndSizes,
    Border,
    testing::Values(
        BorderCase{0, 4, 1},
        BorderCase{0, 8, 1},
        BorderCase{0, 16, 1},
        BorderCase{1e3, 4, 0},
        BorderCase{1e3, 8, 1},
        BorderCase{1e5, 2, 1},
        BorderCase{1e5, 4, 1},
        BorderCase{1e5, 16, 0},
        BorderCase{6.4e6, 1, 1},
        BorderCase{6.4e6, 4, 1},
        BorderCase{6.4e6, 8, 1},
        BorderCase{6.4e6, 16, 1}),
    [](const auto& parameter) {
        const BorderCase& c = parameter.param;
        return "offset" + std::to_string(static_cast<long>(c.offset)) + "n" +
               std::to_string(c.latticeSize) + (c.filterStrength > 0 ? "filtered" : "plain");
    });

TEST(Border, hasNoCrackAtTheDeepestLevels)
{
    auto generator = tests::random(51);
    for (int trial = 0; trial < 2; ++trial) {
        hierarchy::Tetrahedron cell = hierarchy::rootTetrahedra()[tests::below(generator, 6)];
        while (cell.level < hierarchy::kMaxLevel - 1)
            cell = cell.bisected()[tests::below(generator, 2)];
        hierarchy::Front front;
        front.refine(cell.spineCentre());
        const hierarchy::Domain domain{offsetOf(6.4e6), 1.34e7};
        // down to 6 mm at the distance of the earth's radius
        const CellExtractor extractor(
            closedRandomField(domain, 3, false), domain, {.latticeSize = 1, .filterStrength = 0});
        const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
        EXPECT_EQ(mesh.defects().open, 0U);
        EXPECT_EQ(mesh.defects().nonManifold, 0U);
        EXPECT_EQ(mesh.defects().misoriented, 0U);
        EXPECT_EQ(mesh.differingCopies, 0U);
    }
}

TEST(Border, survivesNumbersThatAreNotFiniteAndCountsThem)
{
    const float infinite = std::numeric_limits<float>::infinity();
    const hierarchy::Domain domain{};
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(),
          double(infinite),
          -double(infinite),
          1e38,
          -1e38,
          1e-45}) {
        const auto field = std::make_shared<tests::FunctionField>(
            [=](const glm::dvec3& p, double) {
                if (glm::distance(p, glm::dvec3(0.4, 0.45, 0.5)) < 0.2)
                    return bad;
                return tests::sphere(p, glm::dvec3(0.5), 0.35);
            },
            1e-3);
        auto generator = tests::random(52);
        const hierarchy::Front front = tests::randomFront(generator, 5, 11, 10);
        const CellExtractor extractor(field, domain, {.latticeSize = 4, .filterStrength = 0});
        std::size_t sanitised = 0;
        tests::GlobalMesh mesh;
        front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            CellTrace trace;
            const auto part = extractor.extract(cell, &trace);
            sanitised += part->stats.sanitisedSamples;
            mesh.add(domain, *part, trace);
        });
        EXPECT_EQ(mesh.defects().open, 0U) << bad;
        EXPECT_EQ(mesh.defects().nonManifold, 0U) << bad;
        EXPECT_EQ(mesh.differingCopies, 0U) << bad;
        EXPECT_EQ(
            sanitised > 0, !(std::abs(bad) <= 0.25 * double(std::numeric_limits<float>::max())))
            << bad;
    }
}

TEST(Border, isOpenOnlyAtTheWallsAndClosedThereOnRequest)
{
    // a slanted plane leaves the domain on all sides; a random field does it in every possible way
    const hierarchy::Domain domain{offsetOf(1e3), 10.0};
    const auto plane = std::make_shared<tests::FunctionField>([&](const glm::dvec3& p, double) {
        const glm::dvec3 q = p - domain.origin - glm::dvec3(5.0);
        return 0.1 - q.x - 0.3 * q.y - 0.7 * q.z;
    });
    const auto noise = std::make_shared<tests::FunctionField>(
        [&](const glm::dvec3& p, double radius) { return tests::hashed(p, radius, 5); });
    const auto solid =
        std::make_shared<tests::FunctionField>([&](const glm::dvec3&, double) { return 1.0; });
    auto generator = tests::random(53);
    for (const auto& field : {plane, noise, solid})
        for (const bool closed : {false, true}) {
            const hierarchy::Front front = tests::randomFront(generator, 2, 8, 5);
            const CellExtractor extractor(
                field, domain, {.latticeSize = 4, .filterStrength = 0, .closed = closed});
            const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
            const auto defects = mesh.defects();
            EXPECT_EQ(defects.nonManifold, 0U);
            EXPECT_EQ(defects.misoriented, 0U);
            EXPECT_EQ(defects.degenerate, 0U);
            EXPECT_EQ(mesh.differingCopies, 0U);
            if (closed) {
                EXPECT_EQ(defects.open, 0U);
                EXPECT_GT(mesh.volume(), 0.0);
                if (field == solid) {
                    EXPECT_NEAR(mesh.volume(), 1000.0, 1e-6);
                }
                if (field == plane) {
                    EXPECT_EQ(mesh.eulerNumber(), 2);
                }
                continue;
            }
            EXPECT_EQ(defects.open > 0, field != solid);
            for (const auto& [a, b] : mesh.openEdges()) {
                bool onWall = false;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (const double wall :
                         {domain.origin[axis], domain.origin[axis] + domain.edge})
                        onWall = onWall || (a[axis] == wall && b[axis] == wall);
                EXPECT_TRUE(onWall);
            }
        }
}

TEST(Border, endsTheSurfaceAtTheDataAndClosesItThereOnRequest)
{
    // solid fills all of the data and more, but for a hole through it
    const core::Box data{{0.0, 0.0, 0.0}, {23.0, 17.0, 9.0}};
    const auto field = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return std::hypot(p.x - 11.0, p.y - 8.0) - 4.0; },
        0.5,
        data);
    const hierarchy::Domain domain{glm::dvec3(0.0), 32.0};
    const hierarchy::Front front = tests::uniformFront(6); // 4 hexahedra a cube edge: step 1
    for (const bool closed : {false, true}) {
        const CellExtractor extractor(
            field, domain, {.latticeSize = 4, .filterStrength = 0, .closed = closed});
        const tests::GlobalMesh mesh = tests::extractFront(front, extractor);
        const auto defects = mesh.defects();
        EXPECT_EQ(defects.nonManifold, 0U);
        EXPECT_EQ(defects.misoriented, 0U);
        EXPECT_EQ(mesh.differingCopies, 0U);
        if (closed) {
            EXPECT_EQ(defects.open, 0U);
            const double expected = (23.0 * 17.0 - std::numbers::pi * 16.0) * 9.0;
            EXPECT_NEAR(mesh.volume(), expected, 0.01 * expected);
            continue;
        }
        EXPECT_GT(defects.open, 0U);
        for (const auto& edge : mesh.openEdges())
            for (const glm::dvec3& p : edge) {
                double toBorder = std::numeric_limits<double>::infinity();
                for (std::size_t axis = 0; axis < 3; ++axis)
                    toBorder = std::min(
                        {toBorder,
                         std::abs(p[axis] - data.low[axis]),
                         std::abs(p[axis] - data.high[axis])});
                EXPECT_LE(toBorder, 1.0) << "within one axis step of the data's border";
            }
        // what is left is the wall of the hole: all of it about 4 from the axis
        for (const auto& t : mesh.triangles) {
            glm::dvec3 centre(0.0);
            for (const std::uint32_t v : t)
                centre += mesh.positions[v] / 3.0;
            if (centre.z > 1.0 && centre.z < 8.0) {
                EXPECT_NEAR(std::hypot(centre.x - 11.0, centre.y - 8.0), 4.0, 0.2);
            }
        }
    }
}

TEST(Border, closesABlockOfDataAndAHollowInIt)
{
    const core::Box data{{0.0, 0.0, 0.0}, {23.0, 17.0, 9.0}};
    const auto field = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) {
            return -tests::sphere(p, {11.1, 8.2, 4.4}, 3.1);
        },
        0.5,
        data);
    const CellExtractor extractor(
        field, {glm::dvec3(0.0), 32.0}, {.latticeSize = 4, .filterStrength = 0, .closed = true});
    const tests::GlobalMesh mesh = tests::extractFront(tests::uniformFront(6), extractor);
    EXPECT_EQ(mesh.defects().open, 0U);
    EXPECT_EQ(mesh.eulerNumber(), 4) << "the block and the hollow";
}

TEST(CellExtractor, givesTheSameBytesWithAndWithoutTheEmptyCellTest)
{
    // the sphere's own bounds, by its Lipschitz constant
    class BoundedSphere final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(
                    tests::sphere({batch.x[i], batch.y[i], batch.z[i]}, glm::dvec3(0.5), 0.3));
        }
        [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval) const override
        {
            const double middle = tests::sphere(box.centre(), glm::dvec3(0.5), 0.3);
            const double reach = glm::length(box.size()) / 2 + 1e-6;
            return {middle - reach, middle + reach};
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
    };
    const auto field = std::make_shared<BoundedSphere>();
    const hierarchy::Domain domain{};
    ExtractionSettings settings{.latticeSize = 4, .filterStrength = 0};
    const CellExtractor skipping(field, domain, settings);
    settings.skipEmptyCells = false;
    const CellExtractor thorough(field, domain, settings);
    std::size_t skipped = 0;
    std::size_t empty = 0;
    tests::uniformFront(12).forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            const auto a = skipping.extract(cell);
            const auto b = thorough.extract(cell);
            ASSERT_EQ(a->vertices, b->vertices);
            ASSERT_EQ(a->indices, b->indices);
            ASSERT_EQ(a->exponent, b->exponent);
            skipped += a->stats.provedEmpty ? 1U : 0U;
            empty += b->indices.empty() ? 1U : 0U;
            ASSERT_EQ(a->stats.provedEmpty ? 0U : 369U, a->stats.samples);
        });
    EXPECT_GT(double(skipped), 0.8 * double(empty));
}

TEST(CellExtractor, givesUpWhenItIsCancelled)
{
    const auto field = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::sphere(p, glm::dvec3(0.5), 0.3); });
    const CellExtractor extractor(field, {}, {.latticeSize = 4});
    const std::atomic<bool> cancelled{true};
    EXPECT_FALSE(extractor.extract(hierarchy::rootTetrahedra()[0], nullptr, &cancelled));
}

} // namespace
} // namespace isofront::extractor

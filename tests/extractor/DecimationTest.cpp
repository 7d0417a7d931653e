#include "extractor/CellChecks.h"
#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Criterion.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace isofront::extractor {
namespace {

using Field = std::shared_ptr<const fields::Field>;

Field fieldOf(std::function<double(const glm::dvec3&)> function)
{
    return std::make_shared<tests::FunctionField>(
        [function = std::move(function)](const glm::dvec3& p, double) { return function(p); },
        1e-4);
}

Field gyroid()
{
    return fieldOf([](const glm::dvec3& p) { return tests::gyroid(p, 1.7); });
}

Field noise()
{
    return fieldOf([](const glm::dvec3& p) { return tests::hashed(p, 0, 17); });
}

CellMesh extracted(const Field& field, ExtractionSettings settings, int root = 1)
{
    settings.filterStrength = 0;
    const CellExtractor extractor(field, {}, settings);
    return *extractor.extract(hierarchy::rootTetrahedra()[static_cast<std::size_t>(root)]);
}

TEST(Decimation, keepsTheBorderOfACellAndItsTopology)
{
    for (const Field& field : {gyroid(), noise()})
        for (const int n : {4, 8, 16})
            for (const double error : {0.02, 0.25, 10.0}) {
                SCOPED_TRACE(testing::Message() << "n = " << n << ", error = " << error);
                const CellMesh whole = extracted(field, {.latticeSize = n});
                const CellMesh few = extracted(field, {.latticeSize = n, .simplifyError = error});
                EXPECT_LT(few.triangleCount(), whole.triangleCount());
                EXPECT_EQ(tests::borderEdges(few), tests::borderEdges(whole));
                EXPECT_EQ(tests::eulerNumber(few), tests::eulerNumber(whole));
                EXPECT_EQ(tests::mostTrianglesAtAnEdge(few), 2);
                // what stays, stays where it is, in the order of first use
                const auto known = tests::positionsOf(whole);
                std::size_t next = 0;
                for (const std::uint16_t index : few.indices) {
                    ASSERT_LE(index, next);
                    next = std::max(next, std::size_t{index} + 1);
                }
                EXPECT_EQ(next, few.vertices.size());
                for (const auto& position : tests::positionsOf(few))
                    EXPECT_TRUE(known.contains(position));
            }
}

TEST(Decimation, leavesNoCrackBetweenCellsOfMixedLevels)
{
    auto generator = tests::random(81);
    const glm::dvec3 middle(0.503, 0.491, 0.507);
    const Field ball = fieldOf([=](const glm::dvec3& p) { return tests::sphere(p, middle, 0.37); });
    const Field closedNoise = fieldOf([](const glm::dvec3& p) {
        const glm::dvec3 d = glm::abs(p - 0.5);
        return std::max({d.x, d.y, d.z}) > 0.499 ? -1.0 : tests::hashed(p, 0, 18);
    });
    for (const Field& field : {ball, closedNoise})
        for (const int n : {2, 4, 8}) {
            const hierarchy::Front front = tests::randomFront(generator, 2, 9, n < 8 ? 8 : 3);
            const tests::GlobalMesh mesh = tests::extractFront(
                front,
                CellExtractor(
                    field,
                    {},
                    {.latticeSize = n,
                     .filterStrength = 0,
                     .smoothIterations = 2,
                     .reproject = true,
                     .simplifyError = 0.5}));
            const auto defects = mesh.defects();
            EXPECT_EQ(defects.open, 0U);
            EXPECT_EQ(defects.nonManifold, 0U);
            EXPECT_EQ(defects.misoriented, 0U);
            EXPECT_EQ(defects.degenerate, 0U);
            EXPECT_EQ(mesh.differingCopies, 0U);
            EXPECT_GT(mesh.sharedCopies, 100U);
            if (field == ball) {
                EXPECT_EQ(mesh.eulerNumber(), 2);
            }
        }
}

TEST(Decimation, leavesOfAPlaneLittleMoreThanItsBorder)
{
    const glm::dvec3 normal(0.3, 0.5, 0.41);
    const Field plane = fieldOf([=](const glm::dvec3& p) { return 0.437 - glm::dot(p, normal); });
    for (int root = 0; root < 6; ++root)
        for (const int n : {4, 8, 16}) {
            const CellMesh mesh = extracted(plane, {.latticeSize = n, .simplifyError = 0.1}, root);
            std::size_t locked = 0;
            for (const CellVertex& vertex : mesh.vertices)
                locked += (vertex.flags & CellVertex::border) != 0 ? 1U : 0U;
            ASSERT_GT(locked, std::size_t{3});
            // two more triangles for each vertex inside that is left: some are among so many border
            // vertices of one face that every collapse would join two of those
            EXPECT_LE(mesh.triangleCount(), locked - 2 + (n < 16 ? 8 : 12))
                << "n = " << n << ", root " << root;
        }
}

TEST(Decimation, movesNoSurfaceByMoreThanTwiceItsError)
{
    const Field ball = fieldOf([](const glm::dvec3& p) {
        return tests::sphere(p, {0.1, 0.05, 0.12}, 0.9);
    });
    // a bump as wide as a few steps on a wide plate: its triangles are few among many
    const Field bump = fieldOf([](const glm::dvec3& p) {
        const glm::dvec3 q = p - glm::dvec3(0.63, 0.31, 0.42);
        return 0.4201 - p.z + 0.03 * std::exp(-900 * (q.x * q.x + q.y * q.y));
    });
    for (const Field& field : {ball, bump, gyroid()})
        for (const int n : {8, 16})
            for (const double error : {0.05, 0.15, 0.25}) {
                const CellMesh whole = extracted(field, {.latticeSize = n});
                const CellMesh few = extracted(field, {.latticeSize = n, .simplifyError = error});
                const double step =
                    std::ldexp(hierarchy::axisStep(0, n), hierarchy::kGridBits - whole.exponent);
                double furthest = 0;
                for (const CellVertex& vertex : whole.vertices)
                    furthest = std::max(furthest, tests::distanceTo(few, vertex));
                EXPECT_LE(furthest, 2 * error * step) << "n = " << n << ", error " << error;
                EXPECT_GT(furthest, 0.2 * error * step) << "or nothing was simplified";
            }
}

TEST(Decimation, byEightChoicesIsNearlyAsGoodAsByAll)
{
    const Field field = gyroid();
    for (const int n : {8, 16}) {
        ExtractionSettings settings{.latticeSize = n, .simplifyError = 0.1};
        const auto whole = extracted(field, {.latticeSize = n});
        const auto rms = [&](const CellMesh& mesh) {
            double sum = 0;
            for (const CellVertex& vertex : whole.vertices)
                sum += std::pow(tests::distanceTo(mesh, vertex), 2);
            return std::sqrt(sum / double(whole.vertices.size()));
        };
        const CellMesh eight = extracted(field, settings);
        settings.simplifyChoices = 5000; // of at most so many vertices: nearly always the cheapest
        const CellMesh all = extracted(field, settings);
        EXPECT_LE(double(eight.triangleCount()), 1.15 * double(all.triangleCount()));
        EXPECT_LE(
            rms(eight) * double(eight.triangleCount()),
            1.15 * rms(all) * double(all.triangleCount()))
            << "the error at an equal number of triangles: it falls as their number grows";
    }
}

TEST(Decimation, dependsOnNothingButTheCell)
{
    // what else the thread has done must not show: same cell before and after others
    const CellExtractor extractor(
        gyroid(), {}, {.latticeSize = 8, .filterStrength = 0, .simplifyError = 0.1});
    const auto roots = hierarchy::rootTetrahedra();
    const auto first = extractor.extract(roots[0]);
    for (const auto& root : roots) {
        const auto other = extractor.extract(root);
        EXPECT_FALSE(other->indices.empty());
    }
    const auto again = extractor.extract(roots[0]);
    EXPECT_EQ(first->vertices, again->vertices);
    EXPECT_EQ(first->indices, again->indices);
}

} // namespace
} // namespace isofront::extractor

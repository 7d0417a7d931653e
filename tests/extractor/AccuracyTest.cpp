#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace isofront::extractor {
namespace {

tests::GlobalMesh extractUniform(
    const std::shared_ptr<tests::FunctionField>& field,
    int level,
    int n,
    const hierarchy::Domain& domain = {})
{
    return tests::extractFront(
        tests::uniformFront(level),
        CellExtractor(field, domain, {.latticeSize = n, .filterStrength = 0}));
}

TEST(Topology, isThatOfASphereATorusAndTwoSpheres)
{
    const glm::dvec3 centre(0.503, 0.491, 0.507);
    const auto sphere = std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double) { return tests::sphere(p, centre, 0.4); });
    const auto torus = std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double) { return tests::torus(p, centre, 0.3, 0.1); });
    const auto spheres = std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
        return std::max(
            tests::sphere(p, {0.25, 0.3, 0.3}, 0.15), tests::sphere(p, {0.7, 0.7, 0.6}, 0.2));
    });
    auto generator = tests::random(61);
    for (int trial = 0; trial < 3; ++trial) {
        const hierarchy::Front front = tests::randomFront(generator, 6, 14, 40);
        const auto eulerOf = [&](const auto& field) {
            const tests::GlobalMesh mesh =
                tests::extractFront(front, CellExtractor(field, {}, {.latticeSize = 4}));
            EXPECT_EQ(mesh.defects().open, 0U);
            EXPECT_GT(mesh.volume(), 0.0);
            return mesh.eulerNumber();
        };
        EXPECT_EQ(eulerOf(sphere), 2);
        EXPECT_EQ(eulerOf(torus), 0);
        EXPECT_EQ(eulerOf(spheres), 4);
    }
    const tests::GlobalMesh fine = extractUniform(sphere, 9, 4);
    const double expected = 4.0 / 3.0 * std::numbers::pi * 0.4 * 0.4 * 0.4;
    EXPECT_NEAR(fine.volume(), expected, 0.005 * expected);
}

TEST(Topology, ofAGyroidInABallIsThatOfARunAtHalfTheStep)
{
    // Two periods: passages are about 1/8 wide, so a step of 1/64 is an eighth of them. The clip is
    // rounded as much, because a sharp rim has no smallest feature: single samples in it stand
    // alone at any step. Shifted, because the gyroid's straight lines would run through sample
    // points, where rounding decides.
    const auto field = std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
        const double a =
            tests::gyroid(p + glm::dvec3(0.0131, 0.0277, 0.0419), 2.0) / (4 * std::numbers::pi);
        const double b = tests::sphere(p, {0.511, 0.497, 0.503}, 0.41);
        const double round = std::max(0.125 - std::abs(a - b), 0.0);
        return std::min(a, b) - round * round / 0.5;
    });
    const long fine = extractUniform(field, 9, 8).eulerNumber();
    const tests::GlobalMesh coarse = extractUniform(field, 9, 4);
    EXPECT_EQ(coarse.defects().open, 0U);
    EXPECT_EQ(coarse.eulerNumber(), fine);
    EXPECT_LT(fine, 0) << "it has handles";
    auto generator = tests::random(62);
    const tests::GlobalMesh mixed = tests::extractFront(
        tests::randomFront(generator, 9, 12, 30),
        CellExtractor(field, {}, {.latticeSize = 4, .filterStrength = 0}));
    EXPECT_EQ(mixed.eulerNumber(), fine);
}

TEST(Accuracy, errorFallsFourfoldWithEachDoublingOfTheLattice)
{
    const glm::dvec3 centre(0.503, 0.491, 0.507);
    const double radius = 0.37;
    const auto field = std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double) { return tests::sphere(p, centre, radius); });
    // the RMS distance found by another implementation, over another choice of points
    constexpr std::array<double, 4> kExpected{3.18e-3, 7.83e-4, 1.95e-4, 4.89e-5};
    double before = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const tests::GlobalMesh mesh = extractUniform(field, 3, 2 << i);
        double sum = 0;
        double area = 0;
        for (const auto& t : mesh.triangles) {
            const glm::dvec3& a = mesh.positions[t[0]];
            const glm::dvec3& b = mesh.positions[t[1]];
            const glm::dvec3& c = mesh.positions[t[2]];
            const double weight = glm::length(glm::cross(b - a, c - a)) / 2;
            // Cowper's rule of seven points, exact for degree five
            const auto squared = [&](double u, double v) {
                const double d = glm::distance(u * a + v * b + (1 - u - v) * c, centre) - radius;
                return d * d;
            };
            constexpr double kA = 0.059715871789770;
            constexpr double kB = 0.470142064105115;
            constexpr double kC = 0.797426985353087;
            constexpr double kD = 0.101286507323456;
            sum += weight *
                   (0.225 * squared(1.0 / 3, 1.0 / 3) +
                    0.132394152788506 * (squared(kA, kB) + squared(kB, kA) + squared(kB, kB)) +
                    0.125939180544827 * (squared(kC, kD) + squared(kD, kC) + squared(kD, kD)));
            area += weight;
        }
        const double rms = std::sqrt(sum / area);
        EXPECT_NEAR(rms, kExpected[i], 0.25 * kExpected[i]) << "n = " << (2 << i);
        if (i > 0) {
            EXPECT_NEAR(before / rms, 4.0, 0.4);
        }
        before = rms;
    }
}

TEST(Accuracy, theEstimateOfACellsErrorIsNearTheTrueOne)
{
    const glm::dvec3 centre(0.503, 0.491, 0.507);
    const auto field = std::make_shared<tests::FunctionField>(
        [=](const glm::dvec3& p, double) { return tests::sphere(p, centre, 0.37); });
    const CellExtractor extractor(
        field, {}, {.latticeSize = 8, .filterStrength = 0, .estimateError = true});
    tests::uniformFront(6).forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            const auto mesh = extractor.extract(cell);
            if (mesh->triangleCount() < 20)
                return;
            double worst = 0;
            for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
                glm::dvec3 middle(0.0);
                for (std::size_t k = 0; k < 3; ++k)
                    middle += extractor.domain().fieldFromGrid(
                                  mesh->gridPosition(mesh->vertices[mesh->indices[i + k]])) /
                              3.0;
                worst = std::max(worst, std::abs(glm::distance(middle, centre) - 0.37));
            }
            EXPECT_LE(double(mesh->stats.errorMax), worst * 1.01);
            EXPECT_GE(double(mesh->stats.errorMax), worst * 0.3);
            EXPECT_LE(mesh->stats.errorRms, mesh->stats.errorMax);
        });
}

TEST(Accuracy, normalsPointOutAndConverge)
{
    const glm::dvec3 centre(0.503, 0.491, 0.507);
    double before = 0;
    for (const double step : {4e-2, 2e-2, 1e-2}) {
        // not a distance, so that central differences are not exact
        const auto field = std::make_shared<tests::FunctionField>(
            [=](const glm::dvec3& p, double) {
                return std::exp(-8 * glm::dot(p - centre, p - centre) * (1 + 0.5 * p.x)) - 0.4;
            },
            step);
        const CellExtractor extractor(field, {}, {.latticeSize = 4, .filterStrength = 0});
        double worst = 0;
        tests::uniformFront(6).forEachCell([&](const hierarchy::CellId&,
                                               const hierarchy::Tetrahedron& cell) {
            const auto mesh = extractor.extract(cell);
            for (const CellVertex& vertex : mesh->vertices) {
                const glm::dvec3 p = extractor.domain().fieldFromGrid(mesh->gridPosition(vertex));
                const glm::dvec3 q = p - centre;
                // gradient of the exponent, turned outward
                const glm::dvec3 exact = glm::normalize(
                    2.0 * q * (1 + 0.5 * p.x) + glm::dvec3(0.5 * glm::dot(q, q), 0, 0));
                const glm::dvec3 normal = fromOctahedral(vertex.normal);
                worst = std::max(worst, std::acos(std::min(1.0, glm::dot(normal, exact))));
            }
        });
        if (before > 0) {
            EXPECT_NEAR(before / worst, 4.0, 0.6) << "second order in the step";
        }
        before = worst;
    }
    EXPECT_LT(before, 0.01);
}

TEST(Octahedral, keepsUnitVectorsToWithinATenthOfAThousandth)
{
    auto generator = tests::random(63);
    for (int i = 0; i < 100000; ++i) {
        const glm::dvec3 v = glm::normalize(glm::dvec3(
            tests::uniform(generator, -1, 1),
            tests::uniform(generator, -1, 1),
            tests::uniform(generator, -1, 1)));
        ASSERT_LT(glm::distance(fromOctahedral(octahedral(v)), v), 1e-4);
    }
    for (const glm::dvec3& axis :
         {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)})
        EXPECT_LT(glm::distance(fromOctahedral(octahedral(axis)), axis), 1e-9);
}

} // namespace
} // namespace isofront::extractor

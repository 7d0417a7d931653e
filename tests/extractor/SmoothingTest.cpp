#include "extractor/CellChecks.h"
#include "support/FunctionField.h"
#include "support/GlobalMesh.h"
#include "support/RandomFront.h"

#include <isofront/extractor/CellExtractor.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

namespace isofront::extractor {
namespace {

using Field = std::shared_ptr<const fields::Field>;

const glm::dvec3 kCentre(0.503, 0.491, 0.507);
constexpr double kRadius = 0.37;

Field ball()
{
    return std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::sphere(p, kCentre, kRadius); });
}

/// What a setting makes of a ball.
struct Outcome {
    double slivers = 0; ///< share of poor triangles, of those without border vertices
    double rms = 0;     ///< of the distance from the sphere, at triangles' middles and corners
    double volume = 0;
    double onSurface = 0; ///< share of inner vertices within a cell unit of the sphere
};

Outcome outcomeOf(const ExtractionSettings& settings)
{
    const CellExtractor extractor(ball(), {}, settings);
    Outcome result;
    tests::GlobalMesh all;
    std::size_t inner = 0;
    std::size_t vertices = 0;
    tests::uniformFront(6).forEachCell(
        [&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
            CellTrace trace;
            const auto mesh = extractor.extract(cell, &trace);
            all.add(extractor.domain(), *mesh, trace);
            for (const CellVertex& vertex : mesh->vertices) {
                const glm::dvec3 p = extractor.domain().fieldFromGrid(mesh->gridPosition(vertex));
                if ((vertex.flags & CellVertex::border) != 0)
                    continue;
                ++vertices;
                const double unit = std::ldexp(extractor.domain().gridUnit(), mesh->exponent);
                result.onSurface += std::abs(glm::distance(p, kCentre) - kRadius) < unit ? 1 : 0;
            }
            for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
                const CellVertex& a = mesh->vertices[mesh->indices[i]];
                const CellVertex& b = mesh->vertices[mesh->indices[i + 1]];
                const CellVertex& c = mesh->vertices[mesh->indices[i + 2]];
                if (((a.flags | b.flags | c.flags) & CellVertex::border) != 0)
                    continue;
                ++inner;
                const double shape = tests::shapeOf(
                    tests::localPosition(a), tests::localPosition(b), tests::localPosition(c));
                result.slivers += shape < 0.2 ? 1 : 0;
            }
        });
    EXPECT_EQ(all.defects().open, 0U);
    EXPECT_EQ(all.differingCopies, 0U);
    result.slivers /= double(inner);
    result.onSurface /= double(vertices);
    result.volume = all.volume();
    double sum = 0;
    double area = 0;
    for (const auto& t : all.triangles) {
        const glm::dvec3& a = all.positions[t[0]];
        const glm::dvec3& b = all.positions[t[1]];
        const glm::dvec3& c = all.positions[t[2]];
        const double weight = glm::length(glm::cross(b - a, c - a)) / 2;
        const auto squared = [](const glm::dvec3& p) {
            return std::pow(glm::distance(p, kCentre) - kRadius, 2);
        };
        // exact for a distance that varies as a square: middles of sides
        sum +=
            weight * (squared((a + b) / 2.0) + squared((b + c) / 2.0) + squared((c + a) / 2.0)) / 3;
        area += weight;
    }
    result.rms = std::sqrt(sum / area);
    return result;
}

TEST(Smoothing, leavesFewSliversAndTheSurfaceWhereItWas)
{
    const Outcome rough = outcomeOf({.latticeSize = 8, .filterStrength = 0});
    EXPECT_GT(rough.slivers, 0.05);
    for (const bool reproject : {false, true})
        for (const int passes : {1, reproject ? 4 : 2}) {
            const Outcome smooth = outcomeOf(
                {.latticeSize = 8,
                 .filterStrength = 0,
                 .smoothIterations = passes,
                 .reproject = reproject});
            SCOPED_TRACE(testing::Message() << passes << " passes, reproject " << reproject);
            EXPECT_LT(smooth.slivers, 0.25 * rough.slivers);
            EXPECT_LT(smooth.rms, 1.1 * rough.rms);
            EXPECT_NEAR(smooth.volume, rough.volume, 1e-3 * rough.volume);
        }
}

TEST(Smoothing, andProjectionPutVerticesOnTheSurface)
{
    ExtractionSettings settings{.latticeSize = 8, .filterStrength = 0, .smoothIterations = 3};
    EXPECT_LT(outcomeOf(settings).onSurface, 0.3);
    settings.reproject = true;
    // for a distance one Newton step is exact, but for floats and the cell's grid; what is left are
    // vertices that would have turned a triangle
    EXPECT_GT(outcomeOf(settings).onSurface, 0.95);
}

TEST(Smoothing, neitherMovesBordersNorTurnsTriangles)
{
    // random signs make the worst of surfaces
    const auto noise = std::make_shared<tests::FunctionField>(
        [](const glm::dvec3& p, double) { return tests::hashed(p, 0, 23); });
    const CellExtractor rough(noise, {}, {.latticeSize = 8, .filterStrength = 0});
    const CellExtractor smooth(
        noise,
        {},
        {.latticeSize = 8, .filterStrength = 0, .smoothIterations = 3, .reproject = true});
    for (const hierarchy::Tetrahedron& cell : hierarchy::rootTetrahedra()) {
        const auto before = rough.extract(cell);
        const auto after = smooth.extract(cell);
        ASSERT_EQ(before->indices, after->indices);
        std::size_t moved = 0;
        for (std::size_t i = 0; i < before->vertices.size(); ++i) {
            const bool stays = before->vertices[i].position == after->vertices[i].position;
            moved += stays ? 0U : 1U;
            if ((before->vertices[i].flags & CellVertex::border) != 0) {
                EXPECT_EQ(before->vertices[i], after->vertices[i]);
            }
        }
        EXPECT_GT(moved, before->vertices.size() / 20);
        const auto normalOf = [&](const CellMesh& mesh, std::size_t i) {
            const auto corner = [&](std::size_t k) {
                return tests::localPosition(mesh.vertices[mesh.indices[i + k]]);
            };
            return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
        };
        for (std::size_t i = 0; i < before->indices.size(); i += 3) {
            const glm::dvec3 a = normalOf(*before, i);
            const glm::dvec3 b = normalOf(*after, i);
            ASSERT_GE(glm::dot(a, b), 0.2 * glm::length(a) * glm::length(b) * (1 - 1e-12));
            ASSERT_GT(glm::length(b), 0.0);
        }
    }
}

} // namespace
} // namespace isofront::extractor

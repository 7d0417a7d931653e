#include "support/FunctionField.h"

#include <isofront/fields/Combine.h>
#include <isofront/surface/MeshExtraction.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

namespace isofront::surface {
namespace {

std::shared_ptr<const extractor::CellExtractor> makeExtractor(
    const std::shared_ptr<const fields::Field>& field,
    const hierarchy::Domain& domain = {},
    bool estimateError = false)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    settings.filterStrength = 0;
    settings.estimateError = estimateError;
    return std::make_shared<const extractor::CellExtractor>(field, domain, settings);
}

std::shared_ptr<const fields::Field> ball()
{
    return std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
        return tests::sphere(p, {0.503, 0.491, 0.507}, 0.37);
    });
}

/// Edges that are not used once each way, by index.
std::size_t badEdges(const TriangleMesh& mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k)
            ++uses[{mesh.indices[i + k], mesh.indices[i + (k + 1) % 3]}];
    std::size_t bad = 0;
    for (const auto& [edge, count] : uses) {
        const auto back = uses.find({edge.second, edge.first});
        bad += count != 1 || back == uses.end() || back->second != 1 ? 1U : 0U;
    }
    return bad;
}

double volumeOf(const TriangleMesh& mesh)
{
    double sum = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        sum += glm::dot(
                   mesh.positions[mesh.indices[i]] - mesh.bounds.centre(),
                   glm::cross(
                       mesh.positions[mesh.indices[i + 1]] - mesh.bounds.centre(),
                       mesh.positions[mesh.indices[i + 2]] - mesh.bounds.centre())) /
               6;
    return sum;
}

MeshExtractionOptions atLevel(int level)
{
    MeshExtractionOptions options;
    options.detail.level = level;
    return options;
}

TEST(MeshExtraction, joinsCellsToOneClosedMeshOfTheRightSize)
{
    const auto jobs = core::makeJobs();
    const auto result = extractMesh(makeExtractor(ball()), *jobs, atLevel(9));
    ASSERT_TRUE(result.has_value());
    EXPECT_EQ(badEdges(result->mesh), 0U);
    const double expected = 4.0 / 3 * std::numbers::pi * std::pow(0.37, 3);
    EXPECT_NEAR(volumeOf(result->mesh), expected, 0.005 * expected);
    EXPECT_EQ(result->finestLevel, 9);
    for (std::size_t i = 0; i < result->mesh.positions.size(); ++i) {
        const glm::dvec3 out =
            glm::normalize(result->mesh.positions[i] - glm::dvec3(0.503, 0.491, 0.507));
        ASSERT_GT(glm::dot(out, glm::dvec3(result->mesh.normals[i])), 0.999);
    }
}

TEST(MeshExtraction, keepsTrianglesFacingOutThroughAMirroringMap)
{
    hierarchy::Domain domain;
    domain.worldFromField.linear = glm::dmat3(-2, 0, 0, 0, 0.3, 3, 0, 1.5, 0);
    domain.worldFromField.translation = {100, -50, 7};
    const double scale = std::abs(glm::determinant(domain.worldFromField.linear));
    for (const bool mirrored : {false, true}) {
        if (mirrored)
            domain.worldFromField.linear[0] = -domain.worldFromField.linear[0];
        const auto jobs = core::makeJobs(core::JobsBackend::inlined);
        const auto result = extractMesh(makeExtractor(ball(), domain), *jobs, atLevel(9));
        ASSERT_TRUE(result.has_value());
        EXPECT_EQ(badEdges(result->mesh), 0U);
        const double expected = scale * 4.0 / 3 * std::numbers::pi * std::pow(0.37, 3);
        EXPECT_NEAR(volumeOf(result->mesh), expected, 0.005 * expected);
        // normals agree with the triangles, but for specks around samples near the isovalue
        double sum = 0;
        std::size_t turned = 0;
        for (std::size_t i = 0; i < result->mesh.indices.size(); i += 3) {
            const auto corner = [&](std::size_t k) {
                return result->mesh.positions[result->mesh.indices[i + k]];
            };
            const glm::dvec3 face = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
            const glm::dvec3 normal(result->mesh.normals[result->mesh.indices[i]]);
            const double agreement = glm::dot(glm::normalize(face), normal);
            turned += agreement > 0 ? 0U : 1U;
            sum += agreement;
        }
        EXPECT_LT(turned, result->mesh.indices.size() / 3 / 1000);
        EXPECT_GT(3 * sum / double(result->mesh.indices.size()), 0.99);
    }
}

TEST(MeshExtraction, givesTheSameBytesOnAnyNumberOfThreads)
{
    const auto extractor = makeExtractor(ball());
    const auto one = core::makeJobs(core::JobsBackend::inlined);
    const auto reference = extractMesh(extractor, *one, atLevel(8));
    for (const std::size_t threads : {1U, 2U, 8U}) {
        const auto jobs = core::makeJobs(core::JobsBackend::threads, threads);
        const auto result = extractMesh(extractor, *jobs, atLevel(8));
        ASSERT_EQ(result->mesh.indices, reference->mesh.indices);
        ASSERT_TRUE(result->mesh.positions == reference->mesh.positions);
        ASSERT_TRUE(result->mesh.normals == reference->mesh.normals);
    }
}

TEST(MeshExtraction, polishedAndColouredGivesTheSameBytesOnAnyNumberOfThreads)
{
    const core::Box box{glm::dvec3(0.0), glm::dvec3(1.0)};
    extractor::ExtractionSettings settings;
    settings.latticeSize = 8;
    settings.filterStrength = 0;
    settings.smoothIterations = 2;
    settings.reproject = true;
    settings.simplifyError = 0.05;
    settings.alignEdges = true;
    settings.vertices = extractor::VertexPlacement::balanced;
    settings.attributes = true;
    const auto field = fields::colouredByPlace(ball(), box);
    const auto extractor =
        std::make_shared<const extractor::CellExtractor>(field, hierarchy::Domain{}, settings);
    std::optional<TriangleMesh> reference;
    for (const std::size_t threads : {1U, 2U, 8U}) {
        const auto jobs = core::makeJobs(core::JobsBackend::threads, threads);
        const auto result = extractMesh(extractor, *jobs, atLevel(7));
        ASSERT_TRUE(result.has_value());
        EXPECT_GT(result->smoothSeconds, 0.0);
        EXPECT_GT(result->simplifySeconds, 0.0);
        if (!reference) {
            reference = result->mesh;
            EXPECT_EQ(badEdges(*reference), 0U);
            // each vertex has the colour of its own place: nothing is mixed at borders
            std::vector<double> x, y, z;
            for (const glm::dvec3& p : reference->positions) {
                x.push_back(p.x);
                y.push_back(p.y);
                z.push_back(p.z);
            }
            std::vector<std::uint32_t> words(x.size());
            field->attributes({x, y, z}, words);
            EXPECT_TRUE(std::ranges::equal(words, reference->attributes));
            continue;
        }
        ASSERT_EQ(result->mesh.indices, reference->indices);
        ASSERT_TRUE(result->mesh.positions == reference->positions);
        ASSERT_TRUE(result->mesh.normals == reference->normals);
        ASSERT_EQ(result->mesh.attributes, reference->attributes);
    }
}

TEST(MeshExtraction, refinesUntilTheEstimatedErrorIsBelowTheBound)
{
    // a large ball and a small bump: only the bump needs fine cells
    const auto field = std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
        return std::max(
            tests::sphere(p, {0.5, 0.5, 0.4}, 0.3), tests::sphere(p, {0.51, 0.49, 0.71}, 0.03));
    });
    const auto jobs = core::makeJobs();
    MeshExtractionOptions options;
    options.detail.kind = Detail::Kind::error;
    options.detail.level = 60;
    std::size_t before = 0;
    for (const double bound : {1e-3, 2.5e-4}) {
        options.detail.maxError = bound;
        const auto result = extractMesh(makeExtractor(field, {}, true), *jobs, options);
        ASSERT_TRUE(result.has_value());
        EXPECT_EQ(badEdges(result->mesh), 0U);
        EXPECT_LE(result->errorMax, bound);
        EXPECT_GT(result->errorMax, bound / 20);
        // the estimate is honest: triangle centres lie about as near to the true surface
        double worst = 0;
        for (std::size_t i = 0; i < result->mesh.indices.size(); i += 3) {
            glm::dvec3 c(0.0);
            for (std::size_t k = 0; k < 3; ++k)
                c += result->mesh.positions[result->mesh.indices[i + k]] / 3.0;
            worst = std::max(
                worst,
                std::abs(std::max(
                    tests::sphere(c, {0.5, 0.5, 0.4}, 0.3),
                    tests::sphere(c, {0.51, 0.49, 0.71}, 0.03))));
        }
        EXPECT_LE(worst, 2 * bound);
        EXPECT_GT(result->mesh.indices.size(), before);
        before = result->mesh.indices.size();
    }
}

TEST(MeshExtraction, isFinerNearTheViewer)
{
    const auto jobs = core::makeJobs();
    MeshExtractionOptions options;
    options.detail.kind = Detail::Kind::view;
    options.detail.level = 30;
    options.detail.view.eye = {0.95, 0.5, 0.5};
    options.detail.view.height = 200;
    const auto result = extractMesh(makeExtractor(ball()), *jobs, options);
    ASSERT_TRUE(result.has_value());
    EXPECT_EQ(badEdges(result->mesh), 0U);
    double nearArea = 0;
    double farArea = 0;
    std::size_t nearCount = 0;
    std::size_t farCount = 0;
    for (std::size_t i = 0; i < result->mesh.indices.size(); i += 3) {
        const auto corner = [&](std::size_t k) {
            return result->mesh.positions[result->mesh.indices[i + k]];
        };
        const double area =
            glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0))) / 2;
        const bool isNear = corner(0).x > 0.8;
        (isNear ? nearArea : farArea) += area;
        ++(isNear ? nearCount : farCount);
    }
    EXPECT_LT(nearArea / double(nearCount), 0.3 * farArea / double(farCount));
}

TEST(MeshExtraction, refusesWhatExceedsItsMemoryAndStopsWhenAsked)
{
    const auto jobs = core::makeJobs();
    auto options = atLevel(40);
    options.memoryLimit = std::size_t{16} << 20U;
    const auto tooMuch = extractMesh(makeExtractor(ball()), *jobs, options);
    ASSERT_FALSE(tooMuch.has_value());
    EXPECT_EQ(tooMuch.error().code, core::ErrorCode::resourceLimit);

    std::stop_source source;
    source.request_stop();
    options = atLevel(9);
    options.stop = source.get_token();
    const auto stopped = extractMesh(makeExtractor(ball()), *jobs, options);
    ASSERT_FALSE(stopped.has_value());
    EXPECT_EQ(stopped.error().code, core::ErrorCode::interrupted);
}

TEST(MeshExtraction, ofNothingIsAnEmptyMesh)
{
    const auto jobs = core::makeJobs();
    const auto field =
        std::make_shared<tests::FunctionField>([](const glm::dvec3&, double) { return -1.0; });
    const auto result = extractMesh(makeExtractor(field), *jobs, atLevel(6));
    ASSERT_TRUE(result.has_value());
    EXPECT_TRUE(result->mesh.indices.empty());
    EXPECT_TRUE(result->mesh.bounds.isEmpty());
    EXPECT_GT(result->samples, 0U);
}

} // namespace
} // namespace isofront::surface

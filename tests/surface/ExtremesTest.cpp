#include "support/FunctionField.h"
#include "support/Random.h"

#include <isofront/fields/Shapes.h>
#include <isofront/surface/MeshExtraction.h>
#include <isofront/surface/Surface.h>
#include <isofront/volume/VolumeField.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

namespace isofront::surface {
namespace {

/// How often each edge of a joined mesh is used, with direction.
struct EdgeCount {
    std::size_t open = 0;
    std::size_t nonManifold = 0;
};

EdgeCount edgesOf(const TriangleMesh& mesh)
{
    std::map<std::array<std::uint32_t, 2>, std::array<int, 2>> uses;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.indices[i + k];
            const std::uint32_t b = mesh.indices[i + (k + 1) % 3];
            ++uses[{std::min(a, b), std::max(a, b)}][a < b ? 0 : 1];
        }
    EdgeCount count;
    for (const auto& [edge, both] : uses) {
        count.open += both[0] != both[1] ? 1U : 0U;
        count.nonManifold += both[0] + both[1] > 2 ? 1U : 0U;
    }
    return count;
}

SurfaceOptions options()
{
    SurfaceOptions result;
    result.extraction.latticeSize = 4;
    result.extraction.filterStrength = 0;
    result.maxLevel = 30;
    return result;
}

TEST(SurfaceExtremes, aViewerAtTheDomainsCornerIsServed)
{
    const double edge = 1000.0;
    for (const glm::dvec3 corner : {glm::dvec3(0.0), glm::dvec3(edge), glm::dvec3(0, edge, 0)}) {
        // The surface runs through the corner too: detail down to the deepest level allowed.
        Surface surface(
            fields::plane(corner, {1.0, -1.0, 0.2}), {glm::dvec3(0.0), edge}, options());
        hierarchy::View view;
        view.eye = corner;
        view.width = 64;
        view.height = 48;
        const Delta delta = surface.settle(view);
        EXPECT_TRUE(surface.isSettled());
        EXPECT_FALSE(delta.added.empty());
        EXPECT_LT(surface.stats().frontCells, 200000U);
    }
}

TEST(SurfaceExtremes, aViewerFarAwayGetsAHandfulOfCells)
{
    Surface surface(fields::sphere(glm::dvec3(500.0), 300.0), {glm::dvec3(0.0), 1000.0}, options());
    for (const double away : {1e12, 1e15, 1e30}) {
        hierarchy::View view;
        view.eye = {away, -away, 0.5 * away};
        const Delta delta = surface.settle(view);
        EXPECT_TRUE(surface.isSettled());
        EXPECT_GE(surface.stats().frontCells, 6U) << away;
        EXPECT_LE(surface.stats().frontCells, 48U) << away;
    }
    hierarchy::View near;
    near.eye = {500, 100, 500};
    near.width = 320;
    near.height = 200;
    surface.settle(near);
    EXPECT_GT(surface.stats().frontCells, 500U) << "and comes back";
}

/// A volume as small as can be, extracted at a quarter of a voxel.
ExtractedMesh
blockOf(glm::ivec3 dimensions, std::vector<float> voxels, double isovalue, bool closed = true)
{
    const auto data = std::shared_ptr<float[]>(new float[voxels.size()]);
    std::ranges::copy(voxels, data.get());
    double edge = 2;
    while (edge < std::max({dimensions.x, dimensions.y, dimensions.z}) - 1)
        edge *= 2;
    const auto extractor = std::make_shared<extractor::CellExtractor>(
        std::make_shared<volume::VolumeField<float>>(dimensions, data),
        hierarchy::Domain{glm::dvec3(0.0), edge},
        extractor::ExtractionSettings{
            .latticeSize = 4, .isovalue = isovalue, .filterStrength = 0, .closed = closed});
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    MeshExtractionOptions how;
    how.detail.kind = Detail::Kind::level;
    how.detail.level = 9;
    auto mesh = extractMesh(extractor, *jobs, how);
    EXPECT_TRUE(mesh.has_value());
    return std::move(*mesh);
}

TEST(SurfaceExtremes, volumesOfOneAndAFewVoxels)
{
    // A single voxel, a row and a slice have no inside. Open there is nothing to see; closed they
    // are shells a sixty-fourth of a step thick, and closed indeed.
    struct Flat {
        glm::ivec3 size;
        std::vector<float> voxels;
    };
    for (const Flat& flat :
         {Flat{{1, 1, 1}, {1}}, Flat{{3, 1, 1}, {1, 1, 1}}, Flat{{2, 2, 1}, {1, 1, 1, 1}}}) {
        EXPECT_TRUE(blockOf(flat.size, flat.voxels, 0.5, false).mesh.indices.empty());
        const ExtractedMesh shell = blockOf(flat.size, flat.voxels, 0.5);
        EXPECT_EQ(edgesOf(shell.mesh).open, 0U);
        EXPECT_LT(shell.mesh.bounds.size().z, 0.1);
    }
    // Eight voxels are a cube of one, cut by the isovalue.
    const ExtractedMesh cube = blockOf({2, 2, 2}, std::vector<float>(8, 1.0F), 0.5);
    EXPECT_FALSE(cube.mesh.indices.empty());
    EXPECT_EQ(edgesOf(cube.mesh).open, 0U);
    EXPECT_NEAR(cube.mesh.bounds.size().x, 1.0, 0.05);
    const ExtractedMesh slope = blockOf({2, 2, 2}, {0, 1, 0, 1, 0, 1, 0, 1}, 0.5);
    EXPECT_EQ(edgesOf(slope.mesh).open, 0U);
    EXPECT_NEAR(slope.mesh.bounds.low.x, 0.5, 0.01);
    // Dimensions that are no power of two.
    auto generator = tests::random(71);
    for (const glm::ivec3 size : {glm::ivec3(3, 5, 7), glm::ivec3(17, 2, 9), glm::ivec3(4, 4, 4)}) {
        std::vector<float> voxels(static_cast<std::size_t>(size.x * size.y * size.z));
        for (float& voxel : voxels)
            voxel = static_cast<float>(tests::uniform(generator, -1, 1));
        voxels[voxels.size() / 2] = std::numeric_limits<float>::quiet_NaN();
        const ExtractedMesh mesh = blockOf(size, voxels, 0.1);
        EXPECT_FALSE(mesh.mesh.indices.empty());
        EXPECT_EQ(edgesOf(mesh.mesh).open, 0U);
        EXPECT_EQ(edgesOf(mesh.mesh).nonManifold, 0U);
        EXPECT_GT(mesh.sanitisedSamples, 0U);
    }
}

} // namespace
} // namespace isofront::surface

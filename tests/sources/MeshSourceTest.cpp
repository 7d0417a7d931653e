// Meshes as sources: read from files, turned into distances, extracted, and held against the mesh.

#include "support/TemporaryFolder.h"

#include <isofront/bench/Topology.h>
#include <isofront/bench/TriangleTree.h>
#include <isofront/exchange/MeshFile.h>
#include <isofront/sources/Source.h>
#include <isofront/surface/MeshExtraction.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

namespace isofront::sources {
namespace {

using surface::TriangleMesh;

void addVertex(TriangleMesh& mesh, const glm::dvec3& position)
{
    mesh.positions.push_back(position);
    mesh.normals.push_back({0, 0, 1});
    mesh.bounds.include(position);
}

void addQuadrangle(
    TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d)
{
    for (const std::uint32_t corner : {a, b, c, a, c, d})
        mesh.indices.push_back(corner);
}

constexpr double kRing = 2.0;
constexpr double kTube = 0.7;

TriangleMesh torus(std::uint32_t around, std::uint32_t across)
{
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around;
            const double v = 2 * std::numbers::pi * j / across;
            const double ring = kRing + kTube * std::cos(v);
            addVertex(mesh, {5 + ring * std::cos(u), ring * std::sin(u), kTube * std::sin(v)});
        }
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const std::uint32_t next = (i + 1) % around;
            const std::uint32_t up = (j + 1) % across;
            addQuadrangle(
                mesh, i * across + j, next * across + j, next * across + up, i * across + up);
        }
    return mesh;
}

/// A ball of radius 1, from its south pole up to a height.
TriangleMesh ball(std::uint32_t rows, bool isWhole)
{
    TriangleMesh mesh;
    const std::uint32_t columns = 2 * rows;
    const std::uint32_t last = isWhole ? rows : rows / 2;
    for (std::uint32_t i = 1; i <= last && i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const double theta = std::numbers::pi * i / rows;
            const double phi = 2 * std::numbers::pi * j / columns;
            addVertex(
                mesh,
                {std::sin(theta) * std::cos(phi),
                 std::sin(theta) * std::sin(phi),
                 -std::cos(theta)});
        }
    const auto rings = static_cast<std::uint32_t>(mesh.positions.size()) / columns;
    const auto addPole = [&](double height, std::uint32_t ring, bool isUpper) {
        const auto pole = static_cast<std::uint32_t>(mesh.positions.size());
        addVertex(mesh, {0, 0, height});
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = ring * columns + j;
            const std::uint32_t b = ring * columns + (j + 1) % columns;
            for (const std::uint32_t corner : {pole, isUpper ? a : b, isUpper ? b : a})
                mesh.indices.push_back(corner);
        }
    };
    for (std::uint32_t i = 0; i + 1 < rings; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * columns + j;
            const std::uint32_t b = i * columns + (j + 1) % columns;
            addQuadrangle(mesh, a, b, b + columns, a + columns);
        }
    addPole(-1, 0, false);
    if (isWhole)
        addPole(1, rings - 1, true);
    return mesh;
}

double volumeOf(const TriangleMesh& mesh)
{
    double sum = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        sum += glm::dot(
            mesh.positions[mesh.indices[i]],
            glm::cross(mesh.positions[mesh.indices[i + 1]], mesh.positions[mesh.indices[i + 2]]));
    return sum / 6;
}

/// The farthest vertex of one mesh from the triangles of another.
double farthest(const TriangleMesh& from, const TriangleMesh& to)
{
    const bench::TriangleTree tree(to);
    double most = 0;
    for (const glm::dvec3& position : from.positions)
        most = std::max(most, tree.nearest(position).distance);
    return most;
}

class MeshSource : public testing::Test {
protected:
    [[nodiscard]] std::string written(const TriangleMesh& mesh, const std::string& name) const
    {
        const auto path = folder.path(name);
        EXPECT_TRUE(exchange::writeMesh(mesh, path, {}));
        return path.string();
    }

    static TriangleMesh extracted(const Source& source, double isovalue)
    {
        extractor::ExtractionSettings settings;
        settings.latticeSize = 4;
        settings.isovalue = source.fieldIsovalue(isovalue);
        settings.filterStrength = 0;
        surface::MeshExtractionOptions options;
        options.detail.level = levelForStep(*source.voxel / source.domain.edge, 4);
        settings.cornerRadius =
            2 * hierarchy::axisStep(options.detail.level, 4) * source.domain.edge;
        const auto extractor =
            std::make_shared<const extractor::CellExtractor>(source.field, source.domain, settings);
        const auto jobs = core::makeJobs(core::JobsBackend::automatic, 0);
        auto result = surface::extractMesh(extractor, *jobs, options);
        EXPECT_TRUE(result);
        return result ? std::move(result->mesh) : TriangleMesh();
    }

    tests::TemporaryFolder folder;
};

TEST_F(MeshSource, isExtractedWithinHalfAVoxelOfTheMesh)
{
    const struct {
        TriangleMesh mesh;
        long euler;
        double area;
    } shapes[] = {
        {ball(24, true), 2, 4 * std::numbers::pi},
        {torus(48, 24), 0, 4 * std::numbers::pi * std::numbers::pi * kRing * kTube}};
    for (const auto& shape : shapes) {
        const auto source = openSource(written(shape.mesh, "a.ply"), {.meshResolution = 48});
        ASSERT_TRUE(source) << source.error().message;
        EXPECT_TRUE(source->notes.empty());
        EXPECT_EQ(source->identity, "a.ply?resolution=48");
        EXPECT_EQ(source->defaultIsovalue, 0);
        const TriangleMesh found = extracted(*source, 0);
        const double voxel = source->volume->info.spacing.x;
        EXPECT_LT(farthest(found, shape.mesh), 0.5 * voxel);
        EXPECT_LT(farthest(shape.mesh, found), 0.5 * voxel);
        EXPECT_NEAR(volumeOf(found), volumeOf(shape.mesh), 0.05 * voxel * shape.area);
        const bench::Topology topology = bench::topologyOf(found);
        EXPECT_EQ(topology.euler, shape.euler);
        EXPECT_EQ(topology.components, 1U);
        EXPECT_EQ(topology.openEdges, 0U);
        EXPECT_EQ(topology.nonManifold, 0U);
    }
}

TEST_F(MeshSource, growsByItsIsovalue)
{
    const TriangleMesh mesh = torus(96, 48);
    const auto source =
        openSource(written(mesh, "torus.glb"), {.meshResolution = 64, .meshReach = 0.5});
    ASSERT_TRUE(source) << source.error().message;
    const double voxel = source->volume->info.spacing.x;
    for (const double offset : {-0.45, -0.2, 0.2, 0.45}) {
        const TriangleMesh found = extracted(*source, offset);
        ASSERT_FALSE(found.indices.empty());
        double most = 0;
        for (const glm::dvec3& p : found.positions) {
            const double ring = std::hypot(std::hypot(p.x - 5, p.y) - kRing, p.z);
            most = std::max(most, std::abs(ring - (kTube + offset)));
        }
        EXPECT_LT(most, 0.25 * voxel) << offset;
        EXPECT_EQ(bench::topologyOf(found).euler, 0) << offset;
    }
    EXPECT_TRUE(extracted(*source, 0.8).indices.empty());
    EXPECT_TRUE(extracted(*source, -0.8).indices.empty());
}

TEST_F(MeshSource, isAClosedShellIfItIsOpen)
{
    const TriangleMesh bowl = ball(24, false);
    const auto source = openSource(written(bowl, "bowl.obj"), {.meshResolution = 48});
    ASSERT_TRUE(source) << source.error().message;
    ASSERT_EQ(source->notes.size(), 1U);
    EXPECT_NE(source->notes[0].find("48 edges belong to one triangle"), std::string::npos)
        << source->notes[0];
    const TriangleMesh found = extracted(*source, 0);
    const double voxel = source->volume->info.spacing.x;
    const bench::Topology topology = bench::topologyOf(found);
    EXPECT_EQ(topology.euler, 2);
    EXPECT_EQ(topology.components, 1U);
    EXPECT_EQ(topology.openEdges, 0U);
    const bench::TriangleTree tree(bowl);
    for (const glm::dvec3& position : found.positions)
        EXPECT_NEAR(tree.nearest(position).distance, 1.5 * voxel, 0.5 * voxel);
    EXPECT_NEAR(
        volumeOf(found), 3 * voxel * 2 * std::numbers::pi, 0.3 * voxel * 2 * std::numbers::pi);
}

TEST_F(MeshSource, tellsWhatIsWrongWithAFile)
{
    const auto errorOf = [&](const std::string& name, const std::string& text) {
        std::ofstream(folder.path(name), std::ios::binary) << text;
        const auto source = openSource(folder.path(name).string(), {});
        EXPECT_FALSE(source);
        if (!source) {
            EXPECT_NE(source.error().message.find(name), std::string::npos)
                << source.error().message;
        }
        return source ? core::ErrorCode::usage : source.error().code;
    };
    EXPECT_EQ(errorOf("none.obj", "# nothing\n"), core::ErrorCode::badData);
    EXPECT_EQ(errorOf("point.obj", "v 1 1 1\nf 1 1 1\n"), core::ErrorCode::badData);
    EXPECT_EQ(
        errorOf("far.obj", "v 1e17 0 0\nv 1e17 1 0\nv 1e17 0 1\nf 1 2 3\n"),
        core::ErrorCode::badData);
    EXPECT_EQ(errorOf("text.ply", "no mesh"), core::ErrorCode::badData);
}

/// What real scans give, where they are at hand.
TEST_F(MeshSource, isExtractedFromScans)
{
    const char* const data = std::getenv("ISOFRONT_TEST_DATA");
    if (data == nullptr)
        GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder with meshes";
    const auto path = std::filesystem::path(data) / "meshes" / "bunny_closed_75k.ply.gz";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << path << " is not there";
    const auto source = openSource(path.string(), {.meshResolution = 96});
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_TRUE(source->notes.empty());
    const TriangleMesh found = extracted(*source, 0);
    EXPECT_NEAR(volumeOf(found), 0.1992056, 0.001); // that of the mesh, by tetrahedra
    EXPECT_EQ(bench::topologyOf(found).openEdges, 0U);
}

} // namespace
} // namespace isofront::sources

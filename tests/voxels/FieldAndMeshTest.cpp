// Voxels of a field beside those of the mesh that shows the same field.

#include "FieldGrid.h"
#include "Rasteriser.h"
#include "VoxelSets.h"

#include <isofront/fields/Shapes.h>
#include <isofront/surface/MeshExtraction.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <gtest/gtest.h>

#include <set>

namespace isofront::voxels {
namespace {

using tests::Cube;

constexpr double kEdge = 32;

/// Voxels of edge 1 in the domain [0, 32]^3.
std::set<Cube> voxelsOfField(const fields::Field& field)
{
    tests::KeptChunks kept;
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    const auto report =
        voxelizeField(field, {.box = {glm::dvec3(0), glm::dvec3(kEdge)}, .edge = 1}, kept, *jobs);
    EXPECT_TRUE(report);
    std::set<Cube> found;
    for (const auto& [cube, voxel] : tests::voxelsOf(kept, 0))
        found.insert(cube);
    return found;
}

/// The same of the mesh whose lattice step is a voxel's edge, as views filter it.
std::set<Cube> voxelsOfMesh(const std::shared_ptr<const fields::Field>& field)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    settings.cornerRadius = 2;
    settings.closed = false;
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    surface::MeshExtractionOptions options;
    while (hierarchy::axisStep(options.detail.level, 4) * kEdge > 1)
        options.detail.level += 3;
    const auto mesh = surface::extractMesh(
        std::make_shared<const extractor::CellExtractor>(
            field, hierarchy::Domain{glm::dvec3(0), kEdge, {}}, settings),
        *jobs,
        options);
    EXPECT_TRUE(mesh);
    TriangleModel model;
    for (const auto& position : mesh->mesh.positions)
        model.positions.push_back(glm::dvec3(position));
    std::vector<std::uint32_t> all;
    for (std::size_t i = 0; i + 2 < mesh->mesh.indices.size(); i += 3) {
        all.push_back(static_cast<std::uint32_t>(model.triangles.size()));
        model.triangles.push_back(
            {mesh->mesh.indices[i], mesh->mesh.indices[i + 1], mesh->mesh.indices[i + 2]});
    }
    VoxelLattice lattice;
    lattice.edge = 1;
    lattice.resolution = 32;
    std::uint64_t touched = 0;
    std::set<Cube> found;
    VoxelList list;
    Rasteriser().run(onLattice(model, lattice), {0, 0, 0}, all, Separability::six, list, touched);
    for (const WeightedVoxel& voxel : list.voxels) {
        const Voxel place{voxel.place, 0};
        found.insert(
            {static_cast<int>(place.x()),
             static_cast<int>(place.y()),
             static_cast<int>(place.z())});
    }
    return found;
}

/// How many of some voxels have none of others among them and their 26 neighbours.
std::size_t farFrom(const std::set<Cube>& some, const std::set<Cube>& others)
{
    std::size_t count = 0;
    for (const Cube& c : some) {
        bool found = false;
        for (int i = 0; i < 27 && !found; ++i)
            found = others.contains({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
        count += found ? 0U : 1U;
    }
    return count;
}

TEST(FieldAndMesh, haveTheSameVoxelsToWithinOne)
{
    const glm::dvec3 centre(15.7, 16.2, 16.4);
    for (const auto& field :
         {fields::sphere(centre, 12.5), fields::torus(centre, 9, 4.5), fields::gyroid(19)}) {
        const std::set<Cube> fromField = voxelsOfField(*field);
        const std::set<Cube> fromMesh = voxelsOfMesh(field);
        ASSERT_GT(fromField.size(), 1000U);
        EXPECT_EQ(farFrom(fromField, fromMesh), 0U);
        EXPECT_EQ(farFrom(fromMesh, fromField), 0U);
        std::size_t shared = 0;
        for (const Cube& cube : fromField)
            shared += fromMesh.contains(cube) ? 1U : 0U;
        EXPECT_GT(static_cast<double>(shared), 0.9 * static_cast<double>(fromField.size()));
        EXPECT_GT(static_cast<double>(shared), 0.9 * static_cast<double>(fromMesh.size()));
    }
}

} // namespace
} // namespace isofront::voxels

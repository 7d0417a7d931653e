#include "AssemblyLine.h"
#include "support/FunctionField.h"
#include "support/GlobalMesh.h"

#include <isofront/hierarchy/Refinement.h>
#include <isofront/surface/MeshExtraction.h>
#include <isofront/surface/SurfaceCriterion.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>

namespace isofront::surface {
namespace {

std::shared_ptr<const extractor::CellExtractor> makeExtractor(int latticeSize, bool closed)
{
    // a sheet that leaves the domain, and a ball
    const auto field = std::make_shared<tests::FunctionField>([](const glm::dvec3& p, double) {
        return std::max(
            tests::sphere(p, {0.503, 0.491, 0.607}, 0.2),
            0.2 + 0.05 * p.x * (1 - p.y) - p.z + 0.03 * p.x * p.x);
    });
    extractor::ExtractionSettings settings;
    settings.latticeSize = latticeSize;
    settings.filterStrength = 0;
    settings.closed = closed;
    return std::make_shared<const extractor::CellExtractor>(field, hierarchy::Domain{}, settings);
}

/// The same by the front that the live refinement makes, cell after cell, each extracted anew.
tests::GlobalMesh meshBy(
    const extractor::CellExtractor& extractor,
    const std::shared_ptr<const WhereSurface>& criterion,
    const hierarchy::View& view,
    int maxLevel)
{
    hierarchy::Refinement refinement(extractor.domain(), criterion, {.maxLevel = maxLevel});
    do
        refinement.update(view);
    while (!refinement.isSettled());
    std::vector<hierarchy::CellId> ids;
    refinement.front().forEachCell(
        [&](const auto& id, const hierarchy::Tetrahedron&) { ids.push_back(id); });
    std::ranges::sort(ids);
    tests::GlobalMesh mesh;
    for (const hierarchy::CellId& id : ids) {
        extractor::CellTrace trace;
        const auto cell = extractor.extract(hierarchy::tetrahedronOf(id), &trace);
        mesh.add(extractor.domain(), *cell, trace);
    }
    return mesh;
}

void expectSame(const TriangleMesh& joined, const tests::GlobalMesh& twin)
{
    ASSERT_GT(twin.triangles.size(), 1000U);
    ASSERT_EQ(joined.indices.size(), 3 * twin.triangles.size());
    for (std::size_t i = 0; i < twin.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            ASSERT_EQ(joined.indices[3 * i + k], twin.triangles[i][k]);
    ASSERT_TRUE(std::ranges::equal(joined.positions, twin.positions));
    core::Box bounds;
    for (const glm::dvec3& position : twin.positions)
        bounds.include(position);
    EXPECT_EQ(joined.bounds.low, bounds.low);
    EXPECT_EQ(joined.bounds.high, bounds.high);
}

TEST(MeshJoin, givesWhatJoiningCellsOneByOneGives)
{
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 3);
    struct Case {
        int latticeSize;
        int level;
        bool closed;
    };
    for (const Case& c : {Case{4, 9, false}, Case{4, 8, true}, Case{16, 6, true}}) {
        const auto extractor = makeExtractor(c.latticeSize, c.closed);
        MeshExtractionOptions options;
        options.detail.level = c.level;
        const auto joined = extractMesh(extractor, *jobs, options);
        ASSERT_TRUE(joined.has_value());
        expectSame(
            joined->mesh, meshBy(*extractor, levelCriterion(extractor, c.level), {}, c.level));
    }
}

TEST(MeshJoin, givesTheSameWhereLevelsMeet)
{
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 3);
    const auto extractor = makeExtractor(4, true);
    MeshExtractionOptions options;
    options.detail.kind = Detail::Kind::view;
    options.detail.level = 40;
    options.detail.view.eye = {0.7031, 0.491, 0.607};
    options.detail.view.height = 60;
    options.detail.pixelError = 2;
    const auto joined = extractMesh(extractor, *jobs, options);
    ASSERT_TRUE(joined.has_value());
    EXPECT_GT(joined->finestLevel, 30); // so that keys of border vertices don't fit 64 bits
    const auto criterion =
        viewCriterion(extractor, options.detail.view.pixelsPerUnit(), options.detail.pixelError);
    expectSame(joined->mesh, meshBy(*extractor, criterion, options.detail.view, 40));
}

TEST(MeshJoin, endsWithTheExceptionWhereMemoryRunsOut)
{
    using core::JobsBackend;
    for (const JobsBackend backend :
         {JobsBackend::automatic, JobsBackend::threads, JobsBackend::inlined}) {
        const auto jobs = core::makeJobs(backend, 3);
        // while a cell is made, and while one is counted, in its turn
        for (const bool inTurn : {false, true}) {
            MeshJoiner joiner({}, 4, 9, false);
            TriangleMesh mesh;
            std::atomic<int> done = 0;
            const auto fail = [&](bool here) {
                if (here && ++done == 100)
                    throw std::bad_alloc();
            };
            AssemblySteps steps;
            steps.extract = [&](std::size_t, JoinedCell&) { fail(!inTurn); };
            steps.count = [&](JoinedCell&) { fail(inTurn); };
            steps.check = [](std::size_t, std::size_t) { return std::nullopt; };
            EXPECT_THROW(assemble(100'000, 4, *jobs, steps, joiner, mesh), std::bad_alloc);
        }
    }
}

} // namespace
} // namespace isofront::surface

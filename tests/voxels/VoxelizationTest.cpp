#include "Models.h"
#include "VoxelSets.h"
#include "support/Random.h"

#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <limits>

namespace isofront::voxels {
namespace {

using tests::Cube;
using tests::Flood;
using tests::voxelsOf;

struct Made {
    VoxelizationReport report;
    tests::KeptChunks kept;
};

std::unique_ptr<Made>
make(const TriangleModel& model, const VoxelizationSettings& settings, std::size_t threads = 2)
{
    auto made = std::make_unique<Made>();
    const auto jobs = core::makeJobs(core::JobsBackend::threads, threads);
    const auto report = voxelize(model, settings, made->kept, *jobs);
    EXPECT_TRUE(report) << report.error().message;
    if (report)
        made->report = *report;
    return made;
}

TEST(Voxelization, sixSeparatesAndConservativeSeparatesDiagonally)
{
    const TriangleModel model = tests::hillySphere(60, 10, 1.5, {3, -4, 5});
    const auto six = make(model, {.resolution = 100});
    const auto all = make(model, {.resolution = 100, .separability = Separability::conservative});
    const auto sixVoxels = voxelsOf(six->kept, 0);
    const auto allVoxels = voxelsOf(all->kept, 0);
    EXPECT_EQ(six->report.voxels, sixVoxels.size());
    EXPECT_EQ(six->report.touched, allVoxels.size());
    for (const auto& [cube, voxel] : sixVoxels)
        EXPECT_TRUE(allVoxels.contains(cube));
    const double ratio =
        static_cast<double>(allVoxels.size()) / static_cast<double>(sixVoxels.size());
    EXPECT_GT(ratio, 1.5);
    EXPECT_LT(ratio, 2.0);

    const Cube middle{50, 50, 50};
    EXPECT_FALSE(Flood(sixVoxels, 100, false).reaches(middle));
    EXPECT_TRUE(Flood(sixVoxels, 100, true).reaches(middle));
    EXPECT_FALSE(Flood(allVoxels, 100, true).reaches(middle));
}

TEST(Voxelization, facesAreThoseThatAFloodFromOutsideReaches)
{
    // over several chunks, with a cavity that is closed off, and a bowl that isn't
    TriangleModel model = tests::hillySphere(90, 10, 1);
    const TriangleModel inner = tests::hillySphere(40, 5, 0.5);
    const auto offset = static_cast<std::uint32_t>(model.positions.size());
    model.positions.insert(model.positions.end(), inner.positions.begin(), inner.positions.end());
    for (const auto& t : inner.triangles)
        model.triangles.push_back({t[0] + offset, t[2] + offset, t[1] + offset});
    TriangleModel bowl = tests::hillySphere(40, 3, 0.2, {14, 0, 0});
    const auto last = static_cast<std::uint32_t>(model.positions.size());
    model.positions.insert(model.positions.end(), bowl.positions.begin(), bowl.positions.end());
    for (const auto& t : bowl.triangles)
        if (bowl.positions[t[0]].z < 1)
            model.triangles.push_back({t[0] + last, t[1] + last, t[2] + last});

    const auto made = make(model, {.resolution = 300});
    EXPECT_EQ(made->report.lattice.levels, 2U);
    EXPECT_GT(made->report.model.openEdges, 0U);
    const auto voxels = voxelsOf(made->kept, 0);
    Flood flood(voxels, 300, false);
    EXPECT_FALSE(flood.reaches({126, 126, 126})); // the cavity
    std::size_t faces = 0;
    for (const auto& [cube, voxel] : voxels)
        for (std::size_t face = 0; face < kFaces; ++face) {
            const auto& step = kFaceSteps[face];
            const bool seen =
                flood.reaches({cube[0] + step[0], cube[1] + step[1], cube[2] + step[2]});
            EXPECT_EQ((voxel.faces() >> face & 1) != 0, seen);
            faces += seen ? 1U : 0U;
        }
    EXPECT_GT(faces, voxels.size());
    // between the spheres, and inside the inner one
    EXPECT_GE(made->report.emptyRegions, 2U);
}

TEST(Voxelization, givesTheSameChunksInTheSameOrderOnAnyNumberOfThreads)
{
    TriangleModel model = tests::hillySphere(50, 10, 2);
    auto random = tests::random(4);
    for (std::size_t i = 0; i < model.positions.size(); ++i)
        model.colours.push_back(static_cast<std::uint32_t>(random()));
    const auto one = make(model, {.resolution = 700}, 1);
    const auto four = make(model, {.resolution = 700}, 4);
    EXPECT_EQ(one->kept.order, four->kept.order);
    EXPECT_EQ(one->kept.chunks, four->kept.chunks);
    EXPECT_EQ(one->report.allVoxels, four->report.allVoxels);
}

TEST(Voxelization, coarserLevelsContainFinerOnesAndShowAllTheirFaces)
{
    const auto made = make(tests::hillySphere(80, 10, 2), {.resolution = 1000});
    ASSERT_EQ(made->report.lattice.levels, 3U);
    auto finer = voxelsOf(made->kept, 0);
    std::uint64_t sum = finer.size();
    for (std::uint32_t level = 1; level < 3; ++level) {
        const auto coarser = voxelsOf(made->kept, level);
        std::map<Cube, unsigned> masks;
        for (const auto& [cube, voxel] : finer)
            masks[{cube[0] / 2, cube[1] / 2, cube[2] / 2}] |= voxel.faces();
        ASSERT_EQ(coarser.size(), masks.size());
        for (const auto& [cube, voxel] : coarser)
            EXPECT_EQ(voxel.faces(), masks.at(cube));
        sum += coarser.size();
        finer = coarser;
    }
    EXPECT_EQ(made->report.allVoxels, sum);
    const double overhead = static_cast<double>(sum) / static_cast<double>(made->report.voxels);
    EXPECT_GT(overhead, 1.25);
    EXPECT_LT(overhead, 1.5);
    for (std::size_t i = 0; i < made->kept.order.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_FALSE(
                made->kept.order[j] == made->kept.order[i] ||
                made->kept.order[j] == made->kept.order[i].parent())
                << "children come before parents";
}

TEST(Voxelization, normalsAndColoursAreMeansByArea)
{
    // a plate across a corner of space, its colour linear along x
    TriangleModel model;
    model.positions = {{0, 0, 0}, {8, 0, 0}, {8, 8, 8}, {0, 8, 8}};
    model.triangles = {{0, 1, 2}, {0, 2, 3}};
    model.colours = {0xff000000U, 0xff0000ffU, 0xff0000ffU, 0xff000000U};
    const auto made = make(model, {.resolution = 64, .separability = Separability::conservative});
    const double half = std::sqrt(0.5);
    for (const auto& [cube, voxel] : voxelsOf(made->kept, 0)) {
        const glm::dvec3 normal = unpackNormal(voxel.normal);
        EXPECT_NEAR(normal.x, 0, 2e-3);
        EXPECT_NEAR(normal.y, -half, 2e-3);
        EXPECT_NEAR(normal.z, half, 2e-3);
    }
    const Chunk& chunk = made->kept.chunks.begin()->second;
    ASSERT_EQ(chunk.colours.size(), chunk.voxels.size());
    for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
        const double code = (chunk.colours[i] & 0xffU) / 255.0;
        const double linear =
            code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
        const std::uint32_t x = chunk.voxels[i].x();
        if (x > 0 && x < 63) {
            EXPECT_NEAR(linear, (x + 0.25) / 63.5, 0.01);
        }
        EXPECT_EQ(chunk.colours[i] >> 24U, 255U);
    }
}

TEST(Voxelization, bothSidesOfAThinWallAreKept)
{
    // two walls with red outsides and green ones, a third of a voxel apart, and a bar that makes
    // the model as long as it is
    TriangleModel model;
    const auto addWall = [&](double z, bool up, std::uint32_t colour) {
        const auto first = static_cast<std::uint32_t>(model.positions.size());
        for (const glm::dvec3 corner :
             {glm::dvec3(0, 0, z),
              glm::dvec3(300, 0, z),
              glm::dvec3(300, 40, z),
              glm::dvec3(0, 40, z)}) {
            model.positions.push_back(corner);
            model.colours.push_back(colour);
        }
        model.triangles.push_back({first, first + (up ? 1 : 2), first + (up ? 2 : 1)});
        model.triangles.push_back({first, first + (up ? 2 : 3), first + (up ? 3 : 2)});
    };
    addWall(0, false, 0xff00ff00U);
    addWall(0.3, true, 0xff0000ffU);
    for (const auto separability : {Separability::six, Separability::conservative}) {
        const auto made = make(model, {.resolution = 300, .separability = separability});
        ASSERT_EQ(made->report.lattice.levels, 2U);
        for (const auto& [key, chunk] : made->kept.chunks) {
            ASSERT_EQ(chunk.faceSets.size(), chunk.voxels.size()) << "level " << key.level;
            EXPECT_LE(chunk.faceAttributes.size(), 4U) << "shared";
            for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
                const FaceAttributes above = attributesOf(chunk, i, Face::highZ);
                const FaceAttributes below = attributesOf(chunk, i, Face::lowZ);
                EXPECT_EQ(unpackNormal(above.normal), glm::dvec3(0, 0, 1));
                EXPECT_EQ(unpackNormal(below.normal), glm::dvec3(0, 0, -1));
                EXPECT_EQ(above.colour, 0xff0000ffU);
                EXPECT_EQ(below.colour, 0xff00ff00U);
            }
        }
    }
    // where surfaces agree, nobody pays
    const auto ball = make(tests::hillySphere(60, 10, 0), {.resolution = 64});
    for (const auto& [key, chunk] : ball->kept.chunks)
        EXPECT_TRUE(chunk.faceSets.empty());
}

TEST(Voxelization, wallsThatComeTogetherInCoarserLevelsKeepTheirSides)
{
    // a slab with hills, whose sides share voxels only from the second level on
    TriangleModel model;
    for (int side = 0; side < 2; ++side)
        for (std::uint32_t j = 0; j <= 20; ++j)
            for (std::uint32_t i = 0; i <= 100; ++i) {
                const double x = 6.0 * i;
                const double y = 6.0 * j;
                const double hill = 3 * std::sin(x / 20) + 2 * std::cos(y / 30);
                model.positions.push_back({x, y, hill + 1.4 * side});
                model.colours.push_back(side == 0 ? 0xff00ff00U : 0xff0000ffU);
            }
    for (std::uint32_t side = 0; side < 2; ++side)
        for (std::uint32_t j = 0; j < 20; ++j)
            for (std::uint32_t i = 0; i < 100; ++i) {
                const std::uint32_t a = side * 21 * 101 + j * 101 + i;
                const std::uint32_t b = a + (side == 1 ? 1 : 101);
                const std::uint32_t d = a + (side == 1 ? 101 : 1);
                model.triangles.push_back({a, b, a + 102});
                model.triangles.push_back({a, a + 102, d});
            }
    const auto made = make(model, {.resolution = 600});
    ASSERT_EQ(made->report.lattice.levels, 3U);
    std::array<std::size_t, 3> voxels{};
    std::array<std::size_t, 3> sets{};
    for (const auto& [key, chunk] : made->kept.chunks) {
        voxels[key.level] += chunk.voxels.size();
        sets[key.level] += chunk.faceSets.size();
        for (const FaceSet& set : chunk.faceSets)
            for (const Face face : {Face::lowZ, Face::highZ}) {
                const Voxel& voxel = chunk.voxels[set.voxel];
                if ((voxel.faces() & faceBit(face)) == 0 || (set.mask() & faceBit(face)) == 0)
                    continue;
                const FaceAttributes own = attributesOf(chunk, set.voxel, face);
                const bool up = face == Face::highZ;
                EXPECT_GT(unpackNormal(own.normal).z * (up ? 1 : -1), 0.9);
                // a voxel that holds a little of the other side keeps one mean
                EXPECT_GT(own.colour >> (up ? 0 : 8) & 0xffU, own.colour >> (up ? 8 : 0) & 0xffU);
            }
    }
    EXPECT_LT(sets[0], voxels[0] / 20);
    EXPECT_GT(sets[2], voxels[2] / 2);
}

TEST(Voxelization, whatIsWrongIsTold)
{
    tests::KeptChunks kept;
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    const double none = std::numeric_limits<double>::quiet_NaN();
    TriangleModel model;
    EXPECT_EQ(voxelize(model, {}, kept, *jobs).error().code, core::ErrorCode::badData);
    model.positions = {{0, 0, 0}, {1, 0, 0}, {none, 1, 0}, {0, 1, 0}, {2, 2, 2}};
    model.triangles = {{0, 1, 2}, {0, 1, 9}};
    EXPECT_EQ(voxelize(model, {}, kept, *jobs).error().code, core::ErrorCode::badData);
    EXPECT_EQ(voxelize(model, {.resolution = 0}, kept, *jobs).error().code, core::ErrorCode::usage);
    EXPECT_EQ(
        voxelize(model, {.resolution = kMaxResolution + 1}, kept, *jobs).error().code,
        core::ErrorCode::usage);
    EXPECT_TRUE(kept.chunks.empty());
    model.triangles.push_back({0, 1, 3});
    model.triangles.push_back({4, 4, 4});
    const auto report = voxelize(model, {.resolution = 16}, kept, *jobs);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->model.outOfRange, 1U);
    EXPECT_EQ(report->model.notFinite, 1U);
    EXPECT_EQ(report->model.degenerate, 1U);
    EXPECT_EQ(report->model.openEdges, 3U);
    EXPECT_FALSE(kept.chunks.empty());
    const std::atomic<bool> cancelled = true;
    tests::KeptChunks other;
    EXPECT_EQ(
        voxelize(model, {.resolution = 16}, other, *jobs, &cancelled).error().code,
        core::ErrorCode::interrupted);
    EXPECT_EQ(
        voxelize(model, {.resolution = 16, .scratchFolder = "/nowhere"}, other, *jobs).error().code,
        core::ErrorCode::inputOutput);
}

/// The cube of an edge whose low corner lies at `low` on each axis.
TriangleModel cubeOf(double low, double edge)
{
    TriangleModel model;
    for (unsigned corner = 0; corner < 8; ++corner)
        model.positions.emplace_back(
            low + ((corner & 1U) != 0 ? edge : 0),
            low + ((corner & 2U) != 0 ? edge : 0),
            low + ((corner & 4U) != 0 ? edge : 0));
    model.triangles = {
        {0, 2, 3},
        {0, 3, 1},
        {4, 5, 7},
        {4, 7, 6},
        {0, 1, 5},
        {0, 5, 4},
        {2, 6, 7},
        {2, 7, 3},
        {0, 4, 6},
        {0, 6, 2},
        {1, 3, 7},
        {1, 7, 5}};
    return model;
}

TEST(Voxelization, isTheSameAtAnyScaleThatNumbersCanHold)
{
    const VoxelizationSettings settings{.resolution = 40};
    const auto one = make(cubeOf(0, 1), settings);
    const auto voxels = voxelsOf(one->kept, 0);
    EXPECT_EQ(voxels.size(), 40U * 40 * 40 - 38U * 38 * 38);
    for (const int exponent : {-1000, -300, 300, 1000, 1023}) {
        const auto other = make(cubeOf(0, std::ldexp(1.0, exponent)), settings);
        EXPECT_EQ(other->report.lattice.edge, std::ldexp(one->report.lattice.edge, exponent));
        EXPECT_EQ(voxelsOf(other->kept, 0), voxels) << exponent;
    }
    EXPECT_EQ(make(cubeOf(0, 1e308), settings)->report.voxels, voxels.size());
}

TEST(Voxelization, refusesWhatNumbersCantDivide)
{
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    const auto expectRefused = [&](const TriangleModel& model, std::uint32_t resolution) {
        tests::KeptChunks kept;
        const auto result = voxelize(model, {.resolution = resolution}, kept, *jobs);
        ASSERT_FALSE(result) << model.positions[0].x << ", " << model.positions[7].x;
        EXPECT_EQ(result.error().code, core::ErrorCode::badData);
        EXPECT_NE(result.error().message.find("scale or move"), std::string::npos)
            << result.error().message;
        EXPECT_TRUE(kept.chunks.empty());
    };
    expectRefused(cubeOf(0, 1e308), 1); // half the edge of a voxel, which is infinite
    expectRefused(cubeOf(0, 5e-324), 40);
    expectRefused(cubeOf(0, 1e-306), 40); // its voxels have edges, but no steps in them
    expectRefused(cubeOf(1e30, 1), 40);
    expectRefused(cubeOf(1e30, 1e15), 40); // its corners differ, its voxels don't
    TriangleModel wide = cubeOf(0, 1);
    for (glm::dvec3& position : wide.positions)
        position = (position - 0.5) * 2.0 * 1.7e308;
    expectRefused(wide, 40);
}

TEST(Normals, areKeptToATenthOfADegree)
{
    auto random = tests::random(5);
    for (int trial = 0; trial < 10'000; ++trial) {
        const glm::dvec3 direction(
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1));
        const glm::dvec3 unit = glm::normalize(direction);
        const double scale = std::pow(10.0, tests::uniform(random, -200, 200));
        const glm::dvec3 back = unpackNormal(packNormal(scale * direction));
        EXPECT_LT(glm::length(glm::cross(unit, back)), 0.12 * 3.15 / 180);
        EXPECT_GT(glm::dot(unit, back), 0);
    }
    EXPECT_EQ(unpackNormal(packNormal(glm::dvec3(0))), glm::dvec3(0, 0, 1));
}

} // namespace
} // namespace isofront::voxels

#include "MeshBlocks.h"
#include "support/Random.h"

#include <isofront/volume/MeshLevelSet.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#ifdef ISOFRONT_WITH_OPENVDB
#include <oneapi/tbb/task_arena.h>
#endif

namespace isofront::volume {
namespace {

struct Mesh {
    std::vector<glm::dvec3> positions;
    std::vector<std::array<std::uint32_t, 3>> corners;

    [[nodiscard]] Triangles view() const { return {positions, corners}; }
};

/// A convex ball of `2 rows^2` quadrangles, halved, and fans at its poles.
Mesh ball(std::uint32_t rows, double radius, const glm::dvec3& centre = glm::dvec3(0))
{
    Mesh mesh;
    const std::uint32_t columns = 2 * rows;
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const double theta = std::numbers::pi * i / rows;
            const double phi = 2 * std::numbers::pi * j / columns;
            const double ring = i == 0 || i == rows ? 0 : std::sin(theta); // one point at the poles
            mesh.positions.push_back(
                centre +
                radius * glm::dvec3(ring * std::cos(phi), ring * std::sin(phi), std::cos(theta)));
        }
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * columns + j;
            const std::uint32_t b = i * columns + (j + 1) % columns;
            if (i > 0)
                mesh.corners.push_back({a, a + columns, b});
            if (i + 1 < rows)
                mesh.corners.push_back({b, a + columns, b + columns});
        }
    return mesh;
}

double distanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b)
{
    const glm::dvec3 along = b - a;
    const double length = glm::dot(along, along);
    const double t = length > 0 ? std::clamp(glm::dot(p - a, along) / length, 0.0, 1.0) : 0.0;
    return glm::distance(p, a + t * along);
}

/// By the plane where the point's foot lies in the triangle, else by the edges.
double distanceToTriangle(
    const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const auto isLeft = [&](const glm::dvec3& from, const glm::dvec3& to) {
        return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
    };
    if (glm::length(normal) > 0 && isLeft(a, b) && isLeft(b, c) && isLeft(c, a))
        return std::abs(glm::dot(p - a, glm::normalize(normal)));
    return std::min(
        {distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
}

double distanceTo(const Mesh& mesh, const glm::dvec3& p)
{
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : mesh.corners)
        least = std::min(
            least, distanceToTriangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]));
    return least;
}

/// Of a convex mesh that is wound outwards: behind all of its planes.
bool isInside(const Mesh& mesh, const glm::dvec3& p)
{
    return std::ranges::all_of(mesh.corners, [&](const auto& corners) {
        const glm::dvec3& a = mesh.positions[corners[0]];
        const glm::dvec3& b = mesh.positions[corners[1]];
        const glm::dvec3& c = mesh.positions[corners[2]];
        return glm::dot(glm::cross(b - a, c - a), p - a) < 0;
    });
}

double unit(std::mt19937_64& random)
{
    return tests::uniform(random, 0, 1);
}

/// In the unit cube.
glm::dvec3 unitPlace(std::mt19937_64& random)
{
    const double x = unit(random);
    const double y = unit(random);
    return {x, y, unit(random)};
}

/// The field's values at all voxels.
std::vector<float> voxelsOf(const LoadedVolume& volume)
{
    std::vector<double> x;
    std::vector<double> y;
    std::vector<double> z;
    const core::Box& box = volume.dataBox;
    for (double k = box.low.z; k <= box.high.z; ++k)
        for (double j = box.low.y; j <= box.high.y; ++j)
            for (double i = box.low.x; i <= box.high.x; ++i) {
                x.push_back(i);
                y.push_back(j);
                z.push_back(k);
            }
    std::vector<float> values(x.size());
    volume.field->sample({x, y, z}, values);
    return values;
}

float valueAt(const LoadedVolume& volume, const glm::dvec3& index)
{
    float value = 0;
    volume.field->sample({{&index.x, 1}, {&index.y, 1}, {&index.z, 1}}, {&value, 1});
    return value;
}

#ifdef ISOFRONT_WITH_OPENVDB

TEST(MeshLevelSet, isTheDistanceFromAConvexMesh)
{
    const Mesh mesh = ball(8, 3, {10, -20, 30});
    const auto volume = levelSetOf(mesh.view(), {.resolution = 32, .reach = 1.2});
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_TRUE(volume->negated);
    EXPECT_EQ(volume->info.format, VolumeFormat::mesh);
    EXPECT_DOUBLE_EQ(volume->info.spacing.x, 6.0 / 32);
    const double voxel = volume->info.spacing.x;
    auto random = tests::random(1);
    int inside = 0;
    int outside = 0;
    const int trials = tests::trials(2000);
    for (int i = 0; i < trials; ++i) {
        const glm::dvec3 index =
            glm::round(volume->dataBox.low + unitPlace(random) * volume->dataBox.size());
        const glm::dvec3 place = volume->worldFromIndex.point(index);
        const bool isWithin = isInside(mesh, place);
        const double distance = distanceTo(mesh, place);
        const double value = double{valueAt(*volume, index)};
        if (distance > 1.2) {
            EXPECT_GE(isWithin ? value : -value, 1.2) << i;
            continue;
        }
        (isWithin ? inside : outside) += 1;
        // handed on from voxel to voxel, the nearest triangle may be missed by a little
        const double found = isWithin ? value : -value;
        EXPECT_GE(found, distance - 1e-4 * voxel) << i;
        EXPECT_LE(found, distance + (distance < 2 * voxel ? 1e-4 : 0.05) * voxel) << i;
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(inside, 100);
        EXPECT_GT(outside, 100);
    }
}

TEST(MeshLevelSet, doesNotAskHowTrianglesAreWound)
{
    const Mesh mesh = ball(6, 1);
    Mesh turned = mesh;
    for (std::size_t i = 0; i < turned.corners.size(); i += 3)
        std::swap(turned.corners[i][0], turned.corners[i][1]);
    const auto a = levelSetOf(mesh.view(), {.resolution = 24});
    const auto b = levelSetOf(turned.view(), {.resolution = 24});
    ASSERT_TRUE(a && b);
    const std::vector<float> one = voxelsOf(*a);
    const std::vector<float> other = voxelsOf(*b);
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i)
        ASSERT_NEAR(one[i], other[i], 1e-6F) << i;
}

TEST(MeshLevelSet, isTheSameOnOneThreadAndMany)
{
    const Mesh mesh = ball(12, 1, {0.1, 0.2, 0.3});
    for (const bool isSolid : {true, false}) {
        const LevelSetOptions options{.resolution = 24, .reach = 0.5, .isSolid = isSolid};
        std::vector<std::vector<float>> results;
        for (const int threads : {1, 2, 7}) {
            oneapi::tbb::task_arena(threads).execute([&] {
                const auto volume = levelSetOf(mesh.view(), options);
                if (volume)
                    results.push_back(voxelsOf(*volume));
            });
        }
        ASSERT_EQ(results.size(), 3U);
        for (const std::vector<float>& result : results)
            EXPECT_TRUE(result == results.front());
    }
}

TEST(MeshLevelSet, isAsExactForMeshesOfAnySize)
{
    const Mesh mesh = ball(5, 1);
    const LevelSetOptions options{.resolution = 16};
    const auto plain = levelSetOf(mesh.view(), options);
    ASSERT_TRUE(plain);
    const std::vector<float> values = voxelsOf(*plain);
    for (const int exponent : {-80, -30, 30, 80}) {
        Mesh scaled = mesh;
        for (glm::dvec3& position : scaled.positions)
            position *= std::ldexp(1.0, exponent);
        const auto volume = levelSetOf(scaled.view(), options);
        ASSERT_TRUE(volume) << exponent << ": " << volume.error().message;
        const std::vector<float> found = voxelsOf(*volume);
        ASSERT_EQ(found.size(), values.size());
        for (std::size_t i = 0; i < values.size(); ++i)
            ASSERT_EQ(found[i], std::ldexp(values[i], exponent)) << exponent << " " << i;
    }
}

TEST(MeshLevelSet, canBeAShell)
{
    // a square aslant, which encloses nothing
    const Mesh plate{{{0, 0, 0}, {8, 0, 3}, {8, 8, 5}, {0, 8, 2}}, {{{0, 1, 2}}, {{0, 2, 3}}}};
    const auto volume =
        levelSetOf(plate.view(), {.resolution = 32, .reach = 1.5, .isSolid = false});
    ASSERT_TRUE(volume) << volume.error().message;
    const double voxel = 8.0 / 32;
    auto random = tests::random(2);
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 index =
            glm::round(volume->dataBox.low + unitPlace(random) * volume->dataBox.size());
        const double distance =
            distanceTo(plate, volume->worldFromIndex.point(index)) - 1.5 * voxel;
        const double value = double{valueAt(*volume, index)};
        if (distance > 1.5)
            EXPECT_LE(value, -1.5);
        else
            EXPECT_NEAR(value, -distance, 1e-4 * voxel);
    }
    // solid everywhere on the square, and nowhere beyond a shell's thickness
    for (int i = 0; i < 1000; ++i) {
        const double s = unit(random);
        const double t = unit(random);
        const glm::dvec3 place = (1 - t) * plate.positions[0] +
                                 t * ((1 - s) * plate.positions[1] + s * plate.positions[2]);
        const glm::dvec3 index = (place - volume->worldFromIndex.translation) / voxel;
        EXPECT_GE(double{valueAt(*volume, index)}, 0.63 * voxel); // 1.5 - sqrt(3)/2
    }
}

TEST(MeshLevelSet, asAShellIsFoundHoweverItIsFiltered)
{
    const Mesh plate{{{0, 0, 0}, {8, 0, 3}, {8, 8, 5}, {0, 8, 2}}, {{{0, 1, 2}}, {{0, 2, 3}}}};
    const auto volume =
        levelSetOf(plate.view(), {.resolution = 64, .reach = 2.0, .isSolid = false});
    ASSERT_TRUE(volume) << volume.error().message;
    const double voxel = 8.0 / 64;
    auto random = tests::random(5);
    for (const double radius : {0.0, 0.5, 0.8, 1.5, 3.0, 4.5}) {
        for (int i = 0; i < 200; ++i) {
            // away from the edges, where there is more air around
            const double s = 0.2 + 0.6 * unit(random);
            const double t = 0.2 + 0.6 * unit(random);
            const glm::dvec3 place = (1 - t) * plate.positions[0] +
                                     t * ((1 - s) * plate.positions[1] + s * plate.positions[2]);
            const glm::dvec3 index = (place - volume->worldFromIndex.translation) / voxel;
            const auto valueFrom = [&](const glm::dvec3& at) {
                float value = 0;
                volume->field->sample(
                    {{&at.x, 1}, {&at.y, 1}, {&at.z, 1}, {&radius, 1}}, {&value, 1});
                return double{value};
            };
            // to the nearest point of a lattice with twice the radius between its planes
            const double needed = std::min(std::sqrt(3.0) * radius, 0.63);
            EXPECT_GE(valueFrom(index), needed * voxel) << radius;
            // no thicker than that and the lattice's step
            EXPECT_LT(valueFrom(index + glm::dvec3(0, 0, 4 + 4 * radius)), 0) << radius;
        }
    }
    for (int i = 0; i < 300; ++i) {
        const auto place = [&] {
            return volume->dataBox.low + unitPlace(random) * volume->dataBox.size();
        };
        const glm::dvec3 a = place();
        core::Box box;
        box.include(a);
        box.include(glm::mix(a, place(), 0.1));
        const double low = 4 * unit(random);
        const double radius = low + unit(random);
        const core::Interval bounds = volume->field->bounds(box, {low, radius + 1});
        float value = 0;
        volume->field->sample({{&a.x, 1}, {&a.y, 1}, {&a.z, 1}, {&radius, 1}}, {&value, 1});
        EXPECT_LE(bounds.low, double{value});
        EXPECT_GE(bounds.high, double{value});
    }
    // nothing is solid away from it, however large the filter
    const core::Interval corner = volume->field->bounds(
        {volume->dataBox.low, volume->dataBox.low}, {0, std::numeric_limits<double>::infinity()});
    EXPECT_LT(corner.low, 0);
    const double infinite = std::numeric_limits<double>::infinity();
    const glm::dvec3 far = volume->dataBox.low;
    float value = 0;
    volume->field->sample({{&far.x, 1}, {&far.y, 1}, {&far.z, 1}, {&infinite, 1}}, {&value, 1});
    EXPECT_LT(value, 0);
}

TEST(MeshLevelSet, becomesAShellWhereNothingIsEnclosed)
{
    // two squares, back to back and closed around
    const Mesh sheet{
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
        {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 2, 1}}, {{0, 3, 2}}}};
    const auto volume = levelSetOf(sheet.view(), {.resolution = 32});
    ASSERT_TRUE(volume) << volume.error().message;
    ASSERT_EQ(volume->info.notes.size(), 1U);
    EXPECT_NE(volume->info.notes[0].find("shell"), std::string::npos);
    EXPECT_NEAR(double{valueAt(*volume, {16.5, 16.5, 0.5})}, 1.0 / 32, 1e-6); // mean of the voxels
    EXPECT_GT(valueAt(*volume, {16, 16, 0}), 0);
    EXPECT_LT(valueAt(*volume, {16, 16, 3}), 0);
}

TEST(MeshLevelSet, leavesOutTrianglesThatAreNotSound)
{
    const Mesh mesh = ball(6, 1);
    Mesh damaged = mesh;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    damaged.positions.push_back({nan, 0, 0});
    damaged.positions.push_back({std::numeric_limits<double>::infinity(), 0, 0});
    damaged.positions.push_back({1e300, 1e300, 1e300}); // of no triangle
    const auto last = static_cast<std::uint32_t>(mesh.positions.size());
    damaged.corners.push_back({0, 1, last});
    damaged.corners.push_back({0, last + 1, 1});
    damaged.corners.push_back({0, 1, 4'000'000'000U});
    damaged.corners.push_back({7, 7, 7}); // a point on the surface
    damaged.corners.push_back({7, 7, 8});
    const auto a = levelSetOf(mesh.view(), {.resolution = 16});
    const auto b = levelSetOf(damaged.view(), {.resolution = 16});
    ASSERT_TRUE(a && b);
    EXPECT_TRUE(voxelsOf(*a) == voxelsOf(*b));
}

TEST(MeshLevelSet, staysWithinItsBounds)
{
    const Mesh mesh = ball(9, 2);
    const auto volume = levelSetOf(mesh.view(), {.resolution = 40});
    ASSERT_TRUE(volume);
    auto random = tests::random(3);
    for (int i = 0; i < 300; ++i) {
        const auto place = [&] {
            return volume->dataBox.low + unitPlace(random) * volume->dataBox.size();
        };
        core::Box box;
        const glm::dvec3 a = place();
        box.include(a);
        box.include(glm::mix(a, place(), 0.2));
        const core::Interval bounds = volume->field->bounds(box, {0, 0});
        const float value = valueAt(*volume, a);
        EXPECT_LE(bounds.low, double{value});
        EXPECT_GE(bounds.high, double{value});
    }
}

TEST(MeshLevelSet, isForetoldInMemory)
{
    const Mesh mesh = ball(16, 1);
    for (const double reach : {0.05, 0.4, 1.0}) {
        LevelSetOptions options{.resolution = 32, .reach = reach};
        const auto volume = levelSetOf(mesh.view(), options);
        ASSERT_TRUE(volume);
        // what it takes in the end, without what making it takes
        options.memoryLimit = volume->info.memoryBytes;
        const auto refused = levelSetOf(mesh.view(), options);
        ASSERT_FALSE(refused) << reach;
        EXPECT_EQ(refused.error().code, core::ErrorCode::resourceLimit);
        options.memoryLimit = 8 * volume->info.memoryBytes;
        EXPECT_TRUE(levelSetOf(mesh.view(), options)) << reach;
    }
}

#else

TEST(MeshLevelSet, needsOpenVdb)
{
    const Mesh mesh = ball(6, 1);
    const auto volume = levelSetOf(mesh.view());
    ASSERT_FALSE(volume);
    EXPECT_EQ(volume.error().code, core::ErrorCode::usage);
    EXPECT_NE(volume.error().message.find("ISOFRONT_WITH_OPENVDB"), std::string::npos);
}

#endif

TEST(MeshLevelSet, refusesWhatMakesNoSense)
{
    const auto codeOf = [](const Mesh& mesh, const LevelSetOptions& options = {}) {
        const auto volume = levelSetOf(mesh.view(), options);
        EXPECT_FALSE(volume);
        return volume ? core::ErrorCode::usage : volume.error().code;
    };
    using core::ErrorCode;
    const Mesh mesh = ball(6, 1);
    EXPECT_EQ(codeOf({}), ErrorCode::badData);
    EXPECT_EQ(codeOf({mesh.positions, {}}), ErrorCode::badData);
    EXPECT_EQ(codeOf({{}, mesh.corners}), ErrorCode::badData);
    EXPECT_EQ(codeOf({{{1, 2, 3}}, {{{0, 0, 0}}}}), ErrorCode::badData);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(codeOf({{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{{0, 1, 2}}}}), ErrorCode::badData);
    EXPECT_EQ(codeOf(ball(6, 1, {1e15, 0, 0})), ErrorCode::badData);
    EXPECT_EQ(codeOf(ball(6, 1e-200)), ErrorCode::badData);
    EXPECT_EQ(codeOf(ball(6, 1e200)), ErrorCode::badData);
    EXPECT_EQ(codeOf(ball(6, 1.7e308)), ErrorCode::badData); // the size overflows
    for (const int resolution : {-1, 0, 7, 2049})
        EXPECT_EQ(codeOf(mesh, {.resolution = resolution}), ErrorCode::usage) << resolution;
    for (const double reach : {-1.0, 0.0, nan, 2.1, std::numeric_limits<double>::infinity()})
        EXPECT_EQ(codeOf(mesh, {.reach = reach}), ErrorCode::usage) << reach;
    EXPECT_EQ(codeOf(mesh, {.memoryLimit = 0}), ErrorCode::resourceLimit);
    EXPECT_EQ(codeOf(mesh, {.memoryLimit = 1 << 20}), ErrorCode::resourceLimit);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(codeOf(mesh, {.stop = stop.get_token()}), ErrorCode::interrupted);
}

TEST(MeshBlocks, areThoseWithinReach)
{
    auto random = tests::random(4);
    for (int trial = 0; trial < 20; ++trial) {
        const glm::dvec3 size(64, 40, 24);
        const double reach = 20 * unit(random);
        const auto place = [&] { return unitPlace(random) * size; };
        const glm::dvec3 a = place();
        const glm::dvec3 b = place();
        const glm::dvec3 c = place();
        MeshBlocks blocks(size, reach);
        blocks.add(a, b, c);
        // blocks that have a voxel within reach, and those that lie near one
        std::uint64_t least = 0;
        std::uint64_t most = 0;
        for (int k = -4; k < 8; ++k)
            for (int j = -4; j < 10; ++j)
                for (int i = -4; i < 13; ++i) {
                    const glm::dvec3 middle = 8.0 * glm::dvec3(i, j, k) + 4.0;
                    const double distance = distanceToTriangle(middle, a, b, c);
                    least += distance <= reach ? 1U : 0U;
                    // to its corner, a box's corner, and the rounding of both to blocks
                    most += distance <= std::sqrt(3.0) * (reach + 4 * MeshBlocks::kEdge) ? 1U : 0U;
                }
        EXPECT_GE(blocks.countWithinReach(), least);
        EXPECT_LE(blocks.countWithinReach(), most);
    }
}

} // namespace
} // namespace isofront::volume

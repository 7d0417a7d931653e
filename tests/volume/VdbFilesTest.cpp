#include "FilterBands.h"
#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>

namespace isofront::volume {
namespace {

using core::ErrorCode;
using test::countExcludedSamples;
using test::sampleAt;

class VdbFiles : public testing::Test {
protected:
    void SetUp() override { openvdb::initialize(); }

    std::filesystem::path written(const std::string& name, const openvdb::GridCPtrVec& grids)
    {
        openvdb::io::File file(folder.path(name).string());
        file.write(grids);
        file.close();
        return folder.path(name);
    }

    LoadedVolume loaded(const std::filesystem::path& path, const LoadOptions& options = {})
    {
        auto volume = loadVolume(path, options);
        if (!volume)
            throw std::runtime_error(volume.error().message);
        return std::move(*volume);
    }

    test::TemporaryFolder folder;
};

constexpr float kRadius = 10.0F;
constexpr float kVoxel = 0.25F;

openvdb::FloatGrid::Ptr sphere(const openvdb::Vec3f& centre = {1, 2, 3})
{
    auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(kRadius, centre, kVoxel);
    grid->setName("sphere");
    return grid;
}

TEST_F(VdbFiles, ofLevelSetsAreNegatedAndZeroAtTheirRadius)
{
    const auto volume = loaded(written("sphere.vdb", {sphere()}));
    EXPECT_TRUE(volume.negated);
    EXPECT_EQ(volume.info.suggestedIsovalue, 0);
    EXPECT_EQ(volume.info.gridName, "sphere");
    EXPECT_NE(volume.info.orientation.find("negated"), std::string::npos);
    EXPECT_EQ(fieldIsovalue(volume, 0.5), -0.5);
    EXPECT_EQ(fieldIsovalue(volume, 0), 0);

    const core::Affine indexFromWorld = volume.worldFromIndex.inverse();
    const glm::dvec3 centre(1, 2, 3);
    EXPECT_GT(sampleAt(*volume.field, indexFromWorld.point(centre)), 0.0F) << "solid inside";
    EXPECT_LT(sampleAt(*volume.field, indexFromWorld.point(centre + 11.0)), 0.0F);

    // Along the lattice's axes through the centre the distance is linear, so the zero is exact.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            glm::dvec3 point = centre;
            point[axis] += side * double{kRadius};
            EXPECT_NEAR(
                double{sampleAt(*volume.field, indexFromWorld.point(point))} / double{kVoxel},
                0.0,
                1e-3);
        }
    }
    // Elsewhere a chord lies within h^2 / (2 R) of the arc: 3/8 of a voxel's square over the
    // radius.
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 2000; ++i) {
        glm::dvec3 way(normal(random), normal(random), normal(random));
        way /= std::sqrt(way.x * way.x + way.y * way.y + way.z * way.z);
        const glm::dvec3 point = indexFromWorld.point(centre + double{kRadius} * way);
        const double voxels = double{sampleAt(*volume.field, point)} / double{kVoxel};
        ASSERT_NEAR(voxels, 0.0, 3.0 / 8.0 * double{kVoxel} / double{kRadius} + 1e-3);
    }
}

TEST_F(VdbFiles, areSampledAsOpenVdbStoresThem)
{
    const auto grid = sphere();
    const auto volume = loaded(written("sphere.vdb", {grid}));
    const auto accessor = grid->getConstAccessor();
    std::mt19937 random(2);
    const glm::ivec3 size = volume.info.dimensions;
    for (int i = 0; i < 5000; ++i) {
        const auto along = [&](std::size_t axis) {
            return static_cast<int>(volume.dataBox.low[axis]) +
                   static_cast<int>(random() % static_cast<unsigned>(size[axis]));
        };
        const openvdb::Coord voxel(along(0), along(1), along(2));
        ASSERT_EQ(
            sampleAt(*volume.field, {voxel.x(), voxel.y(), voxel.z()}), -accessor.getValue(voxel));
        // Half way along an edge, across leaves and tiles alike.
        if (voxel.x() < static_cast<int>(volume.dataBox.high.x)) {
            const double a = -double{accessor.getValue(voxel)};
            const double b = -double{accessor.getValue(voxel.offsetBy(1, 0, 0))};
            ASSERT_NEAR(
                double{sampleAt(*volume.field, {voxel.x() + 0.5, voxel.y(), voxel.z()})},
                0.5 * (a + b),
                1e-6);
        }
    }
}

TEST_F(VdbFiles, neverExcludeASampleFromTheirBounds)
{
    auto grid = sphere({-3, 5, 40});
    // Dense tiles of several sizes beside the leaves, and values that aren't finite.
    grid->fill({{-500, -300, 100}, {-100, 300, 500}}, 0.3F);
    grid->fill({{0, 0, -64}, {63, 63, -1}}, -0.2F);
    grid->tree().setValue({5, 5, 160}, std::numeric_limits<float>::quiet_NaN());
    grid->tree().setValue({25, 5, 160}, std::numeric_limits<float>::infinity());
    grid->tree().setValue({45, 5, 160}, -std::numeric_limits<float>::infinity());
    for (const bool isLevelSet : {true, false}) {
        grid->setGridClass(isLevelSet ? openvdb::GRID_LEVEL_SET : openvdb::GRID_FOG_VOLUME);
        const auto volume = loaded(written("bounds.vdb", {grid}));
        EXPECT_EQ(volume.negated, isLevelSet);
        EXPECT_EQ(volume.info.values.nonFiniteCount, 3U);
        EXPECT_EQ(countExcludedSamples(*volume.field, volume.dataBox, 5000, 3), 0U);
        const core::Box around{{-60, -40, 100}, {60, 60, 220}}; // the sphere and the odd values
        EXPECT_EQ(countExcludedSamples(*volume.field, around, 10'000, 4), 0U);
    }
}

/// What a node of a level is by its definition: of the 125 nodes of the next finer level that it
/// sees, not separated into axes, remembered by place.
class SlowLevels {
public:
    explicit SlowLevels(const openvdb::FloatGrid& grid) : _reader(grid.getConstAccessor()) {}

    double node(int level, const openvdb::Coord& at)
    {
        if (level == 0)
            return static_cast<double>(_reader.getValue(at));
        const auto [found, isNew] = _known[level].try_emplace(at, 0.0);
        if (!isNew)
            return found->second;
        constexpr std::array<double, 5> kTaps = {1, 4, 6, 4, 1};
        double sum = 0;
        for (std::size_t tap = 0; tap < 125; ++tap) {
            const std::array<std::size_t, 3> i = {tap / 25, tap / 5 % 5, tap % 5};
            sum += kTaps[i[0]] * kTaps[i[1]] * kTaps[i[2]] / 4096 *
                   node(
                       level - 1,
                       {2 * at.x() + static_cast<int>(i[0]) - 2,
                        2 * at.y() + static_cast<int>(i[1]) - 2,
                        2 * at.z() + static_cast<int>(i[2]) - 2});
        }
        return _known[level][at] = sum;
    }

    double interpolated(int level, glm::dvec3 point)
    {
        point *= std::exp2(-level);
        const glm::dvec3 low = glm::floor(point);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            openvdb::Coord at;
            for (int axis = 0; axis < 3; ++axis) {
                const auto a = static_cast<std::size_t>(axis);
                const int up = corner >> axis & 1;
                const double t = point[a] - low[a];
                weight *= up != 0 ? t : 1.0 - t;
                at[a] = static_cast<int>(low[a]) + up;
            }
            if (weight != 0)
                sum += weight * node(level, at);
        }
        return sum;
    }

private:
    openvdb::FloatGrid::ConstAccessor _reader;
    std::map<int, std::map<openvdb::Coord, double>> _known;
};

/// A level set with its tiles, far from and across the origin, and a cloud of noise with a large
/// tile and a lonely one.
std::vector<openvdb::FloatGrid::Ptr> sparseGrids()
{
    auto cloud = openvdb::FloatGrid::create(0.25F);
    cloud->setGridClass(openvdb::GRID_FOG_VOLUME);
    std::mt19937 random(31);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    for (int i = 0; i < 4000; ++i)
        cloud->tree().setValue(
            {static_cast<int>(random() % 50) - 20,
             static_cast<int>(random() % 40) - 10,
             static_cast<int>(random() % 30)},
            unit(random));
    cloud->fill(openvdb::CoordBBox({32, 32, 32}, {47, 47, 47}), 0.75F);
    cloud->fill(openvdb::CoordBBox({-64, -8, 0}, {-57, -1, 7}), -3.0F);
    cloud->setName("cloud");
    return {sphere(), sphere({-200, 5, 90}), cloud};
}

TEST_F(VdbFiles, areFilteredAsASlowTwinSays)
{
    for (const auto& grid : sparseGrids()) {
        const auto volume = loaded(written("sparse.vdb", {grid}));
        SlowLevels twin(*grid);
        const double sign = volume.negated ? -1 : 1;
        const glm::dvec3 size = volume.dataBox.size();
        const int top = 1 + static_cast<int>(std::log2(std::max({size.x, size.y, size.z}) - 1));
        std::mt19937 random(32);
        std::uniform_real_distribution<double> unit(0.0, 1.0);
        std::size_t differing = 0;
        for (int i = 0; i < 60; ++i) {
            const glm::dvec3 point =
                volume.dataBox.low + size * glm::dvec3(unit(random), unit(random), unit(random));
            // At the most three levels, or the twin would take minutes.
            const double radius = std::exp2(3 * unit(random) - 1.4);
            const detail::LevelWeights weights = detail::levelWeights(radius, top);
            double expected = 0;
            for (int k = 0; k < weights.count; ++k)
                expected += weights.weight[static_cast<std::size_t>(k)] *
                            twin.interpolated(weights.first + k, point);
            const float filtered = sampleAt(*volume.field, point, radius);
            ASSERT_NEAR(double{filtered}, sign * expected, 2e-6) << grid->getName() << radius;
            ASSERT_EQ(sampleAt(*volume.field, point, 0.41), sampleAt(*volume.field, point));
            differing += std::abs(filtered - sampleAt(*volume.field, point)) > 1e-6F ? 1U : 0U;
        }
        EXPECT_GT(differing, 5U) << grid->getName();
        EXPECT_EQ(countExcludedSamples(*volume.field, volume.dataBox, 500, 33, 60.0), 0U);
    }
}

TEST_F(VdbFiles, survivesNonFiniteVoxelsInTheFilter)
{
    const auto grid = sphere();
    grid->tree().setValue({4, 8, 12}, std::numeric_limits<float>::quiet_NaN());
    grid->tree().setValue({44, 8, 12}, std::numeric_limits<float>::infinity());
    const auto volume = loaded(written("odd.vdb", {grid}));
    EXPECT_TRUE(std::isfinite(sampleAt(*volume.field, {4, 8, 12}, 20)));
    EXPECT_TRUE(std::isfinite(sampleAt(*volume.field, {44, 8, 12}, 20)));
    EXPECT_EQ(countExcludedSamples(*volume.field, volume.dataBox, 1000, 34, 60.0), 0U);
}

TEST_F(VdbFiles, haveTightBoundsAwayFromTheSurface)
{
    const auto volume = loaded(written("sphere.vdb", {sphere({0, 0, 0})}));
    const double band = 3 * double{kVoxel};
    const auto bounds = [&](glm::dvec3 low, glm::dvec3 high) {
        return volume.field->bounds({low, high}, {0, 0});
    };
    const auto centre = bounds(glm::dvec3(-8.0), glm::dvec3(8.0));
    EXPECT_NEAR(centre.low, band, 1e-6) << "inside is proved solid";
    const auto corner = bounds(glm::dvec3(32.0), glm::dvec3(40.0));
    EXPECT_NEAR(corner.high, -band, 1e-6) << "outside is proved empty";
    const auto all = bounds(glm::dvec3(-1e6), glm::dvec3(1e6));
    EXPECT_NEAR(all.low, -band, 1e-6);
    EXPECT_NEAR(all.high, band, 1e-6);
    // The brick of cells 32..39 along x doesn't see voxel 41 and beyond.
    const auto brick = bounds({32, 0, 0}, {40, 8, 8});
    EXPECT_GT(brick.high, 0);
    EXPECT_LE(brick.low, 0.25);
}

TEST_F(VdbFiles, lieWhereTheirTransformSays)
{
    auto grid = openvdb::FloatGrid::create(0.0F);
    grid->setName("fog");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    // Row vectors times this matrix: each row is where an index axis runs.
    grid->setTransform(openvdb::math::Transform::createLinearTransform(openvdb::Mat4d(
        0.6, 0.8, 0.0, 0.0, -1.6, 1.2, 0.0, 0.0, 0.0, 0.5, 3.5, 0.0, 10.0, -20.0, 30.0, 1.0)));
    grid->tree().setValue({-3, 4, 7}, 1.0F);
    grid->tree().setValue({5, 4, 7}, 0.5F);
    const auto volume = loaded(written("fog.vdb", {grid}));
    EXPECT_FALSE(volume.negated);
    const openvdb::Vec3d expected = grid->indexToWorld(openvdb::Vec3d(-3, 4.5, 7.25));
    const glm::dvec3 found = volume.worldFromIndex.point({-3, 4.5, 7.25});
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found[axis], expected[static_cast<int>(axis)], 1e-12);
    EXPECT_EQ(volume.dataBox.low, glm::dvec3(-4, 3, 6));
    EXPECT_EQ(volume.dataBox.high, glm::dvec3(6, 5, 8));
    EXPECT_EQ(volume.info.dimensions, glm::ivec3(11, 3, 3));
    EXPECT_EQ(volume.domainOrigin, volume.dataBox.low);
    EXPECT_EQ(volume.domainEdge, 16);
    EXPECT_EQ(sampleAt(*volume.field, {-3, 4, 7}), 1.0F);
    EXPECT_EQ(sampleAt(*volume.field, {-3.5, 4, 7}), 0.5F);
    EXPECT_EQ(sampleAt(*volume.field, {-100, -100, -100}), 0.0F);
    const double isovalue = fieldIsovalue(volume, volume.info.suggestedIsovalue);
    EXPECT_GE(1.0, isovalue);
    EXPECT_LT(0.0, isovalue);
}

TEST_F(VdbFiles, withSeveralGridsGiveTheOneAskedForOrTheFirst)
{
    auto vector = openvdb::Vec3SGrid::create();
    vector->setName("velocity");
    vector->tree().setValue({0, 0, 0}, {1, 2, 3});
    auto first = openvdb::DoubleGrid::create(0.0);
    first->setName("heat");
    first->tree().setValue({0, 0, 0}, 0.125);
    auto second = openvdb::FloatGrid::create(0.0F);
    second->setName("heat");
    second->tree().setValue({0, 0, 0}, 7.0F);
    const auto path = written("several.vdb", {vector, first, second});

    const auto byDefault = loaded(path);
    EXPECT_EQ(byDefault.info.voxelType, VoxelType::float64);
    EXPECT_EQ(sampleAt(*byDefault.field, {0, 0, 0}), 0.125F);
    EXPECT_EQ(byDefault.info.gridName, "heat[0]");
    EXPECT_EQ(
        byDefault.info.gridNames, (std::vector<std::string>{"velocity", "heat[0]", "heat[1]"}));
    EXPECT_EQ(byDefault.info.notes.size(), 1U);

    const auto byName = loaded(path, {.gridName = "heat[1]"});
    EXPECT_EQ(sampleAt(*byName.field, {0, 0, 0}), 7.0F);
    EXPECT_TRUE(byName.info.notes.empty());

    const auto unknown = loadVolume(path, {.gridName = "density"});
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, ErrorCode::usage);
    EXPECT_NE(unknown.error().message.find("\"velocity\""), std::string::npos);
    EXPECT_NE(unknown.error().message.find("\"heat[1]\""), std::string::npos);

    const auto wrong = loadVolume(path, {.gridName = "velocity"});
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, ErrorCode::badData);
}

TEST_F(VdbFiles, savedWithHalfTheBitsAreRead)
{
    auto grid = sphere();
    grid->setSaveFloatAsHalf(true);
    const auto volume = loaded(written("half.vdb", {grid}));
    EXPECT_EQ(volume.info.voxelType, VoxelType::float32);
    const auto middle = volume.worldFromIndex.inverse().point({1, 2, 3});
    EXPECT_NEAR(double{sampleAt(*volume.field, middle)}, 3 * double{kVoxel}, 1e-3);
}

TEST_F(VdbFiles, withNothingToShowAreBadData)
{
    auto empty = openvdb::FloatGrid::create(1.0F);
    empty->setName("empty");
    auto perspective = sphere();
    perspective->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10.0));
    auto odd = openvdb::FloatGrid::create(1.0F);
    odd->tree().setValue({0, 0, 0}, std::numeric_limits<float>::quiet_NaN());
    auto flags = openvdb::BoolGrid::create(false);
    flags->tree().setValue({0, 0, 0}, true);
    auto distant = openvdb::FloatGrid::create(1.0F);
    distant->tree().setValue({2'000'000'000, 0, 0}, 1.0F);
    const std::vector<std::pair<openvdb::GridBase::ConstPtr, std::string>> cases = {
        {empty, "no active voxel"},
        {perspective, "frustum"},
        {odd, "finite"},
        {flags, "no grid of floats"},
        {distant, "2^29"}};
    for (const auto& [grid, part] : cases) {
        const auto volume = loadVolume(written("bad.vdb", {grid}));
        ASSERT_FALSE(volume) << part;
        EXPECT_EQ(volume.error().code, ErrorCode::badData);
        EXPECT_NE(volume.error().message.find(part), std::string::npos) << volume.error().message;
    }
    const auto none = loadVolume(written("none.vdb", {}));
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, ErrorCode::badData);
}

TEST_F(VdbFiles, aboveTheMemoryLimitAreRefused)
{
    const auto volume = loadVolume(written("sphere.vdb", {sphere()}), {.memoryLimit = 1U << 20U});
    ASSERT_FALSE(volume);
    EXPECT_EQ(volume.error().code, ErrorCode::resourceLimit);
}

TEST_F(VdbFiles, cutShortAreBadDataAtEveryLength)
{
    const auto path = written("sphere.vdb", {sphere()});
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (std::size_t part = 0; part < 64; ++part) {
        const std::size_t length = 1 + part * (bytes.size() - 1) / 64;
        const auto volume = loadVolume(folder.file("cut.vdb", bytes.substr(0, length)));
        ASSERT_FALSE(volume) << length << " of " << bytes.size();
        EXPECT_EQ(volume.error().code, ErrorCode::badData);
    }
}

} // namespace
} // namespace isofront::volume

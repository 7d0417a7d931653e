#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <ostream>

namespace isofront::volume {
namespace {

/// What is known of a volume from elsewhere.
struct Known {
    const char* file;
    VoxelType type;
    glm::ivec3 dimensions;
    double low;
    double high;
    bool isShipped;
    bool isLevelSet = false;
};

void PrintTo(const Known& known, std::ostream* stream)
{
    *stream << known.file;
}

class RealVolumes : public testing::TestWithParam<Known> {};

TEST_P(RealVolumes, areAsTheirDocumentationSays)
{
    const Known& known = GetParam();
    const bool isVdb = std::string(known.file).ends_with(".vdb");
#ifndef ISOFRONT_WITH_ITK
    if (!isVdb)
        GTEST_SKIP() << "built without ITK";
#endif
#ifndef ISOFRONT_WITH_OPENVDB
    if (isVdb)
        GTEST_SKIP() << "built without OpenVDB";
#endif
    const char* folder = known.isShipped ? ISOFRONT_DATA : std::getenv("ISOFRONT_TEST_DATA");
    if (folder == nullptr)
        GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder with volumes/";
    const auto path = std::filesystem::path(folder) / "volumes" / known.file;
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << path << " is not there";

    const auto volume = loadVolume(path);
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_EQ(volume->info.voxelType, known.type);
    // The data box of a VDB is one voxel larger on each side.
    EXPECT_EQ(volume->info.dimensions, known.dimensions + (isVdb ? 2 : 0));
    if (known.low < known.high) {
        EXPECT_NEAR(volume->info.values.low, known.low, 1e-2);
        EXPECT_NEAR(volume->info.values.high, known.high, 1e-2);
    }
    EXPECT_EQ(volume->info.values.nonFiniteCount, 0U);
    EXPECT_EQ(volume->negated, known.isLevelSet);
    if (!known.isLevelSet) {
        EXPECT_GT(volume->info.suggestedIsovalue, volume->info.values.low);
        EXPECT_LT(volume->info.suggestedIsovalue, volume->info.values.high);
    }
    EXPECT_EQ(test::countExcludedSamples(*volume->field, volume->dataBox, 1600, 1), 0U);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    RealVolumes,
    testing::Values(
        Known{"fuel_68x68x68_u8.nrrd", VoxelType::uint8, {68, 68, 68}, 0, 255, true},
        Known{"nucleon_41x41x41_u8.nrrd", VoxelType::uint8, {41, 41, 41}, 0, 249, true},
        Known{"silicium_104x40x40_u8.nrrd", VoxelType::uint8, {104, 40, 40}, 0, 255, true},
        Known{"bonsai_256x256x256_u8.nrrd", VoxelType::uint8, {256, 256, 256}, 0, 255, false},
        Known{
            "cranium_ct_256x256x108_i16.nrrd",
            VoxelType::int16,
            {256, 256, 108},
            -1024,
            2986,
            false},
        Known{"skull_64x64x64_f32.nrrd", VoxelType::float32, {64, 64, 64}, 0, 5.43, false},
        Known{"ch2better_301x370x316_u8.nii.gz", VoxelType::uint8, {301, 370, 316}, 0, 130, false},
        Known{"smoke_000003.vdb", VoxelType::float32, {51, 49, 96}, 0.001, 0.99999, false},
        Known{"densityAndHeat.vdb", VoxelType::float32, {23, 23, 42}, 0, 0, false},
        Known{"armadillo_levelset_200.vdb", VoxelType::float32, {174, 206, 158}, 0, 0, false, true},
        Known{"bunny_levelset_256.vdb", VoxelType::float32, {262, 259, 204}, 0, 0, false, true}),
    [](const testing::TestParamInfo<Known>& each) {
        const std::string name = each.param.file;
        return name.substr(
            0, name.find('_') == std::string::npos ? name.find('.') : name.find('_'));
    });

} // namespace
} // namespace isofront::volume

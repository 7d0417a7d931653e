#include "support/Random.h"
#include "support/TemporaryFolder.h"
#include "volume/DicomBytes.h"
#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

namespace isofront::volume {
namespace {

using core::ErrorCode;
using test::DicomSlice;

class Dicom : public testing::Test {
protected:
    /// Slice k of a series: voxel (i, j, k) is 100 k + 10 j + i before slope and intercept.
    static DicomSlice slice(int k)
    {
        DicomSlice result;
        for (int j = 0; j < result.rows; ++j)
            for (int i = 0; i < result.columns; ++i)
                result.pixels.push_back(static_cast<std::int16_t>(100 * k + 10 * j + i));
        result.position = {5, -6, 7 + 2.5 * k};
        result.pixelSpacing = {0.75, 0.5};
        result.instance = 10 - k;
        return result;
    }
    void write(const std::string& name, const DicomSlice& slice) const
    {
        static_cast<void>(folder.file(name, test::dicomBytes(slice)));
    }
    core::Result<LoadedVolume> load(const LoadOptions& options = {}) const
    {
        return loadVolume(folder.path("."), options);
    }
    void expectRefused(ErrorCode code, const std::string& part, const LoadOptions& options = {})
    {
        const auto volume = load(options);
        ASSERT_FALSE(volume);
        EXPECT_EQ(volume.error().code, code) << volume.error().message;
        EXPECT_NE(volume.error().message.find(part), std::string::npos) << volume.error().message;
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos) << volume.error().message;
    }
    tests::TemporaryFolder folder;
};

TEST_F(Dicom, slicesAreSortedByTheirPlaceAndRescaledInEitherByteOrder)
{
    for (const bool bigEndian : {false, true}) {
        for (int k = 0; k < 6; ++k) {
            DicomSlice s = slice(k);
            s.intercept = -1024;
            s.bigEndian = bigEndian;
            write("im" + std::to_string(k * 7 % 6), s); // names say nothing
        }
        static_cast<void>(folder.file("readme.txt", "not a slice"));
        const auto volume = load();
        ASSERT_TRUE(volume) << volume.error().message;
        EXPECT_EQ(volume->info.format, VolumeFormat::dicom);
        EXPECT_EQ(volume->info.dimensions, glm::ivec3(4, 3, 6));
        EXPECT_EQ(volume->info.voxelType, VoxelType::int16);
        for (int k = 0; k < 6; ++k)
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 4; ++i)
                    ASSERT_EQ(
                        test::sampleAt(*volume->field, {i, j, k}),
                        float(100 * k + 10 * j + i - 1024));
        const glm::dvec3 place = volume->worldFromIndex.point({1, 2, 3});
        EXPECT_NEAR(glm::distance(place, glm::dvec3(5.5, -4.5, 14.5)), 0, 1e-6);
    }
}

TEST_F(Dicom, obliqueSlicesAndTiltedGantriesLieWhereTheyWereTaken)
{
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    for (int k = 0; k < 4; ++k) {
        DicomSlice tilted = slice(k);
        tilted.orientation = {1, 0, 0, 0, c, s};
        tilted.position = {0, 0, 2.0 * k}; // moved along z, not along the slices' normal
        write("t" + std::to_string(k), tilted);
    }
    const auto volume = load();
    ASSERT_TRUE(volume) << volume.error().message;
    const glm::dvec3 place = volume->worldFromIndex.point({2, 1, 3});
    EXPECT_NEAR(glm::distance(place, glm::dvec3(1, 0.75 * c, 6 + 0.75 * s)), 0, 1e-6);
    bool told = false;
    for (const std::string& note : volume->info.notes)
        told = told || note.find("gantry") != std::string::npos;
    EXPECT_TRUE(told);
}

TEST_F(Dicom, fractionsAreKeptAsFloats)
{
    for (int k = 0; k < 3; ++k) {
        DicomSlice s = slice(k);
        s.slope = 0.125 * (k + 1); // differs from slice to slice, as in PET
        write("p" + std::to_string(k), s);
    }
    const auto volume = load();
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_EQ(volume->info.voxelType, VoxelType::float32);
    EXPECT_NEAR(test::sampleAt(*volume->field, {3, 2, 2}), 223 * 0.375, 1e-4);
    EXPECT_NEAR(test::sampleAt(*volume->field, {3, 2, 0}), 23 * 0.125, 1e-4);
}

TEST_F(Dicom, theSeriesWithTheMostSlicesIsTakenAndAnotherOnRequest)
{
    for (int k = 0; k < 5; ++k)
        write("a" + std::to_string(k), slice(k));
    for (int k = 0; k < 3; ++k) {
        DicomSlice other = slice(k);
        other.series = "1.2.3.77";
        other.description = "scout";
        write("b" + std::to_string(k), other);
    }
    const auto most = load();
    ASSERT_TRUE(most) << most.error().message;
    EXPECT_EQ(most->info.dimensions.z, 5);
    bool listed = false;
    for (const std::string& note : most->info.notes)
        listed = listed || note.find("scout") != std::string::npos;
    EXPECT_TRUE(listed);
    for (const char* name : {"scout", "1.2.3.77"}) {
        const auto other = load({.series = name});
        ASSERT_TRUE(other) << other.error().message;
        EXPECT_EQ(other->info.dimensions.z, 3);
    }
    expectRefused(ErrorCode::usage, "scout", {.series = "liver"});
}

TEST_F(Dicom, missingDoubledAndSingleSlicesAreErrors)
{
    write("s0", slice(0));
    expectRefused(ErrorCode::badData, "one slice");
    for (const int k : {1, 2, 5, 6, 7})
        write("s" + std::to_string(k), slice(k));
    expectRefused(ErrorCode::badData, "2 slices are missing");
    for (const int k : {3, 4})
        write("s" + std::to_string(k), slice(k));
    EXPECT_TRUE(load());
    write("again", slice(4));
    expectRefused(ErrorCode::badData, "same place");
}

TEST_F(Dicom, foldersOfAnythingElseAreBadData)
{
    expectRefused(ErrorCode::badData, "none of its 0 files");
    static_cast<void>(folder.file("a.txt", "hello"));
    static_cast<void>(folder.file("b.dcm", std::string(128, '\0') + "DICM"));
    expectRefused(ErrorCode::badData, "none of its 2 files");
    for (int k = 0; k < 4; ++k)
        write("s" + std::to_string(k), slice(k));
    expectRefused(ErrorCode::resourceLimit, "limit", {.memoryLimit = 95});
    std::string packed = test::dicomBytes(slice(0));
    const std::size_t syntax = packed.find("1.2.840.10008.1.2.1");
    for (const auto& [name, words] :
         {std::pair<std::string, std::string>{"1.2.840.10008.1.2.4.70", "JPEG without losses"},
          {"1.2.840.10008.1.2.4.90", "JPEG 2000 without losses"},
          {"1.2.840.10008.1.2.1.99", "deflated"},
          {"1.2.840.10008.1.2.9.99", "unknown"},
          {"1.\n2", "not named"}}) {
        // The text, its length before it and that of the group.
        std::string bytes = packed;
        const std::string value = name + std::string(name.size() % 2, '\0');
        bytes.replace(syntax, 20, value);
        bytes[syntax - 2] = static_cast<char>(value.size());
        const std::size_t group = 128 + 4 + 8;
        bytes[group] = static_cast<char>(bytes[group] + static_cast<int>(value.size()) - 20);
        tests::TemporaryFolder other;
        const auto refused = loadVolume(other.file("packed/s0", bytes).parent_path());
        ASSERT_FALSE(refused);
        for (const std::string& part :
             {words, std::string("transfer syntax"), std::string("gdcmconv")})
            EXPECT_NE(refused.error().message.find(part), std::string::npos)
                << refused.error().message;
        EXPECT_EQ(refused.error().message.find('\n'), std::string::npos);
    }
}

TEST_F(Dicom, runsOfBytesAreUnpacked)
{
    tests::TemporaryFolder plain;
    auto random = tests::random(6);
    for (int k = 0; k < 4; ++k) {
        DicomSlice s = slice(k);
        s.columns = 61;
        s.rows = 47;
        s.pixels.clear();
        // Flat parts, ramps and noise: runs and literals of all lengths, below zero too.
        for (int i = 0; i < 61 * 47; ++i)
            s.pixels.push_back(
                i < 700    ? static_cast<std::int16_t>(-1000)
                : i < 1500 ? static_cast<std::int16_t>(i - 1100)
                           : static_cast<std::int16_t>(random() % (random() % 3 == 0 ? 2 : 4096)));
        static_cast<void>(plain.file("s" + std::to_string(k), test::dicomBytes(s)));
        s.hasRuns = true;
        write("s" + std::to_string(k), s);
    }
    const auto packed = load();
    ASSERT_TRUE(packed) << packed.error().message;
    const auto expected = loadVolume(plain.path("."));
    ASSERT_TRUE(expected) << expected.error().message;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 47; ++j)
            for (int i = 0; i < 61; ++i)
                ASSERT_EQ(
                    test::sampleAt(*packed->field, {i, j, k}),
                    test::sampleAt(*expected->field, {i, j, k}))
                    << i << ' ' << j << ' ' << k;
}

TEST_F(Dicom, filesWithRandomDamageNeverCrash)
{
    auto random = tests::random(5);
    for (int k = 1; k < 3; ++k)
        write("s" + std::to_string(k), slice(k));
    DicomSlice asRuns = slice(0);
    asRuns.hasRuns = true;
    const std::array goods{test::dicomBytes(slice(0)), test::dicomBytes(asRuns)};
    for (int i = 0; i < 400 * tests::intensity(); ++i) {
        std::string bad = goods[static_cast<std::size_t>(i % 2)];
        for (std::size_t change = 0; change < 1 + random() % 3; ++change)
            bad[132 + random() % (bad.size() - 132)] = static_cast<char>(random());
        if (random() % 4 == 0)
            bad.resize(random() % bad.size());
        static_cast<void>(folder.file("s0", bad));
        const auto volume = load({.memoryLimit = 1U << 20U});
        ASSERT_TRUE(volume || !volume.error().message.empty());
    }
}

} // namespace
} // namespace isofront::volume

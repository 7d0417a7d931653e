#include "DenseVoxels.h"
#include "TiffVolume.h"
#include "support/FileBytes.h"
#include "support/NumberTypes.h"
#include "support/Random.h"
#include "support/TemporaryFolder.h"
#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace isofront::volume {
namespace {

using core::ErrorCode;
using tests::bytesOf;
using tests::TiffPageBytes;

void expectRefused(
    const std::filesystem::path& path,
    ErrorCode code,
    const std::string& part,
    const LoadOptions& options = {})
{
    const auto volume = loadVolume(path, options);
    ASSERT_FALSE(volume) << path << ' ' << part;
    EXPECT_EQ(volume.error().code, code) << volume.error().message;
    EXPECT_NE(volume.error().message.find(part), std::string::npos) << volume.error().message;
    EXPECT_EQ(volume.error().message.find('\n'), std::string::npos) << volume.error().message;
}

bool hasNote(const LoadedVolume& volume, const std::string& part)
{
    for (const std::string& note : volume.info.notes)
        if (note.find(part) != std::string::npos)
            return true;
    return false;
}

template <typename T>
struct TypeName;
#define ISOFRONT_TYPE_NAME(type, name)                                                             \
    template <>                                                                                    \
    struct TypeName<type> {                                                                        \
        static constexpr const char* kName = name;                                                 \
    }
ISOFRONT_TYPE_NAME(std::int8_t, "int8");
ISOFRONT_TYPE_NAME(std::uint8_t, "uint8");
ISOFRONT_TYPE_NAME(std::int16_t, "int16");
ISOFRONT_TYPE_NAME(std::uint16_t, "uint16");
ISOFRONT_TYPE_NAME(std::int32_t, "int32");
ISOFRONT_TYPE_NAME(std::uint32_t, "uint32");
ISOFRONT_TYPE_NAME(std::int64_t, "int64");
ISOFRONT_TYPE_NAME(std::uint64_t, "uint64");
ISOFRONT_TYPE_NAME(float, "float32");
ISOFRONT_TYPE_NAME(double, "float64");
#undef ISOFRONT_TYPE_NAME

template <typename T>
class StackOf : public testing::Test {
protected:
    /// 5 x 4 x 3 voxels whose values are their numbers.
    static std::vector<T> counted()
    {
        std::vector<T> values;
        for (int i = 0; i < 60; ++i)
            values.push_back(static_cast<T>(i));
        return values;
    }
    static void expectCounted(const core::Result<LoadedVolume>& volume)
    {
        ASSERT_TRUE(volume) << volume.error().message;
        EXPECT_EQ(volume->info.dimensions, glm::ivec3(5, 4, 3));
        const bool isWide = std::is_integral_v<T> && sizeof(T) == 8;
        EXPECT_EQ(
            nameOf(volume->info.voxelType),
            isWide ? (std::is_signed_v<T> ? "int32" : "uint32") : TypeName<T>::kName);
        EXPECT_EQ(hasNote(*volume, "64-bit"), isWide);
        for (int i = 0; i < 60; ++i)
            ASSERT_EQ(test::sampleAt(*volume->field, {i % 5, i / 5 % 4, i / 20}), float(i));
    }
    tests::TemporaryFolder folder;
};
TYPED_TEST_SUITE(StackOf, tests::SampleTypes);

TYPED_TEST(StackOf, rawNumbersIsReadInEitherByteOrderPlainAndGzipped)
{
    const auto values = this->counted();
    for (const bool bigEndian : {false, true}) {
        const std::string bytes = "header!" + bytesOf(values, bigEndian);
        const std::string order = bigEndian ? "big" : "little";
        const std::string layout =
            std::string("5x4x3,") + TypeName<TypeParam>::kName + "," + order + ",7";
        this->expectCounted(loadVolume(this->folder.file("a.raw", bytes), {.rawLayout = layout}));
        this->expectCounted(loadVolume(
            this->folder.file("a.raw.gz", tests::gzipped(bytes)), {.rawLayout = layout}));
        const std::string json = std::string(R"({"dimensions": [5, 4, 3], "type": ")") +
                                 TypeName<TypeParam>::kName + R"(", "byteOrder": ")" + order +
                                 R"(", "offset": 7})";
        static_cast<void>(this->folder.file("b.bin.json", json));
        this->expectCounted(loadVolume(this->folder.file("b.bin", bytes)));
    }
}

TYPED_TEST(StackOf, tiffSlicesIsReadFromPagesAndFoldersInEitherByteOrder)
{
    const auto values = this->counted();
    const LoadOptions options{.voxelSize = glm::dvec3(1, 2, 3)};
    for (const bool bigEndian : {false, true}) {
        std::vector<TiffPageBytes> pages;
        for (int z = 0; z < 3; ++z) {
            TiffPageBytes page;
            page.width = 5;
            page.height = 4;
            page.bits = 8 * sizeof(TypeParam);
            page.format = std::is_floating_point_v<TypeParam> ? 3
                          : std::is_signed_v<TypeParam>       ? 2
                                                              : 1;
            page.chunks = {bytesOf(
                std::vector<TypeParam>(values.begin() + 20 * z, values.begin() + 20 * (z + 1)),
                bigEndian)};
            pages.push_back(page);
            // slice 9, slice 10, slice 11
            static_cast<void>(this->folder.file(
                "stack/slice" + std::to_string(9 + z) + ".TIF",
                tests::tiffBytes({page}, bigEndian)));
        }
        const auto many =
            loadVolume(this->folder.file("a.tif", tests::tiffBytes(pages, bigEndian)), options);
        this->expectCounted(many);
        EXPECT_EQ(many->info.spacing, glm::dvec3(1, 2, 3));
        this->expectCounted(loadVolume(this->folder.path("stack"), options));
    }
}

TYPED_TEST(StackOf, niftiOfBothVersionsIsReadInEitherByteOrderPlainAndGzipped)
{
    const auto values = this->counted();
    const std::int16_t code = std::is_same_v<TypeParam, std::int8_t>     ? 256
                              : std::is_same_v<TypeParam, std::uint8_t>  ? 2
                              : std::is_same_v<TypeParam, std::int16_t>  ? 4
                              : std::is_same_v<TypeParam, std::uint16_t> ? 512
                              : std::is_same_v<TypeParam, std::int32_t>  ? 8
                              : std::is_same_v<TypeParam, std::uint32_t> ? 768
                              : std::is_same_v<TypeParam, std::int64_t>  ? 1024
                              : std::is_same_v<TypeParam, std::uint64_t> ? 1280
                              : std::is_same_v<TypeParam, float>         ? 16
                                                                         : 64;
    for (const bool second : {false, true})
        for (const bool bigEndian : {false, true}) {
            std::string header(second ? 544 : 352, '\0');
            const auto put = [&](std::size_t at, auto value) {
                const std::string bytes = bytesOf(std::vector{value}, bigEndian);
                header.replace(at, bytes.size(), bytes);
            };
            const auto bits = static_cast<std::int16_t>(8 * sizeof(TypeParam));
            // z is up, x and y turned by half a turn about it: b = c = 0, d = 1
            if (second) {
                put(0, std::int32_t{540});
                header.replace(4, 8, "n+2\0\r\n\032\n", 8);
                put(12, code);
                put(14, bits);
                for (std::size_t i = 0; i < 8; ++i)
                    put(16 + 8 * i, std::array<std::int64_t, 8>{3, 5, 4, 3, 1, 1, 1, 1}[i]);
                for (std::size_t i = 0; i < 4; ++i)
                    put(104 + 8 * i, std::array{1.0, 0.5, 2.0, 3.0}[i]);
                put(168, std::int64_t{544});
                put(344, std::int32_t{1});
                for (std::size_t i = 0; i < 6; ++i)
                    put(352 + 8 * i, std::array{0.0, 0.0, 1.0, 10.0, 20.0, 30.0}[i]);
            } else {
                put(0, std::int32_t{348});
                for (std::size_t i = 0; i < 8; ++i)
                    put(40 + 2 * i, std::array<std::int16_t, 8>{3, 5, 4, 3, 1, 1, 1, 1}[i]);
                put(70, code);
                put(72, bits);
                for (std::size_t i = 0; i < 4; ++i)
                    put(76 + 4 * i, std::array{1.0F, 0.5F, 2.0F, 3.0F}[i]);
                put(108, 352.0F);
                put(252, std::int16_t{1});
                for (std::size_t i = 0; i < 6; ++i)
                    put(256 + 4 * i, std::array{0.0F, 0.0F, 1.0F, 10.0F, 20.0F, 30.0F}[i]);
                header.replace(344, 4, "n+1\0", 4);
            }
            const std::string bytes = header + bytesOf(values, bigEndian);
            const auto plain = loadVolume(this->folder.file("a.nii", bytes));
            this->expectCounted(plain);
            this->expectCounted(loadVolume(this->folder.file("a.nii.gz", tests::gzipped(bytes))));
            // RAS (10 - 0.5 i, 20 - 2 j, 30 + 3 k), so LPS has x and y negated
            const glm::dvec3 place = plain->worldFromIndex.point({1, 2, 3});
            EXPECT_NEAR(glm::distance(place, glm::dvec3(-9.5, -16, 39)), 0, 1e-5);
        }
}

class StackFiles : public testing::Test {
protected:
    tests::TemporaryFolder folder;
};

TEST_F(StackFiles, ofNiftiKeepAndCountWhatIsNotFinite)
{
    std::vector<float> values(64, 1);
    values[5] = std::numeric_limits<float>::quiet_NaN();
    values[6] = std::numeric_limits<float>::infinity();
    test::NiftiOptions options;
    options.type = 16;
    options.bits = 32;
    const auto volume =
        loadVolume(folder.file("a.nii", test::niftiHeader(options) + test::bytesOf(values)));
    ASSERT_TRUE(volume) << volume.error().message;
    EXPECT_EQ(volume->info.values.nonFiniteCount, 2U);
    EXPECT_TRUE(std::isnan(test::sampleAt(*volume->field, {1, 1, 0})));
}

#ifdef ISOFRONT_WITH_ITK
TEST_F(StackFiles, ofMetaImagePackedWithoutTheirLengthAreReadInEitherByteOrder)
{
    std::vector<std::uint16_t> values(60);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint16_t>(900 * i + 7);
    for (const bool bigEndian : {false, true}) {
        std::string header = test::metaHeader("5 4 3", "CompressedData = True\n");
        header.replace(header.find("MET_UCHAR"), 9, "MET_USHORT");
        if (bigEndian)
            header.replace(header.find("MSB = False"), 11, "MSB = True");
        const auto volume =
            loadVolume(folder.file("a.mha", header + tests::deflated(bytesOf(values, bigEndian))));
        ASSERT_TRUE(volume) << volume.error().message;
        for (int i = 0; i < 60; ++i)
            ASSERT_EQ(test::sampleAt(*volume->field, {i % 5, i / 5 % 4, i / 20}), 900 * i + 7);
    }
}
#endif

TEST_F(StackFiles, ofWideIntegersAreKeptAsDoublesAndSayIfTheyAreExact)
{
    const auto load = [&](const std::vector<std::int64_t>& values) {
        return loadVolume(
            folder.file("a.raw", bytesOf(values)), {.rawLayout = "2x2x1,int64,little"});
    };
    const auto exact = load({1, -5, std::int64_t{1} << 40, std::int64_t{1} << 60});
    ASSERT_TRUE(exact) << exact.error().message;
    EXPECT_EQ(exact->info.voxelType, VoxelType::float64);
    EXPECT_TRUE(hasNote(*exact, "exact"));
    EXPECT_EQ(exact->info.values.high, 0x1p60);
    for (const std::int64_t odd : {(std::int64_t{1} << 53) + 1, INT64_MAX, INT64_MIN + 1}) {
        const auto rounded = load({1, 2, 3, odd});
        ASSERT_TRUE(rounded);
        EXPECT_TRUE(hasNote(*rounded, "rounded")) << odd;
    }
    const auto nrrd = loadVolume(folder.file(
        "a.nrrd",
        test::nrrdHeader("int64", "2 2 1") + bytesOf(std::vector<std::int64_t>{1, 2, 3, -4})));
#ifdef ISOFRONT_WITH_ITK
    ASSERT_TRUE(nrrd) << nrrd.error().message;
    EXPECT_EQ(nrrd->info.voxelType, VoxelType::int32);
    EXPECT_EQ(nrrd->info.values.low, -4);
#else
    EXPECT_FALSE(nrrd);
#endif
}

TEST_F(StackFiles, ofRawNumbersLieWhereTheirDescriptionSays)
{
    const auto path = folder.file("ct.raw", std::string(60, '\3'));
    static_cast<void>(folder.file(
        "ct.json",
        R"({"dimensions": [5, 4, 3], "type": "uint8", "spacing": [1, 2, 4], "origin": [7, 8, 9],
            "directions": [[0, 3, 0], [-1, 0, 0], [0, 0.6, 0.8]]})"));
    const auto volume = loadVolume(path);
    ASSERT_TRUE(volume) << volume.error().message;
    const glm::dvec3 place = volume->worldFromIndex.point({1, 2, 3});
    EXPECT_NEAR(glm::distance(place, glm::dvec3(7 - 4, 8 + 1 + 7.2, 9 + 9.6)), 0, 1e-9);
}

TEST_F(StackFiles, ofRawNumbersWithWrongDescriptionsAreRefused)
{
    const auto path = folder.file("a.raw", std::string(64, 'x'));
    expectRefused(path, ErrorCode::usage, "--raw");
    for (const char* layout :
         {"4x4,uint8",
          "4x4x4",
          "4x4x4,uint9",
          "0x4x4,uint8",
          "-4x4x4,uint8",
          "4x4x4x1,uint8",
          "4x4x2,uint16",
          "4x4x2,uint16,middle",
          "4x4x2,uint16,little,x",
          "4x4x2,uint16,little,-1",
          "4x4x2,uint16,little,0,0",
          "",
          ","})
        expectRefused(path, ErrorCode::usage, "--raw", {.rawLayout = layout});
    expectRefused(path, ErrorCode::badData, "cut short", {.rawLayout = "4x4x5,uint8"});
    expectRefused(path, ErrorCode::badData, "cut short", {.rawLayout = "4x4x4,uint8,1"});
    expectRefused(
        path, ErrorCode::badData, "cut short", {.rawLayout = "1000000x1000000x1000000,uint8"});
    expectRefused(path, ErrorCode::badData, "2^30", {.rawLayout = "9999999999x1x1,uint8"});
    expectRefused(
        path, ErrorCode::resourceLimit, "limit", {.memoryLimit = 63, .rawLayout = "4x4x4,uint8"});
    expectRefused(
        path,
        ErrorCode::usage,
        "--voxel-size",
        {.rawLayout = "4x4x4,uint8", .voxelSize = glm::dvec3(1, 0, 1)});
    for (const char* json :
         {"",
          "[]",
          "{",
          "{}",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "colour": 1})",
          R"({"dimensions": [4, 4], "type": "uint8"})",
          R"({"dimensions": [4, 4, -4], "type": "uint8"})",
          R"({"dimensions": [4, 4, 4], "type": "uint9"})",
          R"({"dimensions": [4, 4, 4], "type": 8})",
          R"({"dimensions": [4, 4, 2], "type": "int16"})",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "offset": -1})",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "spacing": [1, 1, 0]})",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "spacing": [1, 1]})",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "origin": ["a", 1, 1]})",
          R"({"dimensions": [4, 4, 4], "type": "uint8", "directions": [[1, 0, 0], [0, 1, 0]]})",
          R"({"dimensions": [4, 4, 4], "type": "uint8",
              "directions": [[1, 0, 0], [2, 0, 0], [0, 0, 1]]})"}) {
        static_cast<void>(folder.file("a.raw.json", json));
        expectRefused(path, ErrorCode::badData, "", {});
    }
    const std::string packed = tests::gzipped(std::string(64, 'x'));
    expectRefused(
        folder.file("b.raw.gz", packed.substr(0, packed.size() - 12)),
        ErrorCode::badData,
        "cut short",
        {.rawLayout = "4x4x4,uint8"});
}

TiffPageBytes greyPage(std::uint32_t width, std::uint32_t height, char value)
{
    TiffPageBytes page;
    page.width = width;
    page.height = height;
    page.chunks = {std::string(std::size_t{width} * height, value)};
    return page;
}

TEST_F(StackFiles, ofTiffNeedAVoxelSizeUnlessTheFileHasOne)
{
    TiffPageBytes page = greyPage(3, 2, 1);
    const auto load = [&] {
        return loadVolume(folder.file("a.tif", tests::tiffBytes({page, page})));
    };
    expectRefused(
        folder.file("b.tif", tests::tiffBytes({page, page})), ErrorCode::usage, "--voxel-size");
    page.texts = {{270, "ImageJ=1.53\nimages=2\nspacing=2.5\nunit=micron\n"}};
    expectRefused(
        folder.file("b.tif", tests::tiffBytes({page, page})), ErrorCode::usage, "--voxel-size");
    page.texts = {
        {270,
         R"(<OME><Pixels PhysicalSizeX="0.5" PhysicalSizeY="0.25" PhysicalSizeZ="3"/></OME>)"}};
    const auto ome = load();
    ASSERT_TRUE(ome) << ome.error().message;
    EXPECT_EQ(ome->info.spacing, glm::dvec3(0.5, 0.25, 3));
    page.texts = {{270, R"(<OME><Pixels PhysicalSizeX="0.5" PhysicalSizeZ="-3"/></OME>)"}};
    EXPECT_FALSE(load());
}

TEST_F(StackFiles, ofTiffThatAreNotAlikeAreRefused)
{
    const LoadOptions options{.voxelSize = glm::dvec3(1)};
    static_cast<void>(folder.file("s/a1.tif", tests::tiffBytes({greyPage(3, 2, 1)})));
    expectRefused(folder.path("s"), ErrorCode::badData, "one slice", options);
    static_cast<void>(folder.file("s/a2.tif", tests::tiffBytes({greyPage(2, 3, 1)})));
    expectRefused(folder.path("s"), ErrorCode::badData, "a2.tif", options);
    static_cast<void>(folder.file("s/a2.tif", "damaged"));
    expectRefused(folder.path("s"), ErrorCode::badData, "a2.tif", options);
    static_cast<void>(folder.file("s/a2.tif", tests::tiffBytes({greyPage(3, 2, 1)})));
    expectRefused(
        folder.path("s"),
        ErrorCode::resourceLimit,
        "limit",
        {.memoryLimit = 11, .voxelSize = glm::dvec3(1)});
}

TEST_F(StackFiles, withRandomDamageNeverCrash)
{
    auto random = tests::random(31);
    const std::string tiff = tests::tiffBytes({greyPage(8, 8, 1), greyPage(8, 8, 2)});
    test::NiftiOptions options;
    const std::string nifti = tests::gzipped(test::niftiHeader(options) + std::string(64, 'x'));
    const std::string json =
        R"({"dimensions": [4, 4, 4], "type": "uint8", "spacing": [1, 1, 2], "offset": 0})";
    const auto raw = folder.file("r.raw", std::string(64, 'x'));
    for (int i = 0; i < 200 * tests::intensity(); ++i)
        for (const auto& [name, good] :
             {std::pair{"r.tif", tiff},
              std::pair{"r.nii.gz", nifti},
              std::pair{"r.raw.json", json}}) {
            std::string bad = good;
            for (std::size_t change = 0; change < 1 + random() % 3; ++change)
                bad[random() % bad.size()] = static_cast<char>(random());
            const auto path = folder.file(name, bad);
            const auto volume = loadVolume(
                std::string(name) == "r.raw.json" ? raw : path,
                {.memoryLimit = 1U << 20U, .voxelSize = glm::dvec3(1)});
            ASSERT_TRUE(volume || !volume.error().message.empty());
        }
}

TEST(NaturalOrder, putsNumbersByTheirValueAndIsAnOrder)
{
    const std::vector<std::string> sorted{
        "", "a", "a1", "a01", "a2", "a2b", "a10", "a10b2", "a10b11", "a99999999999999999999", "b"};
    for (std::size_t i = 0; i < sorted.size(); ++i)
        for (std::size_t j = 0; j < sorted.size(); ++j) {
            if (sorted[i] == "a1" || sorted[j] == "a1") // its order with a01 is by letters
                continue;
            EXPECT_EQ(comesNaturallyBefore(sorted[i], sorted[j]), i < j)
                << sorted[i] << ' ' << sorted[j];
        }
    EXPECT_NE(comesNaturallyBefore("a1", "a01"), comesNaturallyBefore("a01", "a1"));
}

} // namespace
} // namespace isofront::volume

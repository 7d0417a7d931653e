#include "volume/Files.h"

#include <isofront/volume/LoadVolume.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace isofront::volume {
namespace {

using test::sampleAt;

/// These tests read files through ITK.
class DenseFiles : public testing::Test {
protected:
    void SetUp() override
    {
#ifndef ISOFRONT_WITH_ITK
        GTEST_SKIP() << "built without ITK";
#endif
    }

    test::TemporaryFolder folder;
};

LoadedVolume loaded(const std::filesystem::path& path, const LoadOptions& options = {})
{
    auto volume = loadVolume(path, options);
    if (!volume)
        throw std::runtime_error(volume.error().message);
    return std::move(*volume);
}

template <typename T>
std::vector<T> counted(std::size_t count, T first = T(0))
{
    std::vector<T> values(count);
    std::iota(values.begin(), values.end(), first);
    return values;
}

void expectPoint(const glm::dvec3& found, const glm::dvec3& expected)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(found[axis], expected[axis], 1e-5) << "axis " << axis;
}

template <typename T>
void expectKeptAs(const test::TemporaryFolder& folder, const std::string& typeName, VoxelType type)
{
    const auto values = counted<T>(60, T(40));
    const auto volume = loaded(folder.file(
        typeName + ".nrrd", test::nrrdHeader(typeName, "3 4 5") + test::bytesOf(values)));
    EXPECT_EQ(volume.info.voxelType, type);
    EXPECT_EQ(volume.info.dimensions, glm::ivec3(3, 4, 5));
    EXPECT_EQ(volume.info.values.low, 40);
    EXPECT_EQ(volume.info.values.high, 99);
    std::size_t next = 0;
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 3; ++x)
                EXPECT_EQ(sampleAt(*volume.field, {x, y, z}), static_cast<float>(values[next++]));
}

TEST_F(DenseFiles, keepEveryVoxelTypeOfNrrd)
{
    expectKeptAs<std::int8_t>(folder, "int8", VoxelType::int8);
    expectKeptAs<std::uint8_t>(folder, "uchar", VoxelType::uint8);
    expectKeptAs<std::int16_t>(folder, "short", VoxelType::int16);
    expectKeptAs<std::uint16_t>(folder, "uint16", VoxelType::uint16);
    expectKeptAs<std::int32_t>(folder, "int", VoxelType::int32);
    expectKeptAs<std::uint32_t>(folder, "uint32_t", VoxelType::uint32);
    expectKeptAs<float>(folder, "float", VoxelType::float32);
    expectKeptAs<double>(folder, "double", VoxelType::float64);
}

TEST_F(DenseFiles, readEveryEncodingOfNrrdAlike)
{
    const auto values = counted<std::uint8_t>(60);
    std::string text;
    std::string hex;
    for (const auto value : values) {
        text += std::to_string(value) + " ";
        hex += std::string() + "0123456789abcdef"[value / 16] + "0123456789abcdef"[value % 16];
    }
    const std::vector<std::filesystem::path> files = {
        folder.file(
            "a.nrrd",
            test::nrrdHeader("uint8", "3 4 5", "gzip") + test::gzipped(test::bytesOf(values))),
        folder.file("b.nrrd", test::nrrdHeader("uint8", "3 4 5", "ascii") + text),
        folder.file("c.NRRD", test::nrrdHeader("uint8", "3 4 5", "hex") + hex),
        folder.file("d.nhdr", test::nrrdHeader("uint8", "3 4 5", "raw", "data file: d.raw\n")),
        folder.file(
            "e.nrrd",
            test::nrrdHeader("uint8", "3 4 5", "raw", "byte skip: -1\n") + "something before" +
                test::bytesOf(values))};
    (void)folder.file("d.raw", test::bytesOf(values));
    for (const auto& file : files) {
        const auto volume = loaded(file);
        EXPECT_EQ(sampleAt(*volume.field, {1, 2, 3}), 1 + 2 * 3 + 3 * 12) << file;
    }
}

TEST_F(DenseFiles, lieWhereAnisotropicObliqueNrrdHeadersSay)
{
    // Rotated about two axes, and spaced differently along each.
    const auto volume = loaded(folder.file(
        "oblique.nrrd",
        test::nrrdHeader(
            "uint8",
            "3 4 5",
            "raw",
            "space: left-posterior-superior\n"
            "space directions: (0.6,0.8,0) (-1.6,1.2,0) (0,0,3.5)\nspace origin: (10,-20,30)\n") +
            test::bytesOf(counted<std::uint8_t>(60))));
    for (const glm::dvec3 index : {glm::dvec3(0.0), glm::dvec3(2, 1, 4), glm::dvec3(0, 3, 2)})
        expectPoint(
            volume.worldFromIndex.point(index),
            glm::dvec3(10, -20, 30) + index.x * glm::dvec3(0.6, 0.8, 0) +
                index.y * glm::dvec3(-1.6, 1.2, 0) + index.z * glm::dvec3(0, 0, 3.5));
    expectPoint(volume.info.spacing, {1, 2, 3.5});
    expectPoint(volume.info.direction[1], {-0.8, 0.6, 0});
    expectPoint(volume.info.origin, {10, -20, 30});
    EXPECT_FALSE(volume.worldFromIndex.mirrors());
}

TEST_F(DenseFiles, keepShearAndMirrorOfNrrd)
{
    const auto volume = loaded(folder.file(
        "sheared.nrrd",
        test::nrrdHeader(
            "uint8",
            "3 4 5",
            "raw",
            "space dimension: 3\nspace directions: (2,0,0) (1,2,0) (0,0,-4)\n"
            "space origin: (1,2,3)\n") +
            test::bytesOf(counted<std::uint8_t>(60))));
    expectPoint(volume.worldFromIndex.point({1, 1, 1}), {1 + 2 + 1, 2 + 2, 3 - 4});
    EXPECT_TRUE(volume.worldFromIndex.mirrors());
}

TEST_F(DenseFiles, areTurnedFromRasToLps)
{
    const auto nrrd = loaded(folder.file(
        "ras.nrrd",
        test::nrrdHeader(
            "uint8",
            "3 4 5",
            "raw",
            "space: right-anterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
            "space origin: (10,20,30)\n") +
            test::bytesOf(counted<std::uint8_t>(60))));
    expectPoint(nrrd.worldFromIndex.point({1, 2, 3}), {-12, -26, 42});

    test::NiftiOptions options;
    options.dimensions = {3, 4, 5};
    options.affine = {2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30};
    options.spacing = {2, 3, 4};
    const auto nifti = loaded(folder.file(
        "ras.nii", test::niftiHeader(options) + test::bytesOf(counted<std::uint8_t>(60))));
    expectPoint(nifti.worldFromIndex.point({1, 2, 3}), {-12, -26, 42});
    EXPECT_EQ(sampleAt(*nifti.field, {1, 2, 3}), 1 + 2 * 3 + 3 * 12);

    // Oblique: the first axis runs along (0.6, 0.8, 0) in RAS.
    options.affine = {1.2F, -2.4F, 0, 10, 1.6F, 1.8F, 0, 20, 0, 0, 4, 30};
    const auto oblique = loaded(folder.file(
        "oblique.nii.gz",
        test::gzipped(test::niftiHeader(options) + test::bytesOf(counted<std::uint8_t>(60)))));
    expectPoint(
        oblique.worldFromIndex.point({2, 1, 1}),
        {-(10 + 2 * 1.2 - 2.4), -(20 + 2 * 1.6 + 1.8), 34});
}

TEST_F(DenseFiles, applyTheScaleOfNifti)
{
    test::NiftiOptions options;
    options.type = 4;
    options.bits = 16;
    options.slope = 0.5F;
    options.intercept = -3;
    const auto volume = loaded(folder.file(
        "scaled.nii", test::niftiHeader(options) + test::bytesOf(counted<std::int16_t>(64))));
    EXPECT_EQ(volume.info.voxelType, VoxelType::float32);
    EXPECT_EQ(sampleAt(*volume.field, {3, 2, 1}), 0.5F * (3 + 8 + 16) - 3);
}

TEST_F(DenseFiles, readMetaImagesRawAndCompressed)
{
    const std::string bytes = test::bytesOf(counted<std::uint8_t>(60));
    const std::string packed = test::zlibbed(bytes);
    const std::vector<std::filesystem::path> files = {
        folder.file("a.mha", test::metaHeader("3 4 5") + bytes),
        folder.file("b.mha", test::metaHeader("3 4 5", "CompressedData = True\n") + packed),
        folder.file(
            "c.mha",
            test::metaHeader(
                "3 4 5",
                "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
                    "\n") +
                packed),
        folder.file("d.mhd", test::metaHeader("3 4 5", "", "d.raw"))};
    (void)folder.file("d.raw", bytes);
    for (const auto& file : files) {
        const auto volume = loaded(file);
        EXPECT_EQ(volume.info.format, VolumeFormat::metaImage);
        EXPECT_EQ(sampleAt(*volume.field, {1, 2, 3}), 1 + 2 * 3 + 3 * 12) << file;
        // The matrix has the directions of the index axes one after the other.
        expectPoint(volume.worldFromIndex.point({1, 0, 0}), {5, 6 + 2, 7});
        expectPoint(volume.worldFromIndex.point({0, 1, 0}), {5 - 3, 6, 7});
    }
}

TEST_F(DenseFiles, areSolidInsideInEveryFormat)
{
    // A bright ball in the dark: the suggested isovalue must have its centre inside.
    std::vector<std::uint8_t> values(21 * 21 * 21);
    for (int i = 0; i < 21 * 21 * 21; ++i) {
        const glm::dvec3 offset = glm::dvec3(i % 21, i / 21 % 21, i / 441) - 10.0;
        const double distance =
            std::sqrt(offset.x * offset.x + offset.y * offset.y + offset.z * offset.z);
        values[static_cast<std::size_t>(i)] =
            static_cast<std::uint8_t>(std::clamp(120 + 40 * (6 - distance), 0.0, 240.0));
    }
    const std::string bytes = test::bytesOf(values);
    test::NiftiOptions options;
    options.dimensions = {21, 21, 21};
    for (const auto& file :
         {folder.file("ball.nrrd", test::nrrdHeader("uint8", "21 21 21") + bytes),
          folder.file("ball.nii", test::niftiHeader(options) + bytes),
          folder.file("ball.mha", test::metaHeader("21 21 21") + bytes)}) {
        const auto volume = loaded(file);
        EXPECT_FALSE(volume.negated);
        const double isovalue = fieldIsovalue(volume, volume.info.suggestedIsovalue);
        EXPECT_GE(double{sampleAt(*volume.field, {10, 10, 10})}, isovalue) << file;
        EXPECT_LT(double{sampleAt(*volume.field, {1, 10, 10})}, isovalue) << file;
        EXPECT_NE(volume.info.orientation.find("at or above"), std::string::npos);
    }
}

TEST_F(DenseFiles, fitTheSmallestDomainOfAPowerOfTwo)
{
    const auto domainOf = [&](int x, int y, int z) {
        const std::string sizes =
            std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z);
        const auto volume = loaded(folder.file(
            "domain.nrrd",
            test::nrrdHeader("uint8", sizes) +
                std::string(static_cast<std::size_t>(x * y * z), '\1')));
        EXPECT_EQ(volume.domainOrigin, glm::dvec3(0.0));
        EXPECT_EQ(volume.dataBox.high, glm::dvec3(x - 1, y - 1, z - 1));
        return volume.domainEdge;
    };
    EXPECT_EQ(domainOf(1, 1, 1), 2);
    EXPECT_EQ(domainOf(3, 2, 1), 2);
    EXPECT_EQ(domainOf(4, 2, 1), 4);
    EXPECT_EQ(domainOf(2, 65, 1), 64);
    EXPECT_EQ(domainOf(2, 2, 66), 128);
}

TEST_F(DenseFiles, countNonFiniteVoxelsAndKeepThem)
{
    auto values = counted<float>(60);
    values[7] = NAN;
    values[8] = INFINITY;
    const auto volume =
        loaded(folder.file("odd.nrrd", test::nrrdHeader("float", "3 4 5") + test::bytesOf(values)));
    EXPECT_EQ(volume.info.values.nonFiniteCount, 2U);
    EXPECT_EQ(volume.info.values.high, 59);
    EXPECT_TRUE(std::isnan(sampleAt(*volume.field, {1, 2, 0})));

    const auto none = loadVolume(folder.file(
        "none.nrrd",
        test::nrrdHeader("float", "3 4 5") + test::bytesOf(std::vector<float>(60, NAN))));
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, core::ErrorCode::badData);
    EXPECT_NE(none.error().message.find("finite"), std::string::npos);
}

TEST_F(DenseFiles, refuseGeometryThatPlacesNothing)
{
    const std::string bytes = test::bytesOf(counted<std::uint8_t>(60));
    const char* const degenerate = "space dimension: 3\n"
                                   "space directions: (1,0,0) (2,0,0) (0,0,1)\n";
    const char* const vanishing = "space dimension: 3\n"
                                  "space directions: (1,0,0) (0,0,0) (0,0,1)\n";
    for (const char* extra : {degenerate, vanishing, "spacings: 1 0 1\n", "spacings: 1 inf 1\n"}) {
        const auto volume = loadVolume(
            folder.file("bad.nrrd", test::nrrdHeader("uint8", "3 4 5", "raw", extra) + bytes));
        ASSERT_FALSE(volume) << extra;
        EXPECT_EQ(volume.error().code, core::ErrorCode::badData) << extra;
    }
}

TEST_F(DenseFiles, stopWhenAsked)
{
    std::stop_source source;
    source.request_stop();
    const auto volume = loadVolume(
        folder.file("a.nrrd", test::nrrdHeader("uint8", "3 4 5") + std::string(60, 'a')),
        {.stop = source.get_token()});
    ASSERT_FALSE(volume);
    EXPECT_EQ(volume.error().code, core::ErrorCode::interrupted);
}

} // namespace
} // namespace isofront::volume

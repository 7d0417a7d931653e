#include "GeoPlacement.h"
#include "support/FileBytes.h"
#include "support/Random.h"
#include "support/TemporaryFolder.h"

#include <isofront/elevation/LoadElevation.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace isofront::elevation {
namespace {

using core::ErrorCode;
using tests::bytesOf;
using tests::TiffPageBytes;

double heightAt(const LoadedElevation& loaded, double x, double y)
{
    const double z = 0;
    float value = 0;
    loaded.field->sample({{&x, 1}, {&y, 1}, {&z, 1}}, {&value, 1});
    return double(value);
}

/// The height of a post: columns from the west, rows from the north, as files have them.
double postAt(const LoadedElevation& loaded, int column, int row)
{
    const ElevationInfo& info = loaded.info;
    return heightAt(
        loaded,
        info.spacing.x * (column - 0.5 * (info.columns - 1)),
        info.spacing.y * (0.5 * (info.rows - 1) - row));
}

class ElevationFiles : public testing::Test {
protected:
    LoadedElevation
    load(const std::filesystem::path& path, const ElevationOptions& options = {}) const
    {
        auto loaded = loadElevation(path, options);
        EXPECT_TRUE(loaded) << loaded.error().message;
        return loaded ? std::move(*loaded) : LoadedElevation{};
    }
    void expectRefused(
        const std::filesystem::path& path,
        ErrorCode code,
        const std::string& part,
        const ElevationOptions& options = {}) const
    {
        const auto loaded = loadElevation(path, options);
        ASSERT_FALSE(loaded) << path;
        EXPECT_EQ(loaded.error().code, code) << loaded.error().message;
        EXPECT_NE(loaded.error().message.find(part), std::string::npos) << loaded.error().message;
        EXPECT_TRUE(loaded.error().message.starts_with(path.string())) << loaded.error().message;
        EXPECT_EQ(loaded.error().message.find('\n'), std::string::npos) << loaded.error().message;
    }
    tests::TemporaryFolder folder;
};

std::int16_t srtmHeight(int column, int row)
{
    return static_cast<std::int16_t>(500 + 2 * column - row + (column * 7 + row * 13) % 10);
}

std::string srtmTile()
{
    std::vector<std::int16_t> values;
    for (int row = 0; row < 1201; ++row)
        for (int column = 0; column < 1201; ++column)
            values.push_back(srtmHeight(column, row));
    values[5 * 1201 + 7] = -32768;
    values[6 * 1201 + 7] = -32768;
    return bytesOf(values, true);
}

TEST_F(ElevationFiles, ofSrtmLieWhereTheirNameSaysPlainAndGzipped)
{
    const std::string tile = srtmTile();
    for (const auto& [name, bytes] :
         {std::pair{"S33W070.hgt", tile}, std::pair{"s33w070.HGT.gz", tests::gzipped(tile)}}) {
        const LoadedElevation loaded = load(folder.file(name, bytes));
        ASSERT_TRUE(loaded.field);
        EXPECT_EQ(loaded.info.columns, 1201);
        EXPECT_EQ(loaded.info.voids, 2U);
        ASSERT_TRUE(loaded.info.centre);
        EXPECT_DOUBLE_EQ(loaded.info.centre->latitude, -32.5);
        EXPECT_DOUBLE_EQ(loaded.info.centre->longitude, -69.5);
        EXPECT_NEAR(loaded.info.spacing.y, 111320.0 / 1200, 1e-9);
        EXPECT_NEAR(
            loaded.info.spacing.x, 111320.0 / 1200 * std::cos(32.5 * std::numbers::pi / 180), 1e-9);
        for (const auto& [column, row] : {std::pair{0, 0}, {1200, 0}, {3, 1200}, {700, 411}})
            EXPECT_NEAR(postAt(loaded, column, row), srtmHeight(column, row), 1e-3);
        EXPECT_NEAR(postAt(loaded, 7, 5), srtmHeight(7, 5), 8); // filled
        EXPECT_EQ(loaded.info.notes.size(), 1U);
    }
    const LoadedElevation nameless = load(folder.file("tile.hgt", tile));
    EXPECT_FALSE(nameless.info.centre);
    EXPECT_EQ(nameless.info.notes.size(), 2U);
}

TEST(GeoPlacement, hasTheCosineOfEveryLatitude)
{
    for (double degrees = -90; degrees <= 90; degrees += 0.37)
        EXPECT_NEAR(cosineOfDegrees(degrees), std::cos(degrees * std::numbers::pi / 180), 1e-14);
}

TEST(GeoPlacement, readsCornersFromNamesAndNothingElse)
{
    const auto corner = cornerFromName("S07e123_more.hgt");
    ASSERT_TRUE(corner);
    EXPECT_EQ(corner->latitude, -7);
    EXPECT_EQ(corner->longitude, 123);
    for (const char* name :
         {"N4W072.hgt", "44N072W", "X44W072", "N44-072", "", "N99W072", "N44W999"})
        EXPECT_FALSE(cornerFromName(name)) << name;
}

template <typename T>
TiffPageBytes geoPage(const std::vector<T>& values, std::uint32_t width, bool bigEndian)
{
    TiffPageBytes page;
    page.width = width;
    page.height = static_cast<std::uint32_t>(values.size()) / width;
    page.bits = 8 * sizeof(T);
    page.format = std::is_floating_point_v<T> ? 3 : std::is_signed_v<T> ? 2 : 1;
    page.chunks = {bytesOf(values, bigEndian)};
    page.doubles = {{33550, {30, 40, 0}}, {33922, {0, 0, 0, 500, 600, 0}}};
    page.shorts = {{34735, {1, 1, 0, 1, 1024, 0, 1, 1}}};
    return page;
}

template <typename T>
class GeoTiffOf : public ElevationFiles {
};
using Types = testing::
    Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(GeoTiffOf, Types);

TYPED_TEST(GeoTiffOf, isReadInEitherByteOrderWithItsVoids)
{
    constexpr std::uint32_t kWidth = 12;
    std::vector<TypeParam> values;
    for (int i = 0; i < 96; ++i)
        values.push_back(static_cast<TypeParam>(i + 5));
    values[40] = TypeParam(120); // the value for no data
    for (const bool bigEndian : {false, true}) {
        TiffPageBytes page = geoPage(values, kWidth, bigEndian);
        page.texts = {{42113, " 120.0 "}};
        const LoadedElevation loaded =
            this->load(this->folder.file("a.tif", tests::tiffBytes({page}, bigEndian)));
        ASSERT_TRUE(loaded.field);
        EXPECT_EQ(loaded.info.voids, 1U);
        EXPECT_EQ(loaded.info.spacing, glm::dvec2(30, 40));
        EXPECT_EQ(loaded.info.lowest, 5);
        EXPECT_EQ(loaded.info.highest, 100);
        EXPECT_EQ(loaded.info.summit, glm::dvec2(165, -140)); // the last post, in the south-east
        for (int row = 0; row < 8; ++row)
            for (int column = 0; column < 12; ++column)
                EXPECT_NEAR(postAt(loaded, column, row), 5 + 12 * row + column, 0.02);
    }
}

TEST_F(ElevationFiles, ofGeoTiffTurnDegreesFeetAndMatricesIntoMetres)
{
    const std::vector<float> values(20 * 10, 3.5F);
    TiffPageBytes page = geoPage(values, 20, false);
    const auto loaded = [&] { return load(folder.file("a.tif", tests::tiffBytes({page}))); };

    page.doubles = {{33550, {0.01, 0.02, 0}}, {33922, {0, 0, 0, 7.0, 60.1, 0}}};
    page.shorts = {{34735, {1, 1, 0, 2, 1024, 0, 1, 2, 2054, 0, 1, 9102}}};
    const LoadedElevation degrees = loaded();
    ASSERT_TRUE(degrees.info.centre);
    EXPECT_NEAR(degrees.info.centre->latitude, 60, 1e-12);
    EXPECT_NEAR(degrees.info.centre->longitude, 7.1, 1e-12);
    EXPECT_NEAR(degrees.info.spacing.x, 0.01 * 111320 * 0.5, 1e-9);
    EXPECT_NEAR(degrees.info.spacing.y, 0.02 * 111320, 1e-9);

    page.shorts = {{34735, {1, 1, 0, 2, 1024, 0, 1, 2, 1025, 0, 1, 2}}}; // pixels are points
    EXPECT_NEAR(loaded().info.centre->latitude, 60.01, 1e-12);

    page.doubles = {{33550, {10, 20, 0}}, {33922, {0, 0, 0, 0, 0, 0}}};
    page.shorts = {{34735, {1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9002}}};
    EXPECT_NEAR(loaded().info.spacing.x, 3.048, 1e-12);

    page.doubles = {{34264, {25, 0, 0, 7, 0, -35, 0, 9, 0, 0, 0, 0, 0, 0, 0, 1}}};
    page.shorts = {{34735, {1, 1, 0, 1, 1024, 0, 1, 1}}};
    EXPECT_EQ(loaded().info.spacing, glm::dvec2(25, 35));

    const auto refused = [&](const std::string& part) {
        expectRefused(folder.file("b.tif", tests::tiffBytes({page})), ErrorCode::badData, part);
    };
    page.doubles = {{34264, {25, 3, 0, 7, 3, -35, 0, 9, 0, 0, 0, 0, 0, 0, 0, 1}}};
    refused("north up");
    page.doubles = {{33550, {10, -20, 0}}, {33922, {0, 0, 0, 0, 0, 0}}};
    refused("above 0");
    page.doubles = {
        {33550, {10, std::numeric_limits<double>::quiet_NaN(), 0}}, {33922, {0, 0, 0, 0, 0, 0}}};
    refused("above 0");
    page.doubles = {{33550, {10, 20, 0}}, {33922, {0, 0, 0, 0, 0, 0}}};
    page.shorts = {{34735, {1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9999}}};
    refused("9999");
    page.shorts = {{34735, {1, 1, 0, 1, 1024, 0, 1, 2}}};
    page.doubles = {{33550, {0.01, 0.02, 0}}, {33922, {0, 0, 0, 0, 90.2, 0}}};
    refused("latitude");

    page.doubles = {};
    page.shorts = {};
    expectRefused(folder.file("c.tif", tests::tiffBytes({page})), ErrorCode::usage, "--pixel-size");
    EXPECT_EQ(
        load(folder.path("c.tif"), {.pixelSize = glm::dvec2(2, 3)}).info.spacing, glm::dvec2(2, 3));
}

TEST_F(ElevationFiles, withoutAnyHeightOrTooSmallAreRefused)
{
    const auto file = [&](const TiffPageBytes& page) {
        return folder.file("a.tif", tests::tiffBytes({page}));
    };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    expectRefused(
        file(geoPage(std::vector<float>(16, kNan), 4, false)), ErrorCode::badData, "no landscape");
    expectRefused(file(geoPage(std::vector<float>(4, 1), 4, false)), ErrorCode::badData, "2 x 2");
    expectRefused(
        file(geoPage(std::vector<float>(4, 1e20F), 2, false)), ErrorCode::badData, "--no-data");
    TiffPageBytes page = geoPage(std::vector<float>(16, 1), 4, false);
    page.texts = {{42113, "none"}};
    expectRefused(file(page), ErrorCode::badData, "GDAL_NODATA");
    page.texts.clear();
    expectRefused(file(page), ErrorCode::resourceLimit, "limit", {.memoryLimit = 60});
    expectRefused(file(page), ErrorCode::usage, "--pixel-size", {.pixelSize = glm::dvec2(0, 1)});
    expectRefused(file(page), ErrorCode::usage, "--height-scale", {.heightScale = 0.0});
    std::stop_source stop;
    stop.request_stop();
    expectRefused(file(page), ErrorCode::interrupted, "stopped", {.stop = stop.get_token()});
}

TEST_F(ElevationFiles, ofPngTakeTheirScaleFromTheUser)
{
    std::vector<std::uint16_t> values(6 * 4);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint16_t>(1000 * i);
    values[9] = 65535;
    const auto path = folder.file("a.png", tests::greyPngBytes(6, 4, values));
    expectRefused(path, ErrorCode::usage, "--pixel-size");
    const LoadedElevation loaded =
        load(path, {.pixelSize = glm::dvec2(5, 6), .heightScale = 0.125, .noData = 65535});
    ASSERT_TRUE(loaded.field);
    EXPECT_EQ(loaded.info.voids, 1U);
    EXPECT_NEAR(postAt(loaded, 5, 3), 125 * 23, 1e-3);
    EXPECT_NEAR(postAt(loaded, 3, 1), 125 * 9, 1);
    const LoadedElevation plain = load(path, {.pixelSize = glm::dvec2(5, 6)});
    EXPECT_EQ(plain.info.notes.size(), 1U);
    EXPECT_NEAR(postAt(plain, 3, 1), 65535, 1e-3);
    // turned upside down: what was deep is high
    EXPECT_NEAR(
        postAt(load(path, {.pixelSize = glm::dvec2(5, 6), .heightScale = -1.0}), 5, 3),
        -23000,
        1e-3);
}

TEST_F(ElevationFiles, thatAreHostileAreRefused)
{
    for (const char* extension : {".hgt", ".hgt.gz", ".tif", ".TIFF", ".png"}) {
        expectRefused(
            folder.path(std::string("none") + extension), ErrorCode::inputOutput, "no such");
        std::filesystem::create_directory(folder.path(std::string("folder") + extension));
        expectRefused(
            folder.path(std::string("folder") + extension), ErrorCode::inputOutput, "regular");
        expectRefused(
            folder.file(std::string("empty") + extension, ""), ErrorCode::badData, "empty");
        for (const std::string& bytes :
             {std::string("N"), std::string(1000, 'a') + "\n", std::string(100'000, '\0')})
            expectRefused(
                folder.file(std::string("text") + extension, bytes), ErrorCode::badData, "");
    }
    expectRefused(folder.file("a.asc", "x"), ErrorCode::usage, ".hgt, .hgt.gz, .tif, .tiff");
    const std::string tile = srtmTile();
    expectRefused(
        folder.file("short.hgt", tile.substr(0, tile.size() - 1)), ErrorCode::badData, "2884801");
    expectRefused(folder.file("long.hgt", tile + "x"), ErrorCode::badData, "2884803");
    const std::string packed = tests::gzipped(tile);
    expectRefused(
        folder.file("cut.hgt.gz", packed.substr(0, packed.size() / 2)), ErrorCode::badData, "cut");
    // 100 MB of zeros in 100 kB
    expectRefused(
        folder.file("bomb.hgt.gz", tests::gzipped(std::string(100'000'000, '\0'))),
        ErrorCode::badData,
        "more than the 25934402");
    expectRefused(
        folder.file("small.hgt", tile),
        ErrorCode::resourceLimit,
        "limit",
        {.memoryLimit = 3'000'000});
    // the file itself is larger
    for (const auto& [name, bytes] :
         {std::pair{"tiny.hgt", tile}, std::pair{"tiny.hgt.gz", packed}})
        expectRefused(
            folder.file(name, bytes),
            ErrorCode::resourceLimit,
            "1000000",
            {.memoryLimit = 1'000'000});
}

TEST_F(ElevationFiles, withRandomDamageNeverCrash)
{
    auto random = tests::random(21);
    const std::string tiff = tests::tiffBytes({geoPage(std::vector<float>(64, 9), 8, true)}, true);
    const std::string png = tests::greyPngBytes(8, 8, std::vector<std::uint16_t>(64, 77));
    for (int i = 0; i < 200 * tests::intensity(); ++i)
        for (const auto& [name, good] : {std::pair{"r.tif", tiff}, std::pair{"r.png", png}}) {
            std::string bad = good;
            for (std::size_t change = 0; change < 1 + random() % 3; ++change)
                bad[random() % bad.size()] = static_cast<char>(random());
            const auto loaded = loadElevation(
                folder.file(name, bad), {.memoryLimit = 1U << 18U, .pixelSize = glm::dvec2(3, 4)});
            ASSERT_TRUE(loaded || !loaded.error().message.empty());
            if (loaded) {
                EXPECT_TRUE(std::isfinite(heightAt(*loaded, 1, 2)));
            }
        }
}

TEST_F(ElevationFiles, shippedAreAsTheirDocumentationSays)
{
    const LoadedElevation loaded = load(ISOFRONT_DATA "/elevation/mount-washington.tif");
    ASSERT_TRUE(loaded.field);
    EXPECT_EQ(loaded.info.columns, 1025);
    EXPECT_EQ(loaded.info.rows, 1025);
    EXPECT_EQ(loaded.info.lowest, 145);
    EXPECT_EQ(loaded.info.highest, 1908);
    EXPECT_EQ(loaded.info.voids, 0U);
    ASSERT_TRUE(loaded.info.centre);
    EXPECT_NEAR(loaded.info.centre->latitude, 44.5, 1e-9);
    // Mount Washington is 44.2706 N, 71.3033 W
    EXPECT_NEAR(44.5 + loaded.info.summit.y / 111320, 44.2706, 0.002);
    EXPECT_NEAR(
        -71.5 + loaded.info.summit.x / (111320 * std::cos(44.5 * std::numbers::pi / 180)),
        -71.3033,
        0.002);
}

TEST_F(ElevationFiles, realTilesAreCompleteAndTheCropIsPartOfItsTile)
{
    const char* data = std::getenv("ISOFRONT_TEST_DATA");
    if (data == nullptr)
        GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder";
    const std::filesystem::path dem = std::filesystem::path(data) / "dem";
    const LoadedElevation tile = load(dem / "N44W072.hgt.gz");
    const LoadedElevation crop = load(ISOFRONT_DATA "/elevation/mount-washington.tif");
    ASSERT_TRUE(tile.field && crop.field);
    EXPECT_EQ(tile.info.voids, 0U);
    for (int i = 0; i < 1025; i += 41)
        for (int j = 0; j < 1025; j += 41)
            ASSERT_NEAR(postAt(crop, i, j), postAt(tile, i + 88, j + 88), 1e-3);
    const LoadedElevation steep = load(dem / "N42E001.hgt.gz");
    EXPECT_EQ(steep.info.voids, 7652U);
    EXPECT_EQ(steep.info.lowest, 349);
    EXPECT_EQ(steep.info.highest, 3100);
}

} // namespace
} // namespace isofront::elevation

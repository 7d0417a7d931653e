#include "support/FileBytes.h"
#include "support/NumberTypes.h"
#include "support/Random.h"
#include "support/TemporaryFolder.h"

#include <isofront/raster/FileBytes.h>
#include <isofront/raster/PngFile.h>
#include <isofront/raster/TiffFile.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace isofront::raster {
namespace {

using core::ErrorCode;
using tests::bytesOf;
using tests::TiffPageBytes;

constexpr std::uint64_t kLimit = std::uint64_t{1} << 24U;

template <typename T>
std::vector<T> readAll(const TiffFile& file, std::size_t page)
{
    std::vector<T> values(file.pages()[page].bytes() / sizeof(T));
    const auto read = file.read(page, std::as_writable_bytes(std::span(values)));
    EXPECT_TRUE(read) << read.error().message;
    return values;
}

/// Values from one end of a type to the other.
template <typename T>
std::vector<T> ramp(std::size_t count)
{
    std::vector<T> values(count);
    for (std::size_t i = 0; i < count; ++i)
        values[i] = static_cast<T>(i * 37);
    values.front() = std::numeric_limits<T>::lowest();
    values.back() = std::numeric_limits<T>::max();
    return values;
}

template <typename T>
class TiffOf : public testing::Test {
protected:
    static constexpr std::uint16_t kFormat = std::is_floating_point_v<T> ? 3
                                             : std::is_signed_v<T>       ? 2
                                                                         : 1;
    tests::TemporaryFolder folder;
};

TYPED_TEST_SUITE(TiffOf, tests::SampleTypes);

TYPED_TEST(TiffOf, isReadInStripsAndTilesPackedAndPlainInBothByteOrders)
{
    constexpr std::uint32_t kWidth = 37;
    constexpr std::uint32_t kHeight = 21;
    constexpr std::uint32_t kTile = 16;
    const auto values = ramp<TypeParam>(kWidth * kHeight);
    for (const bool bigEndian : {false, true})
        for (const bool packed : {false, true})
            for (const bool tiled : {false, true}) {
                TiffPageBytes page;
                page.width = kWidth;
                page.height = kHeight;
                page.bits = 8 * sizeof(TypeParam);
                page.format = TestFixture::kFormat;
                page.compression = packed ? 8 : 1;
                std::vector<std::vector<TypeParam>> chunks;
                if (tiled) {
                    page.tileWidth = page.tileHeight = kTile;
                    for (std::uint32_t y = 0; y < kHeight; y += kTile)
                        for (std::uint32_t x = 0; x < kWidth; x += kTile) {
                            std::vector<TypeParam> tile(kTile * kTile);
                            for (std::uint32_t row = 0; row < std::min(kTile, kHeight - y); ++row)
                                for (std::uint32_t i = 0; i < std::min(kTile, kWidth - x); ++i)
                                    tile[row * kTile + i] = values[(y + row) * kWidth + x + i];
                            chunks.push_back(tile);
                        }
                } else {
                    page.rowsPerStrip = 5;
                    for (std::uint32_t y = 0; y < kHeight; y += 5)
                        chunks.emplace_back(
                            values.begin() + y * kWidth,
                            values.begin() + std::min(kHeight, y + 5) * kWidth);
                }
                for (const auto& chunk : chunks) {
                    const std::string bytes = bytesOf(chunk, bigEndian);
                    page.chunks.push_back(packed ? tests::deflated(bytes) : bytes);
                }
                const auto file = TiffFile::open(
                    this->folder.file("a.tif", tests::tiffBytes({page}, bigEndian)), kLimit);
                ASSERT_TRUE(file) << file.error().message;
                ASSERT_EQ(file->pages().size(), 1U);
                EXPECT_EQ(bytesOf(file->pages()[0].type), sizeof(TypeParam));
                EXPECT_EQ(readAll<TypeParam>(*file, 0), values) << bigEndian << packed << tiled;
            }
}

TiffPageBytes greyPage(std::uint32_t width, std::uint32_t height, char value)
{
    TiffPageBytes page;
    page.width = width;
    page.height = height;
    page.chunks = {std::string(std::size_t{width} * height, value)};
    return page;
}

class RasterFiles : public testing::Test {
protected:
    void expectRefused(
        const std::string& bytes,
        ErrorCode code,
        const std::string& part,
        std::uint64_t limit = kLimit)
    {
        const auto file = TiffFile::open(folder.file("bad.tif", bytes), limit);
        ASSERT_FALSE(file) << "not refused: " << part;
        EXPECT_EQ(file.error().code, code) << file.error().message;
        EXPECT_NE(file.error().message.find(part), std::string::npos) << file.error().message;
    }
    tests::TemporaryFolder folder;
};

TEST_F(RasterFiles, ofTiffKeepTheOrderOfTheirPagesAndLeaveOutOverviews)
{
    TiffPageBytes overview = greyPage(2, 2, 9);
    overview.subfileType = 1;
    const auto file = TiffFile::open(
        folder.file("a.tif", tests::tiffBytes({greyPage(3, 2, 1), overview, greyPage(4, 5, 2)})),
        kLimit);
    ASSERT_TRUE(file) << file.error().message;
    ASSERT_EQ(file->pages().size(), 2U);
    EXPECT_EQ(file->pages()[1].width, 4);
    EXPECT_EQ(file->pages()[1].height, 5);
    EXPECT_EQ(readAll<std::uint8_t>(*file, 0), std::vector<std::uint8_t>(6, 1));
    EXPECT_EQ(readAll<std::uint8_t>(*file, 1), std::vector<std::uint8_t>(20, 2));
}

TEST_F(RasterFiles, ofGeoTiffGiveTheirTagsInBothByteOrders)
{
    for (const bool bigEndian : {false, true}) {
        TiffPageBytes page = greyPage(3, 2, 1);
        page.doubles = {{33550, {30, 40, 0}}, {33922, {0, 0, 0, 500, 600, 0}}};
        page.shorts = {{34735, {1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9002}}};
        page.texts = {{42113, "-9999"}, {270, "a description"}};
        const auto file =
            TiffFile::open(folder.file("a.tif", tests::tiffBytes({page}, bigEndian)), kLimit);
        ASSERT_TRUE(file) << file.error().message;
        const TiffPage& read = file->pages()[0];
        EXPECT_EQ(read.geo.pixelScale, (std::vector<double>{30, 40, 0}));
        EXPECT_EQ(read.geo.tiepoints, (std::vector<double>{0, 0, 0, 500, 600, 0}));
        EXPECT_EQ(read.geo.key(1024), 1);
        EXPECT_EQ(read.geo.key(3076), 9002);
        EXPECT_EQ(read.geo.key(4099), std::nullopt);
        EXPECT_EQ(read.geo.noData, "-9999");
        EXPECT_EQ(read.description, "a description");
    }
}

TEST_F(RasterFiles, ofTiffThatLieOrAreOfAnotherKindAreRefused)
{
    TiffPageBytes page = greyPage(4, 4, 1);
    page.width = 1'000'000;
    page.height = 1'000'000;
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "promises 1000000 x 1000000");
    page.compression = 8;
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "promises 1000000 x 1000000");
    page.compression = 5;
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "promises 1000000 x 1000000");
    page.compression = 50000; // ZSTD: nothing is known of how much it packs
    expectRefused(tests::tiffBytes({page}), ErrorCode::resourceLimit, "memory limit");
    expectRefused(
        tests::tiffBytes({greyPage(64, 64, 1)}), ErrorCode::resourceLimit, "memory limit", 4095);
    page = greyPage(0, 4, 1);
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "");
    page = greyPage(2, 2, 1);
    page.samplesPerPixel = 3;
    page.photometric = 2;
    page.chunks = {std::string(12, 'x')};
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "3 samples a pixel");
    page = greyPage(8, 2, 1);
    page.bits = 4;
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "4 bits");
    page = greyPage(2, 2, 1);
    page.photometric = 3;
    page.shorts = {{320, std::vector<std::uint16_t>(3 * 256)}}; // the colours
    expectRefused(tests::tiffBytes({page}), ErrorCode::badData, "palette");
    expectRefused("", ErrorCode::badData, "empty");
    expectRefused("II*", ErrorCode::badData, "TIFF");
    expectRefused(std::string(1000, 'a'), ErrorCode::badData, "TIFF");
    const auto missing = TiffFile::open(folder.path("none.tif"), kLimit);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::inputOutput);
}

TEST_F(RasterFiles, ofTiffCutShortAreBadDataAtEveryLength)
{
    TiffPageBytes page = greyPage(16, 16, 7);
    page.compression = 8;
    page.chunks = {tests::deflated(page.chunks[0])};
    const std::string good = tests::tiffBytes({page});
    for (std::size_t length = 1; length < good.size(); ++length) {
        const auto path = folder.file("cut.tif", good.substr(0, length));
        const auto file = TiffFile::open(path, kLimit);
        if (!file) {
            EXPECT_EQ(file.error().code, ErrorCode::badData) << length;
            continue;
        }
        std::vector<std::byte> bytes(file->pages()[0].bytes());
        // the last bytes of the file are the empty link to a next directory
        const auto read = file->read(0, bytes);
        EXPECT_TRUE(!read || length + 4 >= good.size()) << length;
    }
}

TEST_F(RasterFiles, withRandomDamageNeverCrashAndNeverTakeMoreThanTheLimit)
{
    auto random = tests::random(11);
    TiffPageBytes page = greyPage(24, 18, 7);
    page.doubles = {{33550, {30, 40, 0}}, {33922, {0, 0, 0, 500, 600, 0}}};
    page.shorts = {{34735, {1, 1, 0, 1, 1024, 0, 1, 1}}};
    page.texts = {{42113, "-9999"}};
    const std::string tiff = tests::tiffBytes({page, page});
    const std::string png = tests::greyPngBytes(16, 16, std::vector<std::uint16_t>(256, 1000));
    for (int i = 0; i < 300 * tests::intensity(); ++i) {
        for (const bool isTiff : {true, false}) {
            std::string bad = isTiff ? tiff : png;
            for (std::size_t change = 0; change < 1 + random() % 3; ++change)
                bad[random() % bad.size()] = static_cast<char>(random());
            if (isTiff) {
                const auto file = TiffFile::open(folder.file("r.tif", bad), 1U << 16U);
                if (!file)
                    continue;
                for (std::size_t p = 0; p < file->pages().size(); ++p) {
                    ASSERT_LE(file->pages()[p].bytes(), 1U << 16U);
                    std::vector<std::byte> bytes(file->pages()[p].bytes());
                    static_cast<void>(file->read(p, bytes));
                }
            } else {
                const auto picture = readGreyPng(folder.file("r.png", bad), 1U << 16U);
                ASSERT_TRUE(!picture || picture->values.size() <= 1U << 15U);
            }
        }
    }
}

TEST_F(RasterFiles, ofPngGiveTheNumbersOfTheFile)
{
    std::vector<std::uint16_t> values(7 * 5);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<std::uint16_t>(i * 1873);
    const auto deep = readGreyPng(folder.file("a.png", tests::greyPngBytes(7, 5, values)), kLimit);
    ASSERT_TRUE(deep) << deep.error().message;
    EXPECT_EQ(deep->bits, 16);
    EXPECT_EQ(deep->width, 7);
    EXPECT_EQ(deep->values, values);
    for (std::uint16_t& value : values)
        value &= 0xffU;
    const auto flat =
        readGreyPng(folder.file("b.png", tests::greyPngBytes(7, 5, values, 8)), kLimit);
    ASSERT_TRUE(flat) << flat.error().message;
    EXPECT_EQ(flat->bits, 8);
    EXPECT_EQ(flat->values, values);
}

TEST_F(RasterFiles, ofPngThatLieOrHaveColoursAreRefused)
{
    const auto refused = [&](const std::string& bytes, ErrorCode code, const std::string& part) {
        const auto picture = readGreyPng(folder.file("bad.png", bytes), 1U << 20U);
        ASSERT_FALSE(picture);
        EXPECT_EQ(picture.error().code, code) << picture.error().message;
        EXPECT_NE(picture.error().message.find(part), std::string::npos) << picture.error().message;
    };
    refused(tests::greyPngBytes(4, 4, {}, 8, 2), ErrorCode::badData, "grey");
    std::string lying = tests::greyPngBytes(4, 4, {});
    lying[18] = '\x7f'; // a width of 32516
    lying[22] = '\x7f';
    refused(lying, ErrorCode::badData, "");
    refused(tests::greyPngBytes(1000, 1000, {}), ErrorCode::resourceLimit, "limit");
    refused("", ErrorCode::badData, "empty");
    refused("hello\n", ErrorCode::badData, "PNG");
    const std::string good = tests::greyPngBytes(9, 9, std::vector<std::uint16_t>(81, 500));
    for (std::size_t length = 1; length + 12 < good.size(); ++length)
        refused(good.substr(0, length), ErrorCode::badData, "");
}

TEST_F(RasterFiles, gzippedAreUnpackedAndWhatIsCutShortIsTold)
{
    std::string text;
    for (int i = 0; i < 100'000; ++i)
        text += static_cast<char>(static_cast<unsigned>(i) * static_cast<unsigned>(i) >> 3);
    const auto readBack = [&](const std::string& bytes, std::uint64_t most) {
        return readFileBytes(folder.file("f", bytes), most);
    };
    for (const std::string& bytes : {text, tests::gzipped(text)}) {
        const auto read = readBack(bytes, text.size());
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_EQ(read->size(), text.size());
        EXPECT_EQ(std::memcmp(read->data(), text.data(), text.size()), 0);
        EXPECT_FALSE(readBack(bytes, text.size() - 1));
    }
    const std::string packed = tests::gzipped(text);
    for (const std::size_t part : {packed.size() - 1, packed.size() / 2, std::size_t{20}}) {
        const auto read = readBack(packed.substr(0, part), text.size());
        ASSERT_FALSE(read) << part;
        EXPECT_EQ(read.error().code, ErrorCode::badData);
    }
    std::string damaged = packed;
    damaged[packed.size() / 2] = static_cast<char>(damaged[packed.size() / 2] + 1);
    EXPECT_FALSE(readBack(damaged, text.size()));
}

} // namespace
} // namespace isofront::raster

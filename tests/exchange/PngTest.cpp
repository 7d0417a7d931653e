#include "ExchangeFixture.h"

#include <isofront/exchange/Png.h>

#include <png.h>

#include <random>

namespace isofront::exchange::test {

namespace {

class PngTest : public ExchangeTest {};

core::Image randomImage(unsigned seed, int width, int height, bool opaque)
{
    std::mt19937 random(seed);
    core::Image image{width, height, {}};
    for (int i = 0; i < width * height; ++i)
        for (int channel = 0; channel < 4; ++channel)
            image.rgba.push_back(
                channel == 3 && opaque ? 255 : static_cast<std::uint8_t>(random()));
    return image;
}

} // namespace

TEST_F(PngTest, readsBackEveryByteThatItWrote)
{
    const std::pair<int, int> sizes[] = {{1, 1}, {3, 2}, {1, 500}, {640, 1}, {255, 257}};
    unsigned seed = 0;
    for (const auto& [width, height] : sizes)
        for (const bool opaque : {true, false}) {
            const core::Image image = randomImage(++seed, width, height, opaque);
            const auto bytes = writePng(image, path("a.png"));
            ASSERT_TRUE(bytes) << bytes.error().message;
            EXPECT_EQ(*bytes, std::filesystem::file_size(path("a.png")));
            const auto read = readPng(path("a.png"));
            ASSERT_TRUE(read) << read.error().message;
            EXPECT_EQ(read->width, width);
            EXPECT_EQ(read->height, height);
            EXPECT_EQ(read->rgba, image.rgba);
            // Byte 25 of a PNG is its colour type: 2 without, 6 with opacity.
            EXPECT_EQ(contentOf(path("a.png")).at(25), opaque ? 2 : 6);
        }
}

TEST_F(PngTest, readsGreyOfSixteenBits)
{
    std::vector<png_uint_16> grey = {0, 0xFFFF};
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = 2;
    image.height = 1;
    image.format = PNG_FORMAT_LINEAR_Y;
    ASSERT_NE(
        png_image_write_to_file(&image, path("a.png").c_str(), 0, grey.data(), 0, nullptr), 0);
    const auto read = readPng(path("a.png"));
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->rgba, (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 255, 255}));
}

TEST_F(PngTest, refusesImagesWhoseBytesDoNotFitTheirSize)
{
    for (const core::Image& image :
         {core::Image{},
          core::Image{2, 2, std::vector<std::uint8_t>(15)},
          core::Image{-1, 2, {}},
          core::Image{0, 5, {}}}) {
        const auto bytes = writePng(image, path("a.png"));
        ASSERT_FALSE(bytes);
        EXPECT_EQ(bytes.error().code, core::ErrorCode::usage);
    }
    EXPECT_TRUE(names().empty());
}

TEST_F(PngTest, failsWithASentenceWhereAFileIsMissingOrCannotBe)
{
    EXPECT_EQ(readPng(path("none.png")).error().code, core::ErrorCode::inputOutput);
    EXPECT_EQ(readPng(folder()).error().code, core::ErrorCode::inputOutput);
    EXPECT_EQ(
        writePng(randomImage(1, 2, 2, true), path("none") / "a.png").error().code,
        core::ErrorCode::inputOutput);
}

TEST_F(PngTest, survivesDamageAnywhereInTheFile)
{
    ASSERT_TRUE(writePng(randomImage(9, 40, 30, false), path("a.png")));
    const std::string whole = contentOf(path("a.png"));
    std::mt19937 random(11);
    int refused = 0;
    for (int i = 0; i < 400; ++i) {
        std::string damaged = whole;
        if (i % 2 == 0)
            damaged.resize(random() % whole.size());
        else
            for (unsigned flips = 0; flips <= random() % 4; ++flips)
                damaged[random() % damaged.size()] = static_cast<char>(random());
        setContent(path("a.png"), damaged);
        const auto read = readPng(path("a.png"));
        if (!read) {
            ++refused;
            EXPECT_NE(read.error().code, core::ErrorCode::inputOutput);
        } else
            EXPECT_EQ(
                read->rgba.size(),
                4 * static_cast<std::size_t>(read->width) * static_cast<std::size_t>(read->height));
    }
    EXPECT_GT(refused, 300);
}

TEST_F(PngTest, refusesAPictureThatClaimsToBeHuge)
{
    ASSERT_TRUE(writePng(randomImage(9, 4, 3, true), path("a.png")));
    std::string bytes = contentOf(path("a.png"));
    // Width and height lie at 16 and 20, their check sum at 29.
    for (const std::size_t at : {17U, 21U})
        bytes[at] = 1; // + 65536 pixels
    unsigned long sum = 0xFFFFFFFFUL;
    for (std::size_t i = 12; i < 29; ++i) {
        sum ^= static_cast<unsigned char>(bytes[i]);
        for (int bit = 0; bit < 8; ++bit)
            sum = (sum & 1U) != 0 ? (sum >> 1U) ^ 0xEDB88320UL : sum >> 1U;
    }
    sum ^= 0xFFFFFFFFUL;
    for (std::size_t i = 0; i < 4; ++i)
        bytes[29 + i] = static_cast<char>(sum >> (24 - 8 * i));
    setContent(path("a.png"), bytes);
    const auto read = readPng(path("a.png"));
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, core::ErrorCode::resourceLimit) << read.error().message;
}

} // namespace isofront::exchange::test

#include <isofront/exchange/ContactSheet.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace isofront::exchange::test {

namespace {

core::Image flat(int width, int height, std::array<std::uint8_t, 4> colour)
{
    core::Image image{width, height, {}};
    image.rgba.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
        image.rgba[i] = colour[i % 4];
    return image;
}

std::array<std::uint8_t, 4> at(const core::Image& image, int x, int y)
{
    const std::uint8_t* pixel = image.pixel(x, y);
    return {pixel[0], pixel[1], pixel[2], pixel[3]};
}

double linear(double byte)
{
    const double value = byte / 255;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

} // namespace

TEST(Resampled, keepsAFlatColourAtAnySize)
{
    const core::Image image = flat(37, 23, {200, 10, 99, 255});
    for (const auto& [width, height] :
         {std::pair{1, 1}, {5, 7}, {36, 22}, {37, 23}, {80, 61}, {1, 100}}) {
        const core::Image small = resampled(image, width, height);
        EXPECT_EQ(small.rgba, flat(width, height, {200, 10, 99, 255}).rgba);
    }
}

TEST(Resampled, keepsAnImageAtItsOwnSize)
{
    std::mt19937 random(3);
    core::Image image = flat(19, 11, {0, 0, 0, 255});
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3)
            image.rgba[i] = static_cast<std::uint8_t>(random());
    EXPECT_EQ(resampled(image, 19, 11).rgba, image.rgba);
}

TEST(Resampled, averagesLightNotBytes)
{
    core::Image board = flat(8, 8, {0, 0, 0, 255});
    for (int y = 0; y < 8; ++y)
        for (int x = y % 2; x < 8; x += 2)
            std::fill_n(board.rgba.begin() + (board.pixel(x, y) - board.rgba.data()), 3, 255);
    // Half the light of white is the byte 188 of sRGB.
    EXPECT_EQ(resampled(board, 4, 4).rgba, flat(4, 4, {188, 188, 188, 255}).rgba);
}

TEST(Resampled, keepsTheMeanLightToWithinRounding)
{
    std::mt19937 random(5);
    core::Image image = flat(63, 45, {0, 0, 0, 255});
    double light = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        image.rgba[i] = static_cast<std::uint8_t>(random());
        light += linear(image.rgba[i]) / (63 * 45);
    }
    const core::Image small = resampled(image, 10, 8);
    double smallLight = 0;
    for (std::size_t i = 0; i < small.rgba.size(); i += 4)
        smallLight += linear(small.rgba[i]) / 80;
    EXPECT_NEAR(smallLight, light, 0.002);
}

TEST(Resampled, doesNotLetTransparentPixelsColourOthers)
{
    const core::Image image{2, 1, {255, 0, 0, 0, 0, 255, 0, 255}};
    EXPECT_EQ(at(resampled(image, 1, 1), 0, 0), (std::array<std::uint8_t, 4>{0, 255, 0, 128}));
}

TEST(ContactSheet, laysPicturesOutRowByRow)
{
    const std::vector<core::Image> images = {
        flat(160, 90, {255, 0, 0, 255}),
        flat(160, 90, {0, 255, 0, 255}),
        flat(160, 90, {0, 0, 255, 255})};
    const core::Image sheet = contactSheet(images, 2, 80);
    EXPECT_EQ(sheet.width, 2 * 80 + 3 * 4);
    EXPECT_EQ(sheet.height, 2 * 45 + 3 * 4);
    EXPECT_EQ(at(sheet, 4, 4), (std::array<std::uint8_t, 4>{255, 0, 0, 255}));
    EXPECT_EQ(at(sheet, 88 + 79, 4 + 44), (std::array<std::uint8_t, 4>{0, 255, 0, 255}));
    EXPECT_EQ(at(sheet, 4, 4 + 45 + 4), (std::array<std::uint8_t, 4>{0, 0, 255, 255}));
    const auto margin = at(sheet, 0, 0);
    EXPECT_EQ(at(sheet, 85, 20), margin);
    EXPECT_EQ(at(sheet, 120, 70), margin) << "the place without a picture";
    EXPECT_EQ(margin[3], 255);
}

TEST(ContactSheet, fitsPicturesOfOtherShapesWhole)
{
    const std::vector<core::Image> images = {
        flat(100, 100, {9, 9, 9, 255}),
        flat(10, 200, {255, 0, 0, 255}),
        flat(200, 10, {0, 255, 0, 255})};
    const core::Image sheet = contactSheet(images, 9, 40);
    EXPECT_EQ(sheet.width, 3 * 40 + 4 * 4);
    EXPECT_EQ(sheet.height, 48);
    EXPECT_EQ(at(sheet, 48 + 20, 4), (std::array<std::uint8_t, 4>{255, 0, 0, 255}));
    EXPECT_EQ(at(sheet, 48 + 4, 24), at(sheet, 0, 0));
    EXPECT_EQ(at(sheet, 92, 24), (std::array<std::uint8_t, 4>{0, 255, 0, 255}));
    EXPECT_EQ(at(sheet, 92, 10), at(sheet, 0, 0));
}

TEST(ContactSheet, isEmptyWithoutPictures)
{
    EXPECT_EQ(contactSheet({}, 4, 100).width, 0);
}

} // namespace isofront::exchange::test

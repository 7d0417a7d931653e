#include "report/Popping.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace isofront::cli {
namespace {

core::Image grey(int width, int height, std::uint8_t value)
{
    core::Image image{.width = width, .height = height, .rgba = {}};
    image.rgba.assign(static_cast<std::size_t>(4 * width * height), value);
    return image;
}

std::uint8_t& at(core::Image& image, int x, int y, int channel)
{
    return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x) + channel)];
}

TEST(Popping, isNoneBetweenPicturesThatAreTheSame)
{
    std::mt19937 random(5);
    core::Image image = grey(37, 21, 0);
    for (std::uint8_t& byte : image.rgba)
        byte = static_cast<std::uint8_t>(random() & 255U);
    const Popping popping = poppingBetween(image, image);
    EXPECT_EQ(popping.largest, 0.0);
    EXPECT_EQ(popping.mean, 0.0);
    EXPECT_EQ(poppingBetween({}, {}).mean, 0.0);
}

TEST(Popping, countsAChangeByItsStrengthAndItsShareOfASquare)
{
    const core::Image before = grey(16, 8, 100);
    for (int pixels = 1; pixels <= 64; ++pixels) {
        core::Image after = before;
        for (int i = 0; i < pixels; ++i)
            at(after, i % 8, i / 8, 1) = 40; // less green
        const Popping popping = poppingBetween(before, after);
        EXPECT_DOUBLE_EQ(popping.largest, 60.0 * pixels / 64);
        EXPECT_DOUBLE_EQ(popping.mean, 30.0 * pixels / 64);
        EXPECT_DOUBLE_EQ(poppingBetween(after, before).largest, popping.largest);
    }
}

TEST(Popping, takesWhatIsLeftAtTheBorderForASquare)
{
    const core::Image before = grey(10, 9, 7);
    core::Image after = before;
    at(after, 9, 8, 0) = 255;
    const Popping popping = poppingBetween(before, after);
    EXPECT_DOUBLE_EQ(popping.largest, 248.0 / 2);
    EXPECT_DOUBLE_EQ(popping.mean, 124.0 / 4);
}

} // namespace
} // namespace isofront::cli

#include <isofront/core/Powers.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isofront::core {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();

TEST(Powers, areThoseOfTwo)
{
    for (int n = -1000; n <= 1000; ++n) {
        const long double third = std::exp2(static_cast<long double>(n) / 3);
        const long double eighth = std::exp2(static_cast<long double>(n) / 8);
        EXPECT_LE(std::abs(twoToThirds(n) / third - 1), 0.51L * kUlp) << n;
        EXPECT_LE(std::abs(twoToEighths(n) / eighth - 1), 0.51L * kUlp) << n;
    }
    EXPECT_EQ(twoToThirds(0), 1);
    EXPECT_EQ(twoToThirds(-9), 0.125);
    EXPECT_EQ(twoToEighths(24), 8);
}

TEST(Powers, ofAnyBaseAreProducts)
{
    EXPECT_EQ(wholePower(0.3, 0), 1);
    EXPECT_EQ(wholePower(0.3, 1), 0.3);
    EXPECT_EQ(wholePower(-3, 3), -27);
    EXPECT_EQ(wholePower(0, 5), 0);
    // Every product is rounded once, and what a square has lost is squared in turn.
    for (unsigned n = 0; n <= 92; ++n) {
        const long double exact =
            std::pow(static_cast<long double>(0.79), static_cast<long double>(n));
        EXPECT_LE(std::abs(wholePower(0.79, n) / exact - 1), (1 + n) * kUlp) << n;
    }
}

TEST(Powers, haveCubeRoots)
{
    for (int n = -300; n <= 300; ++n) {
        const double value = (1 + 0.37 * (n & 7)) * std::pow(10.0, n);
        EXPECT_NEAR(cubeRoot(value) / std::cbrt(value), 1, 4 * kUlp) << value;
    }
    for (const double whole : {1.0, 8.0, 27.0, 0.125, 1e9})
        EXPECT_NEAR(std::pow(cubeRoot(whole), 3) / whole, 1, 8 * kUlp);
}

} // namespace
} // namespace isofront::core

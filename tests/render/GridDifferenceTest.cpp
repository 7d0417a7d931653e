#include "shared/gridDifference.h"

#include <isofront/hierarchy/LatticePoint.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isofront {
namespace {

std::uint32_t lowWord(std::int64_t value)
{
    return static_cast<std::uint32_t>(value);
}

std::uint32_t highWord(std::int64_t value)
{
    return static_cast<std::uint32_t>(value >> 32);
}

float difference(
    std::uint32_t low, std::uint32_t position, std::uint32_t exponent, std::int64_t eye)
{
    return shared::gridDifference(low, position, exponent, lowWord(eye), highWord(eye));
}

std::int64_t
exactDifference(std::uint32_t low, std::uint32_t position, std::uint32_t exponent, std::int64_t eye)
{
    return (std::int64_t{low} << 15) + (std::int64_t{position} << exponent) - eye;
}

/// The float form of a difference as the contract defines it.
float asFloat(std::int64_t value)
{
    const auto magnitude =
        value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
    const float sum = static_cast<float>(magnitude >> 32U) * 4294967296.0F +
                      static_cast<float>(static_cast<std::uint32_t>(magnitude));
    return value < 0 ? -sum : sum;
}

TEST(GridDifference, equalsSixtyFourBitArithmetic)
{
    std::mt19937_64 random(11);
    for (int i = 0; i < 200'000; ++i) {
        const auto low = static_cast<std::uint32_t>(random() % (hierarchy::kLatticeEdge + 1ULL));
        const auto position = static_cast<std::uint32_t>(random() % 32769);
        const auto exponent = static_cast<std::uint32_t>(1 + random() % 32);
        // Eyes near the vertex, in the domain, and far outside of it.
        const std::int64_t vertex = exactDifference(low, position, exponent, 0);
        const int spread = static_cast<int>(random() % 62);
        const auto offset = static_cast<std::int64_t>(random() >> 1U) >> (62 - spread);
        const std::int64_t eye =
            (random() % 2 == 0 ? vertex / 2 : vertex) + (random() % 2 == 0 ? offset : -offset) / 2;
        const std::int64_t exact = exactDifference(low, position, exponent, eye);
        const float result = difference(low, position, exponent, eye);
        ASSERT_EQ(result, asFloat(exact));
        ASSERT_NEAR(
            static_cast<double>(result),
            static_cast<double>(exact),
            std::ldexp(std::abs(static_cast<double>(exact)), -22));
    }
}

TEST(GridDifference, holdsAtTheLimits)
{
    constexpr std::int64_t kFar = std::int64_t{1} << 62;
    for (const std::uint32_t exponent : {1U, 17U, 31U, 32U}) {
        for (const std::uint32_t position : {0U, 1U, 32767U, 32768U}) {
            for (const std::uint32_t low : {0U, 1U, 0x7fffffffU, 0x80000000U}) {
                for (const std::int64_t eye :
                     {std::int64_t{0},
                      std::int64_t{1},
                      std::int64_t{-1},
                      kFar,
                      -kFar,
                      std::int64_t{0xffffffff},
                      std::int64_t{1} << 32}) {
                    ASSERT_EQ(
                        difference(low, position, exponent, eye),
                        asFloat(exactDifference(low, position, exponent, eye)))
                        << low << " " << position << " " << exponent << " " << eye;
                }
            }
        }
    }
}

TEST(GridDifference, doesNotDependOnHowACellNamesThePoint)
{
    std::mt19937_64 random(5);
    for (int i = 0; i < 50'000; ++i) {
        // One grid point as a multiple of 2^20, seen from two corners in two units.
        const std::int64_t point = static_cast<std::int64_t>(random() % (1U << 26U)) << 20;
        const std::int64_t eye = static_cast<std::int64_t>(random() >> 18U);
        const auto seenFrom = [&](std::uint32_t exponent) {
            const std::int64_t most = std::min<std::int64_t>(32768, point >> exponent);
            const auto steps =
                static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most + 1));
            const std::int64_t corner = point - (steps << exponent);
            EXPECT_EQ(corner % 32768, 0);
            return difference(
                static_cast<std::uint32_t>(corner >> 15),
                static_cast<std::uint32_t>(steps),
                exponent,
                eye);
        };
        ASSERT_EQ(seenFrom(20), seenFrom(16));
    }
}

} // namespace
} // namespace isofront

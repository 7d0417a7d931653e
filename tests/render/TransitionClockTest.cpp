#include "isofront/render/TransitionClock.h"

#include "shared/transition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <vector>

namespace isofront::render {
namespace {

TEST(TransitionClock, beginsOnceATransitionAndRisesEvenlyInBetween)
{
    constexpr double kLength = 0.25;
    for (const double step : {0.001, 0.016, 0.1, 0.2499}) {
        TransitionClock clock(kLength);
        ASSERT_TRUE(clock.begins(100.0));
        EXPECT_EQ(clock.weight(), 1.0F) << "nothing was there before";
        int begun = 0;
        float before = 2;
        constexpr int kFrames = 2000;
        for (int frame = 1; frame <= kFrames; ++frame) {
            const bool begins = clock.begins(100.0 + frame * step);
            const float weight = clock.weight();
            begun += begins ? 1 : 0;
            ASSERT_TRUE(weight >= 0 && weight <= 1);
            if (begins) {
                EXPECT_LE(weight, step / kLength + 1e-6) << "no more than since the last frame";
            } else {
                EXPECT_NEAR(weight - before, step / kLength, 1e-6);
            }
            before = weight;
        }
        EXPECT_NEAR(begun, kFrames * step / kLength, 1);
    }
}

TEST(TransitionClock, showsAllAtOnceWhereTimeJumps)
{
    TransitionClock clock(1.0);
    clock.begins(10.0);
    EXPECT_TRUE(clock.begins(10.5));
    EXPECT_EQ(clock.weight(), 0.5F);
    EXPECT_TRUE(clock.begins(3.0)) << "back";
    EXPECT_EQ(clock.weight(), 1.0F);
    EXPECT_TRUE(clock.begins(3.25)) << "and on from there";
    EXPECT_EQ(clock.weight(), 0.25F);
    EXPECT_FALSE(clock.begins(3.75));
    EXPECT_TRUE(clock.begins(6.0)) << "ahead by more than a transition";
    EXPECT_EQ(clock.weight(), 1.0F);
    EXPECT_TRUE(clock.begins(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_EQ(clock.weight(), 1.0F);
    EXPECT_TRUE(clock.begins(7.0));
    EXPECT_EQ(clock.weight(), 1.0F);
}

TEST(TransitionClock, neverFadesWithoutALength)
{
    for (const double length :
         {0.0,
          -1.0,
          std::numeric_limits<double>::infinity(),
          std::numeric_limits<double>::quiet_NaN()}) {
        TransitionClock clock(length);
        EXPECT_EQ(clock.length(), 0.0);
        for (const double now : {0.0, 0.0, 0.01, 5.0, 4.0}) {
            EXPECT_TRUE(clock.begins(now));
            EXPECT_EQ(clock.weight(), 1.0F);
        }
    }
}

TEST(Dither, takesEachOfItsThresholdsOnceInASquare)
{
    std::set<float> all;
    for (std::uint32_t y = 0; y < 8; ++y) {
        for (std::uint32_t x = 0; x < 8; ++x) {
            const float threshold = shared::ditherThreshold(x, y);
            EXPECT_EQ(threshold, shared::ditherThreshold(x + 8, y + 1016));
            all.insert(threshold);
        }
    }
    ASSERT_EQ(all.size(), 64U);
    float expected = 1.0F / 128;
    for (const float threshold : all) {
        EXPECT_EQ(threshold, expected);
        expected += 1.0F / 64;
    }
}

TEST(Dither, spreadsWhatChangesOverAllPartsOfASquare)
{
    // Of 4^k pixels that change first, each of 4^k equal squares has one.
    for (std::uint32_t k = 1; k <= 2; ++k) {
        const std::uint32_t edge = 8U >> k;
        std::set<std::pair<std::uint32_t, std::uint32_t>> squares;
        const float weight = static_cast<float>(1U << 2 * k) / 64.0F;
        for (std::uint32_t y = 0; y < 8; ++y) {
            for (std::uint32_t x = 0; x < 8; ++x) {
                if (shared::pictureAt(x, y, weight) == shared::kInPresent) {
                    EXPECT_TRUE(squares.emplace(x / edge, y / edge).second);
                }
            }
        }
        EXPECT_EQ(squares.size(), std::size_t{1} << 2 * k);
    }
}

TEST(Dither, showsOnePictureAloneAtTheEnds)
{
    for (std::uint32_t i = 0; i < 64; ++i) {
        EXPECT_EQ(shared::pictureAt(i % 8, i / 8, 0.0F), shared::kInFormer);
        EXPECT_EQ(shared::pictureAt(i % 8, i / 8, 1.0F), shared::kInPresent);
    }
}

} // namespace
} // namespace isofront::render

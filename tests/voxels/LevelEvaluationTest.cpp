#include "support/Random.h"

#include <isofront/voxels/LevelEvaluation.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

namespace isofront::voxels {
namespace {

TEST(Levels, byDistanceAreThoseOfTheSource)
{
    // equation 3: N = 4, x = 2 and a distance of 2.5 give 2.75, counted from the coarsest
    EXPECT_EQ(4 - levelAtDistance(2.5, 2, 4), 2.75);
    EXPECT_EQ(levelAtDistance(0, 2, 4), 0);
    EXPECT_EQ(levelAtDistance(1e300, 2, 4), 4);
    EXPECT_EQ(levelAtDistance(std::numeric_limits<double>::infinity(), 2, 4), 4);
}

TEST(FillRates, haveTheThresholdsOfTheSource)
{
    const FillRates one{};
    const FillRates four{.progression = 4};
    const FillRates half{.progression = 0.5};
    for (std::uint32_t level = 0; level < 9; ++level) {
        EXPECT_EQ(one.threshold(level), 16 * (level + 1));
        EXPECT_DOUBLE_EQ(four.threshold(level), 16 * (std::pow(4, level + 1) - 1) / 3);
        EXPECT_DOUBLE_EQ(half.threshold(level), 32 * (1 - std::pow(0.5, level + 1)));
    }
    EXPECT_EQ(four.threshold(0), 16);
    EXPECT_EQ(four.threshold(1), 80);
    EXPECT_EQ(four.threshold(2), 336);
    EXPECT_EQ(four.threshold(3), 1360);
    EXPECT_EQ(one.weight(8, 0), 0.5);
    EXPECT_EQ(one.weight(8, 1), 0.25);
    EXPECT_EQ(one.weight(1e9, 1), 1);
    EXPECT_EQ(one.weight(0, 1), 0);
    EXPECT_EQ(stepOf(one, 0.99, 1), LevelStep::coarser);
    EXPECT_EQ(stepOf(one, 1, 1), LevelStep::stay);
    EXPECT_EQ(stepOf(one, 31.9, 1), LevelStep::stay);
    EXPECT_EQ(stepOf(one, 32, 1), LevelStep::finer);
    EXPECT_FALSE(one.check());
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    for (const FillRates& wrong :
         {FillRates{5.9, 1, 1},
          FillRates{16, 0, 1},
          FillRates{16, 1, 0},
          FillRates{16, 1, -1},
          FillRates{kNone, 1, 1},
          FillRates{16, kNone, 1},
          FillRates{16, 1, kNone}})
        EXPECT_EQ(wrong.check()->code, core::ErrorCode::usage);
}

TEST(ApproximateFill, countsThePixelsOfACube)
{
    auto random = tests::random(80);
    for (int trial = 0; trial < 20; ++trial) {
        // a camera that looks at the middle of the box; a pixel grid over the cube there
        glm::dvec3 eye(0);
        for (std::size_t i = 0; i < 3; ++i)
            eye[i] = tests::uniform(random, -1, 1);
        eye = 100.0 * glm::normalize(eye);
        const glm::dvec3 middle(3, 4, 5);
        core::Box bounds;
        bounds.include(middle - glm::dvec3(2, 3, 1));
        bounds.include(middle + glm::dvec3(2, 3, 1));
        const double edge = 2;
        const double pixelsPerUnit = 1500;
        const glm::dvec3 forward = -eye / 100.0;
        const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.3, 0.5, 0.8)));
        const glm::dvec3 up = glm::cross(right, forward);
        int count = 0;
        for (int y = -40; y < 40; ++y)
            for (int x = -40; x < 40; ++x) {
                const glm::dvec3 d =
                    forward + (x + 0.5) / pixelsPerUnit * right + (y + 0.5) / pixelsPerUnit * up;
                double enter = -1e9;
                double exit = 1e9;
                for (std::size_t i = 0; i < 3; ++i) {
                    const double a = (-edge / 2 - eye[i]) / d[i];
                    const double b = (edge / 2 - eye[i]) / d[i];
                    enter = std::max(enter, std::min(a, b));
                    exit = std::min(exit, std::max(a, b));
                }
                count += enter < exit ? 1 : 0;
            }
        const double fill = approximateFill(bounds, edge, middle + eye, pixelsPerUnit);
        EXPECT_NEAR(fill, count, 0.05 * count);
    }
    core::Box bounds;
    bounds.include(glm::dvec3(0));
    EXPECT_EQ(approximateFill(bounds, 2, glm::dvec3(0), 100), 100 * 100.0);
    EXPECT_EQ(approximateFill(bounds, 2, {4, 0, 0}, 100), 50 * 50.0);
    // four times as much with every coarser level
    EXPECT_EQ(
        approximateFill(bounds, 4, {40, 9, 1}, 100),
        4 * approximateFill(bounds, 2, {40, 9, 1}, 100));
}

TEST(PatternNodes, areTheNearestVoxelsOfAPicture)
{
    auto random = tests::random(81);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<std::uint64_t> picture;
        std::uint64_t nearest = ~std::uint64_t{0};
        std::map<std::uint64_t, std::uint64_t> counts;
        for (std::size_t i = tests::below(random, 300); i-- > 0;) {
            if (tests::below(random, 3) == 0) {
                picture.push_back(kNoPatternPixel);
                continue;
            }
            const std::uint64_t id = 0xfffffff0U + tests::below(random, 8); // not exact as floats
            const std::uint64_t depth = 5 + tests::below(random, 4);
            picture.push_back(depth << 32U | id);
            nearest = std::min(nearest, depth * 1000 + id % 1000);
            ++counts[id];
        }
        const auto node = patternNode(picture);
        ASSERT_EQ(node.has_value(), !counts.empty());
        std::ranges::shuffle(picture, random);
        EXPECT_EQ(patternNode(picture), node) << "in whatever order";
        if (!node)
            continue;
        EXPECT_EQ(node->depth, nearest / 1000);
        EXPECT_EQ(node->id % 1000, nearest % 1000);
        EXPECT_EQ(node->pixels, counts.at(node->id));
    }
    EXPECT_EQ(fillOf({1, 2, 30}, 20), 30);
    EXPECT_EQ(fillOf({1, 2, 3}, 20), 20) << "partly hidden";
}

TEST(Levels, areCalibratedToTheFewestPixelsThatAreEnough)
{
    EXPECT_EQ(calibratedLevel(std::array{0.3, 1.2, 4.8, 19.2}, 1), 1U);
    EXPECT_EQ(calibratedLevel(std::array{0.0, 0.0, 0.1}, 1), 2U) << "nothing is enough";
    EXPECT_EQ(calibratedLevel(std::array{2.0, 8.0, 32.0}, 1), 0U);
    EXPECT_EQ(calibratedLevel(std::array{2.0, 2.0, 2.0}, 1), 0U);
    EXPECT_EQ(calibratedLevel(std::array{0.0, 3.0}, 0), 1U) << "0 is not on screen";
    EXPECT_EQ(calibratedLevel({}, 1), 0U);
}

constexpr std::uint32_t kCoarsest = 6;

LevelControl controlOf(const LevelControlSettings& settings, std::uint32_t start)
{
    auto control = LevelControl::create(settings, kCoarsest, start);
    EXPECT_TRUE(control) << control.error().message;
    return *control;
}

/// What is seen of an object whose finest voxels fill so much; the node is of the level shown.
LevelObservation observed(double finest, const LevelControl& control)
{
    const std::uint32_t level = control.shown().level;
    return {std::ldexp(finest, 2 * static_cast<int>(level)), level, 0, 0};
}

TEST(LevelControl, comesToRestIfNothingMovesAndStaysThere)
{
    for (const double progression : {0.5, 1.0, 2.0, 4.0, 8.0})
        for (const double most : {6.0, 16.0, 100.0})
            for (std::uint32_t start = 0; start <= kCoarsest; start += 3)
                for (double finest = 1e-5; finest < 1e5; finest *= 1.37) {
                    const LevelControlSettings settings{{most, 1, progression}};
                    LevelControl control = controlOf(settings, start);
                    for (int frame = 0; frame < 140; ++frame)
                        control.update(observed(finest, control));
                    const ShownLevel rest = control.shown();
                    for (int frame = 0; frame < 4; ++frame)
                        ASSERT_EQ(control.update(observed(finest, control)), rest);
                    // what is shown is as fine as needed and not finer
                    const double fill = std::ldexp(finest, 2 * static_cast<int>(rest.level));
                    if (rest.level > 0 && rest.weight == 0) {
                        ASSERT_LT(fill, settings.rates.threshold(rest.level));
                    }
                    if (rest.level < kCoarsest && rest.number() < kCoarsest - 1) {
                        ASSERT_GE(fill, settings.rates.least);
                    }
                }
}

TEST(LevelControl, changesBySmallStepsWhateverItIsTold)
{
    auto random = tests::random(82);
    for (int trial = 0; trial < tests::trials(50); ++trial) {
        LevelControlSettings settings;
        settings.framesOfLevel = static_cast<std::uint32_t>(1 + tests::below(random, 20));
        settings.framesToAgree = static_cast<std::uint32_t>(1 + tests::below(random, 4));
        LevelControl control = controlOf(settings, 3);
        double before = 3;
        for (int frame = 0; frame < 300; ++frame) {
            LevelObservation observation{
                std::exp(tests::uniform(random, -20, 20)),
                static_cast<std::uint32_t>(tests::below(random, 9)),
                tests::below(random, 3) * 100,
                tests::below(random, 200)};
            if (frame % 7 == 0)
                observation.fill = 0;
            if (frame % 11 == 0)
                observation.fill = std::numeric_limits<double>::quiet_NaN();
            const ShownLevel shown = control.update(observation);
            ASSERT_LE(std::abs(shown.number() - before), 1.0 / settings.framesOfLevel + 1e-12);
            ASSERT_GE(shown.weight, 0);
            ASSERT_LT(shown.weight, 1);
            ASSERT_LE(shown.level, kCoarsest);
            ASSERT_GE(shown.number(), 0);
            before = shown.number();
        }
    }
}

TEST(LevelControl, followsAnApproachAndARetreat)
{
    const LevelControlSettings settings;
    LevelControl control = controlOf(settings, kCoarsest);
    const auto finestAt = [](double distance) { return 4000 / (distance * distance); };
    // slowly, so that what is shown keeps up
    double before = kCoarsest;
    double distance = 5000;
    for (; distance > 5; distance *= 0.998) {
        const double number = control.update(observed(finestAt(distance), control)).number();
        ASSERT_LE(number, before + 1e-12) << "detail only comes";
        before = number;
    }
    EXPECT_EQ(before, 0);
    for (; distance < 50'000; distance *= 1.002) {
        const double number = control.update(observed(finestAt(distance), control)).number();
        ASSERT_GE(number, before - 1e-12) << "detail only goes";
        before = number;
    }
    EXPECT_EQ(before, kCoarsest);
}

TEST(LevelControl, takesNoOneFrameForAReason)
{
    LevelControl control = controlOf({}, 3);
    const double calm = 0.15; // 9.6 at level 3
    for (int i = 0; i < 100; ++i)
        control.update(observed(calm, control));
    const ShownLevel rest = control.shown();
    EXPECT_EQ(rest.level, 3U);
    control.update({1e6, 3, 0, 0});
    for (int i = 0; i < 20; ++i)
        control.update(observed(calm, control));
    EXPECT_EQ(control.shown(), rest);
    // off screen it keeps its level
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(control.update({0, 3, 0, 0}), rest);
    // of a pixel, too
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(control.update({1e6, 3, 1, 9}), rest);
    // nothing finer where there is a voxel for each pixel; coarser is well
    for (int i = 0; i < 20; ++i)
        EXPECT_EQ(control.update({1e6, 3, 500, 500}), rest);
    for (int i = 0; i < 200; ++i)
        control.update({1e-6, 3, 500, 500});
    EXPECT_EQ(control.shown().number(), kCoarsest);
}

TEST(LevelControl, refusesSettingsThatMakeNoSense)
{
    const auto code = [](const LevelControlSettings& settings, std::uint32_t start) {
        const auto control = LevelControl::create(settings, kCoarsest, start);
        return control ? 0 : static_cast<int>(control.error().code);
    };
    EXPECT_EQ(code({}, 6), 0);
    EXPECT_EQ(code({}, 7), 2);
    EXPECT_EQ(code({.rates = {.most = 2}}, 0), 2);
    EXPECT_EQ(code({.framesToAgree = 0}, 0), 2);
    EXPECT_EQ(code({.framesOfLevel = 0}, 0), 2);
}

} // namespace
} // namespace isofront::voxels

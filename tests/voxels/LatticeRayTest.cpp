#include "LatticeRay.h"

#include "MovedRay.h"
#include "support/Random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace isofront::voxels {
namespace {

TEST(LatticeRay, entersTheCubesThatARayMovedByNothingEnters)
{
    constexpr int kCellBits = 3;
    constexpr int kQuarterBits = LatticeRay::kBits - kCellBits - 2;
    auto random = tests::random(70);
    const auto number = [&](int low, int high) {
        return low + static_cast<std::int64_t>(
                         tests::below(random, static_cast<std::size_t>(high - low + 1)));
    };
    std::size_t cubes = 0;
    std::size_t ties = 0;
    const int trials = tests::trials(5000);
    for (int trial = 0; trial < trials; ++trial) {
        Cube start{number(-8, 40), number(-8, 40), number(-8, 40)};
        const Cube direction{number(-4, 4), number(-4, 4), number(-4, 4)};
        if (direction == Cube{})
            continue;
        if (trial % 2 == 0)
            for (std::int64_t& s : start)
                s = s / 4 * 4; // on edges and corners
        const MovedRay moved(start, direction, MovedRay::kMoved);
        struct Step {
            Crossing crossing;
            Cube cell;
        };
        std::vector<Step> expected;
        for (std::int64_t z = 0; z < 8; ++z)
            for (std::int64_t y = 0; y < 8; ++y)
                for (std::int64_t x = 0; x < 8; ++x)
                    if (const auto c = crossing(moved, {4 * x, 4 * y, 4 * z}, 4))
                        expected.push_back({*c, {x, y, z}});
        std::ranges::sort(expected, [](const Step& a, const Step& b) {
            return a.crossing.enter < b.crossing.enter;
        });

        Cube steps{};
        for (std::size_t i = 0; i < 3; ++i)
            steps[i] = start[i] * (std::int64_t{1} << kQuarterBits);
        const LatticeRay ray(steps, direction, kCellBits);
        auto place = ray.begin();
        for (const Step& step : expected) {
            ASSERT_TRUE(place);
            ASSERT_TRUE(ray.contains(*place));
            for (std::size_t i = 0; i < 3; ++i)
                ASSERT_EQ(place->cell[i], step.cell[i]) << "trial " << trial;
            ASSERT_EQ(place->axis, step.crossing.axis);
            const double before = ray.distance(*place);
            ray.leave(*place, 0);
            ASSERT_GE(ray.distance(*place), before);
            ties += ray.distance(*place) == before ? 1U : 0U;
            ++cubes;
        }
        ASSERT_TRUE(!place || !ray.contains(*place)) << "trial " << trial;
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(cubes, 10'000U);
        EXPECT_GT(ties, 1000U);
    }
}

TEST(LatticeRay, leapsOverCubesOfAnySizeToWhereStepsLead)
{
    auto random = tests::random(71);
    for (int trial = 0; trial < tests::trials(2000); ++trial) {
        Cube start{};
        Cube direction{};
        const bool small = trial % 2 == 0; // with ties
        for (std::size_t i = 0; i < 3; ++i) {
            start[i] = small ? static_cast<std::int64_t>(tests::below(random, 513)) << 21U
                             : static_cast<std::int64_t>(tests::below(random, 1U << 30U));
            direction[i] =
                small ? static_cast<std::int64_t>(tests::below(random, 7)) - 3
                      : static_cast<std::int64_t>(tests::below(random, 1U << 31U)) - (1 << 30);
        }
        if (direction == Cube{})
            continue;
        const LatticeRay ray(start, direction, 8);
        auto leaping = ray.begin();
        auto stepping = leaping;
        while (leaping && ray.contains(*leaping)) {
            const auto bits = static_cast<int>(tests::below(random, 7));
            const auto from = leaping->cell;
            ray.leave(*leaping, bits);
            const auto isInside = [&] {
                for (std::size_t i = 0; i < 3; ++i)
                    if ((stepping->cell[i] ^ from[i]) >> bits != 0)
                        return false;
                return true;
            };
            while (isInside())
                ray.leave(*stepping, 0);
            ASSERT_EQ(leaping->cell, stepping->cell);
            ASSERT_EQ(leaping->axis, stepping->axis);
            ASSERT_EQ(leaping->rise, stepping->rise);
        }
    }
}

} // namespace
} // namespace isofront::voxels

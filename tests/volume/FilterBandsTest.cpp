#include "FilterBands.h"

#include "FilterKernel.h"
#include "LevelAxis.h"
#include "fields/FieldChecks.h"
#include "support/Random.h"
#include "volume/ExpectedWeight.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace isofront::volume {
namespace {

TEST(FilterBands, haveTheWeightsOfTheExponentialWithExactEnds)
{
    for (int i = 0; i < 4000; ++i) {
        const double radius = 0.01 * std::exp2(i * 0.005);
        for (int band = 0; band < 12; ++band) {
            const double weight = detail::bandWeight(band, radius);
            EXPECT_NEAR(weight, expectedWeight(band, radius), 1e-13) << band << ' ' << radius;
            const double x = 0.3 * std::exp2(-band) * radius;
            EXPECT_NEAR(weight, std::exp(-x * x), 1.0 / 64.0 + 1e-13);
        }
    }
    EXPECT_EQ(detail::bandWeight(0, detail::kPlainRadius), 1.0);
    EXPECT_LT(detail::bandWeight(0, 1.0001 * detail::kPlainRadius), 1.0);
    EXPECT_EQ(detail::bandWeight(0, 6.8), 0.0);
    EXPECT_GT(detail::bandWeight(0, 6.79), 0.0);
    EXPECT_EQ(detail::bandWeight(30, std::numeric_limits<double>::infinity()), 0.0);
}

TEST(FilterBands, countFewLevelsWhoseWeightsAddUpToOne)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const int top : {0, 1, 2, 3, 5, 8, 13, 31}) {
        for (int i = 0; i < 3000; ++i) {
            const double radius = 0.05 * std::exp2(i * 0.015);
            const detail::LevelWeights found = detail::levelWeights(radius, top);
            ASSERT_GE(found.first, 0);
            ASSERT_LE(found.count, 6);
            ASSERT_LE(found.first + found.count - 1, top);
            double sum = 0;
            for (int k = 0; k <= top; ++k) {
                const double finer = k > 0 ? expectedWeight(k - 1, radius) : 0.0;
                const double own = k < top ? expectedWeight(k, radius) : 1.0;
                const int place = k - found.first;
                const double weight = place >= 0 && place < found.count
                                          ? found.weight[static_cast<std::size_t>(place)]
                                          : 0.0;
                ASSERT_EQ(weight > 0, place >= 0 && place < found.count);
                ASSERT_NEAR(weight, own - finer, 1e-13) << k << " of " << top << ' ' << radius;
                sum += weight;
            }
            ASSERT_NEAR(sum, 1.0, 1e-14);
        }
        for (const double radius : {0.0, -1.0, detail::kPlainRadius, std::nan("")}) {
            const detail::LevelWeights plain = detail::levelWeights(radius, top);
            EXPECT_EQ(plain.first, 0);
            EXPECT_EQ(plain.count, 1);
            EXPECT_EQ(plain.weight[0], 1.0);
        }
        const detail::LevelWeights all = detail::levelWeights(kInfinity, top);
        EXPECT_EQ(all.first, top);
        EXPECT_EQ(all.count, 1);
        EXPECT_EQ(all.weight[0], 1.0);
    }
}

TEST(FilterBands, weighABlockAsEachOfItsPointsOnEveryInstructionSet)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    auto generator = tests::random(31);
    for (const int top : {0, 1, 2, 5, 9, 31}) {
        for (int trial = 0; trial < 40; ++trial) {
            const std::size_t count = 1 + tests::below(generator, detail::kBlock);
            std::vector<double> radii(count);
            const double least = tests::uniform(generator, -3, top + 6);
            const double most = tests::uniform(generator, least, top + 6);
            for (double& radius : radii) {
                radius = std::exp2(tests::uniform(generator, least, most));
                if (trial % 2 == 0 && tests::below(generator, 10) == 0) {
                    const std::array<double, 8> rare = {
                        0.0,
                        -1.0,
                        5e-324,
                        kInfinity,
                        std::nan(""),
                        detail::kPlainRadius,
                        std::nextafter(detail::kPlainRadius, 1.0),
                        16 * detail::kPlainRadius};
                    radius = rare[tests::below(generator, rare.size())];
                }
            }
            fields::test::onEveryInstructionSet([&](const std::string& target) {
                const auto found = std::make_unique<detail::BlockWeights>();
                detail::weighLevels(radii.data(), count, top, *found);
                for (std::size_t i = 0; i < count; ++i) {
                    const detail::LevelWeights own = detail::levelWeights(radii[i], top);
                    ASSERT_LE(found->first, own.first);
                    ASSERT_GE(found->end, own.first + own.count);
                    for (int level = found->first; level < found->end; ++level) {
                        const int place = level - own.first;
                        const double expected = place >= 0 && place < own.count
                                                    ? own.weight[static_cast<std::size_t>(place)]
                                                    : 0.0;
                        ASSERT_EQ(found->rows[static_cast<std::size_t>(level)][i], expected)
                            << target << ' ' << radii[i] << ", level " << level << " of " << top;
                    }
                }
            });
        }
    }
}

TEST(FilterTaps, areAMeanThatKeepsLinearFunctionsUpToTheBorder)
{
    for (int voxels = 1; voxels < 150; ++voxels) {
        for (int level = 1; level < 9; ++level) {
            const int nodes = detail::LevelAxis(voxels, level).nodes;
            const int finer = detail::LevelAxis(voxels, level - 1).nodes;
            EXPECT_EQ(detail::voxelOfNode(voxels, level, nodes - 1), voxels - 1);
            for (int node = 0; node < nodes; ++node) {
                const detail::FilterTaps taps = detail::filterTaps(voxels, level, node);
                double sum = 0;
                double place = 0;
                for (int i = 0; i < 5; ++i) {
                    const double weight = taps.weight[static_cast<std::size_t>(i)];
                    const int tap = taps.centre + i - 2;
                    ASSERT_GE(weight, 0.0);
                    if (weight == 0)
                        continue;
                    ASSERT_GE(tap, 0);
                    ASSERT_LT(tap, finer);
                    sum += weight;
                    place +=
                        weight * static_cast<double>(detail::voxelOfNode(voxels, level - 1, tap));
                }
                ASSERT_NEAR(sum, 1.0, 1e-15);
                ASSERT_NEAR(
                    place,
                    static_cast<double>(detail::voxelOfNode(voxels, level, node)),
                    1e-13 * voxels);
            }
        }
    }
}

} // namespace
} // namespace isofront::volume

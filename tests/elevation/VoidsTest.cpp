#include "Voids.h"

#include "support/Random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace isofront::elevation {
namespace {

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

HeightGrid gridOf(int columns, int rows, auto&& height)
{
    HeightGrid grid;
    grid.columns = columns;
    grid.rows = rows;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            grid.heights.push_back(static_cast<float>(height(column, row)));
    return grid;
}

TEST(Voids, areFilledByTheHarmonicFunctionOfTheirBorder)
{
    // x^2 - y^2 satisfies the discrete Laplace equation exactly.
    const auto saddle = [](int x, int y) {
        return 0.5 * (x - 20) * (x - 20) - 0.5 * (y - 15) * (y - 15);
    };
    HeightGrid grid = gridOf(41, 31, saddle);
    for (int row = 8; row < 22; ++row)
        for (int column = 10; column < 32; ++column)
            if (row % 5 != 0 || column % 7 != 0)
                grid.heights[grid.index(column, row)] = kVoid;
    EXPECT_GT(fillVoids(grid), 250U);
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column)
            ASSERT_NEAR(grid.heights[grid.index(column, row)], saddle(column, row), 0.1)
                << column << ' ' << row;
}

TEST(Voids, keepWhatIsKnownToTheBitAndStayWithinItsRange)
{
    auto random = tests::random(3);
    HeightGrid grid = gridOf(100, 80, [&](int, int) { return tests::uniform(random, -50, 900); });
    std::vector<bool> isVoid(grid.heights.size());
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < isVoid.size(); ++i)
        if ((isVoid[i] = random() % 3 != 0)) {
            grid.heights[i] = kVoid;
            ++count;
        }
    const HeightGrid before = grid;
    HeightGrid again = grid;
    EXPECT_EQ(fillVoids(grid), count);
    fillVoids(again);
    EXPECT_EQ(
        std::memcmp(grid.heights.data(), again.heights.data(), grid.heights.size() * sizeof(float)),
        0);
    for (std::size_t i = 0; i < isVoid.size(); ++i) {
        ASSERT_TRUE(isVoid[i] || grid.heights[i] == before.heights[i]);
        ASSERT_GE(grid.heights[i], -51);
        ASSERT_LE(grid.heights[i], 901);
    }
}

TEST(Voids, extendToTheBorderOfTheRasterAndAroundASinglePost)
{
    HeightGrid grid = gridOf(30, 20, [](int x, int y) { return x == 3 && y == 4 ? 7.0F : kVoid; });
    EXPECT_EQ(fillVoids(grid), 599U);
    for (const float height : grid.heights)
        ASSERT_FLOAT_EQ(height, 7);
}

TEST(Voids, areCountedAndLeftWhereNothingIsKnown)
{
    HeightGrid grid = gridOf(4, 3, [](int, int) { return kVoid; });
    EXPECT_EQ(fillVoids(grid), 12U);
    EXPECT_TRUE(std::isnan(grid.heights[0]));
    HeightGrid whole = gridOf(4, 3, [](int x, int y) { return x + y; });
    EXPECT_EQ(fillVoids(whole), 0U);
}

} // namespace
} // namespace isofront::elevation

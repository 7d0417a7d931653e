#include <isofront/core/LargeVector.h>

#include <gtest/gtest.h>

#include <cstdint>

namespace isofront::core {
namespace {

TEST(LargeVector, keepsWhatItHoldsAsItGrowsFromSmallToLarge)
{
    LargeVector<std::uint32_t> numbers;
    std::uint32_t next = 0;
    // across the size from which memory comes in large pages
    while (numbers.size() * sizeof(std::uint32_t) < (std::size_t{9} << 20U)) {
        const std::size_t before = numbers.size();
        numbers.resize(2 * before + 1);
        for (std::size_t i = before; i < numbers.size(); ++i)
            numbers[i] = next++;
    }
    for (std::uint32_t i = 0; i < next; ++i)
        ASSERT_EQ(numbers[i], i);
    numbers.shrink_to_fit();
    EXPECT_EQ(numbers.back(), next - 1);
    LargeVector<std::uint32_t> copy = numbers;
    EXPECT_EQ(copy, numbers);
    numbers = {};
    EXPECT_EQ(copy.back(), next - 1);
}

} // namespace
} // namespace isofront::core

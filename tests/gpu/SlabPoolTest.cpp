#include <isofront/gpu/SlabPool.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

namespace isofront::gpu {
namespace {

/// What a range really takes from the pool.
std::uint32_t taken(const SlabPool& pool, SlabPool::Range range)
{
    const std::uint32_t slab = pool.slabUnits();
    return range.count <= slab ? range.count : (range.count + slab - 1) / slab * slab;
}

/// No two ranges overlap, small ones stay within a slab, and the books agree.
void expectSound(const SlabPool& pool, const std::vector<SlabPool::Range>& ranges)
{
    std::vector<bool> used(pool.capacity(), false);
    std::uint32_t sum = 0;
    for (const SlabPool::Range& range : ranges) {
        const std::uint32_t length = taken(pool, range);
        ASSERT_LE(range.first + length, pool.capacity());
        if (range.count <= pool.slabUnits()) {
            ASSERT_EQ(
                range.first / pool.slabUnits(), (range.first + length - 1) / pool.slabUnits());
        } else {
            ASSERT_EQ(range.first % pool.slabUnits(), 0U);
        }
        for (std::uint32_t i = range.first; i < range.first + length; ++i) {
            ASSERT_FALSE(used[i]) << "two ranges hold unit " << i;
            used[i] = true;
        }
        sum += length;
    }
    ASSERT_EQ(pool.used(), sum);
    std::uint32_t emptySlabs = 0;
    for (std::uint32_t slab = 0; slab < pool.slabs(); ++slab) {
        const auto first = used.begin() + static_cast<std::ptrdiff_t>(slab * pool.slabUnits());
        const auto count = std::count(first, first + pool.slabUnits(), true);
        ASSERT_EQ(pool.usedIn(slab), static_cast<std::uint32_t>(count));
        emptySlabs += count == 0 ? 1 : 0;
    }
    ASSERT_EQ(pool.freeSlabs(), emptySlabs);
}

TEST(SlabPool, neverOverlapsAndEndsEmptyUnderRandomWork)
{
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        std::mt19937 random(seed);
        SlabPool pool(17, 64);
        std::vector<SlabPool::Range> ranges;
        std::size_t refused = 0;
        for (int step = 0; step < 1500; ++step) {
            const bool add = ranges.empty() || random() % 100 < (step % 300 < 150 ? 70U : 35U);
            if (add) {
                const auto units = static_cast<std::uint32_t>(
                    random() % 20 == 0 ? 65 + random() % 250 : 1 + random() % 40);
                if (const auto range = pool.allocate(units)) {
                    EXPECT_EQ(range->count, units);
                    ranges.push_back(*range);
                } else {
                    ++refused;
                }
            } else {
                const std::size_t victim = random() % ranges.size();
                pool.release(ranges[victim]);
                ranges[victim] = ranges.back();
                ranges.pop_back();
            }
            if (step % 50 == 0)
                expectSound(pool, ranges);
        }
        EXPECT_GT(refused, 0U) << "the pool was never full, seed " << seed;
        for (const SlabPool::Range& range : ranges)
            pool.release(range);
        expectSound(pool, {});
        EXPECT_EQ(pool.allocate(17 * 64), (SlabPool::Range{0, 17 * 64})) << "seed " << seed;
    }
}

TEST(SlabPool, refusesOnlyWhatCannotFit)
{
    SlabPool pool(4, 100);
    EXPECT_EQ(pool.allocate(0), SlabPool::Range{});
    EXPECT_FALSE(pool.allocate(401));
    const auto run = pool.allocate(250);
    ASSERT_TRUE(run);
    EXPECT_EQ(pool.used(), 300U) << "a run takes whole slabs";
    const auto last = pool.allocate(100);
    ASSERT_TRUE(last);
    EXPECT_FALSE(pool.allocate(1));
    pool.release(*run);
    EXPECT_TRUE(pool.allocate(300));
}

TEST(SlabPool, fillsTheFullestSlabThatHasRoom)
{
    SlabPool pool(3, 100);
    const auto a = pool.allocate(60);
    const auto b = pool.allocate(80);
    const auto c = pool.allocate(15);
    ASSERT_TRUE(a && b && c);
    EXPECT_EQ(c->first / 100, b->first / 100);
    EXPECT_EQ(pool.freeSlabs(), 1U);
}

TEST(SlabPool, drainsASparseSlabUntilItIsFree)
{
    SlabPool pool(3, 100);
    const auto a = pool.allocate(90);
    const auto b = pool.allocate(60);
    const auto c = pool.allocate(20);
    ASSERT_TRUE(a && b && c);
    pool.release(*b);
    EXPECT_FALSE(pool.sparsest(19));
    const auto sparse = pool.sparsest(25);
    ASSERT_TRUE(sparse);
    EXPECT_EQ(*sparse, c->first / 100);
    pool.drain(*sparse);
    const auto elsewhere = pool.allocate(20);
    ASSERT_TRUE(elsewhere);
    EXPECT_NE(elsewhere->first / 100, *sparse);
    pool.release(*c);
    EXPECT_EQ(pool.freeSlabs(), 1U);
    EXPECT_TRUE(pool.allocate(100)) << "a drained slab is as good as new";
}

TEST(SlabPool, aCopyUndoesWhatFollows)
{
    SlabPool pool(2, 50);
    const auto kept = pool.allocate(30);
    ASSERT_TRUE(kept);
    const SlabPool before = pool;
    ASSERT_TRUE(pool.allocate(20));
    ASSERT_TRUE(pool.allocate(50));
    pool = before;
    expectSound(pool, {*kept});
    EXPECT_TRUE(pool.allocate(50));
}

} // namespace
} // namespace isofront::gpu

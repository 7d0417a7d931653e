#include "support/Random.h"

#include <isofront/core/FlatMap.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <unordered_map>

namespace isofront::core {
namespace {

/// So poor that keys crowd together, and runs of places wrap around the end.
struct PoorHash {
    std::size_t operator()(std::uint32_t key) const { return key / 4 * 13; }
};

using Map = FlatMap<std::uint32_t, int, PoorHash>;

void expectSame(const Map& map, const std::unordered_map<std::uint32_t, int>& twin)
{
    ASSERT_EQ(map.size(), twin.size());
    std::size_t visited = 0;
    map.forEach([&](const Map::Entry& entry) {
        ++visited;
        const auto found = twin.find(entry.first);
        ASSERT_NE(found, twin.end());
        ASSERT_EQ(entry.second, found->second);
    });
    ASSERT_EQ(visited, twin.size());
}

TEST(FlatMap, doesWhatTheStandardOneDoes)
{
    auto generator = tests::random(7);
    for (int trial = 0; trial < 20 * tests::intensity(); ++trial) {
        Map map(0xFFFFFFFFU);
        std::unordered_map<std::uint32_t, int> twin;
        const std::size_t keys = 1 + tests::below(generator, 400);
        for (int step = 0; step < 4000; ++step) {
            const auto key = static_cast<std::uint32_t>(tests::below(generator, keys));
            switch (tests::below(generator, 5)) {
            case 0:
            case 1: {
                const auto [value, isNew] = map.tryEmplace(key, step);
                const auto [entry, isNewThere] = twin.try_emplace(key, step);
                ASSERT_EQ(isNew, isNewThere);
                ASSERT_EQ(*value, entry->second);
                break;
            }
            case 2:
                map[key] = step;
                twin[key] = step;
                break;
            case 3:
                ASSERT_EQ(map.erase(key), twin.erase(key) == 1);
                break;
            default:
                ASSERT_EQ(map.contains(key), twin.contains(key));
            }
        }
        expectSame(map, twin);
    }
}

TEST(FlatMap, isEmptyAtFirst)
{
    Map map(0);
    EXPECT_EQ(map.size(), 0U);
    EXPECT_EQ(map.bytes(), 0U);
    EXPECT_FALSE(map.contains(5));
    EXPECT_FALSE(map.erase(5));
    EXPECT_EQ(map.find(5), nullptr);
}

} // namespace
} // namespace isofront::core

#include "DeviceCache.h"

#include "support/Random.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace isofront::voxels {
namespace {

struct Range {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;

    [[nodiscard]] bool meets(const Range& other) const
    {
        return offset < other.offset + other.bytes && other.offset < offset + bytes;
    }
};

/// Watches a cache from outside: what lies where, and what frames under way read.
class Watched {
public:
    Watched(std::uint64_t capacity, std::uint64_t root, std::uint64_t largest)
        : cache(capacity, root, largest), _capacity(capacity)
    {
    }

    void begin(std::uint64_t lag)
    {
        ++_frame;
        _completed = _frame > lag ? std::max(_completed, _frame - lag) : 0;
        cache.begin(_frame, _completed);
        std::erase_if(_reads, [&](const auto& read) { return read.first <= _completed; });
    }
    /// @return the bytes moved
    std::uint64_t move(std::uint64_t mostBytes, ChunkIndex pinned)
    {
        std::uint64_t bytes = 0;
        std::vector<Range> written;
        const std::vector<ChunkMove> moves = cache.move(mostBytes, pinned);
        for (const ChunkMove& move : moves) {
            const Range from{move.from, move.bytes};
            const Range to{move.to, move.bytes};
            EXPECT_NE(move.index, pinned);
            EXPECT_EQ(places.at(move.index).offset, move.from);
            EXPECT_LE(places.at(move.index).bytes, move.bytes);
            expectUnused(to);
            for (const Range& range : written)
                EXPECT_FALSE(range.meets(from) || range.meets(to));
            written.push_back(to);
            bytes += move.bytes;
        }
        for (const ChunkMove& move : moves) {
            places.at(move.index).offset = move.to;
            _reads.emplace_back(_frame, Range{move.from, move.bytes});
        }
        if (moves.size() > 1) {
            EXPECT_LE(bytes, mostBytes);
        }
        return bytes;
    }
    bool allocate(ChunkIndex index, std::uint64_t bytes)
    {
        const auto offset = cache.allocate(index, bytes);
        if (!offset)
            return false;
        EXPECT_EQ(*offset % kChunkAlignment, 0U);
        EXPECT_EQ(*offset, cache.offsetOf(index));
        EXPECT_LE(*offset + bytes, cache.usable());
        const Range range{*offset, bytes};
        expectUnused(range);
        places[index] = range;
        return true;
    }
    void release(ChunkIndex index)
    {
        cache.release(index);
        places.erase(index);
    }
    void use(ChunkIndex index)
    {
        cache.use(index);
        _reads.emplace_back(_frame, places.at(index));
    }

    DeviceCache cache;
    std::map<ChunkIndex, Range> places;

private:
    void expectUnused(const Range& range)
    {
        EXPECT_LE(range.offset + range.bytes, _capacity);
        for (const auto& [frame, read] : _reads)
            EXPECT_FALSE(range.meets(read)) << "read by frame " << frame << " of " << _frame;
        for (const auto& [index, place] : places)
            EXPECT_FALSE(range.meets(place)) << "where chunk " << index << " lies";
    }

    std::uint64_t _capacity;
    std::uint64_t _frame = 0;
    std::uint64_t _completed = 0;
    std::vector<std::pair<std::uint64_t, Range>> _reads;
};

TEST(DeviceCache, neverGivesAwayWhatIsInUse)
{
    auto random = tests::random(21);
    for (int run = 0; run < tests::trials(8); ++run) {
        const std::uint64_t largest = 256 * (1 + tests::below(random, 40));
        const std::uint64_t capacity = largest * (3 + tests::below(random, 30));
        Watched watched(capacity, largest, largest);
        ChunkIndex next = 0;
        std::uint64_t moved = 0;
        for (int frame = 0; frame < 300; ++frame) {
            watched.begin(1 + tests::below(random, 3));
            const ChunkIndex pinned = watched.places.empty() || tests::below(random, 2) == 0
                                          ? kNoChunk
                                          : watched.places.begin()->first;
            moved += watched.move(largest * (1 + tests::below(random, 4)), pinned);
            for (std::size_t i = tests::below(random, 4); i > 0 && !watched.places.empty(); --i) {
                auto at = watched.places.begin();
                std::advance(at, static_cast<int>(tests::below(random, watched.places.size())));
                watched.release(at->first);
            }
            for (std::size_t i = tests::below(random, 6); i > 0; --i) {
                const std::uint64_t bytes = 1 + tests::below(random, largest);
                if (!watched.allocate(next++, bytes))
                    watched.cache.makeRoom(bytes);
            }
            for (const auto& [index, place] : watched.places)
                if (tests::below(random, 8) > 0)
                    watched.use(index);
            std::uint64_t used = 0;
            for (const auto& [index, place] : watched.places)
                used += alignedBytes(place.bytes);
            ASSERT_EQ(watched.cache.used(), used);
            if (testing::Test::HasFailure())
                return;
        }
        EXPECT_GT(moved, 0U);
    }
}

TEST(DeviceCache, makesRoomWhereverThereIsEnough)
{
    auto random = tests::random(22);
    for (int run = 0; run < tests::trials(40); ++run) {
        const std::uint64_t largest = 256 * (1 + tests::below(random, 40));
        const std::uint64_t capacity = largest * (3 + tests::below(random, 30));
        const std::uint64_t lag = 1 + tests::below(random, 3);
        Watched watched(capacity, largest, largest);
        watched.begin(lag);
        // full, then with holes everywhere
        ChunkIndex next = 0;
        while (watched.allocate(next, 1 + tests::below(random, largest)))
            ++next;
        for (ChunkIndex i = 0; i < next; ++i)
            if (tests::below(random, 3) == 0)
                watched.release(i);
        const std::uint64_t room = watched.cache.usable() - watched.cache.used();
        const std::uint64_t wanted = std::min(largest, room);
        if (wanted < 256)
            continue;
        bool isThere = false;
        // each chunk moves at most twice, and whatever is set aside is filled at once
        const std::uint64_t rounds = 2 * (lag + 1) * (next + 2);
        for (std::uint64_t frame = 0; frame < rounds && !isThere; ++frame) {
            watched.begin(lag);
            watched.move(std::uint64_t{1} << 40U, kNoChunk);
            for (const auto& [index, place] : watched.places)
                watched.use(index); // drawn in every frame
            isThere = watched.allocate(next, wanted);
            if (!isThere)
                watched.cache.makeRoom(wanted);
        }
        EXPECT_TRUE(isThere) << "run " << run << ": " << wanted << " of " << room << " bytes";
    }
}

TEST(DeviceCache, hasRoomForTheRootEvenIfForNothingElse)
{
    DeviceCache cache(5000, 4000, 4500);
    EXPECT_EQ(cache.usable(), alignedBytes(4000));
    cache.begin(1, 0);
    EXPECT_EQ(cache.allocate(0, 4000), 0U);
    EXPECT_FALSE(cache.allocate(1, 256));
}

} // namespace
} // namespace isofront::voxels

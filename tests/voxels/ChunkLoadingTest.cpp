#include "ChunkFlight.h"

#include <map>
#include <mutex>

namespace isofront::voxels {
namespace {

/// When each chunk was given its form, by key: what the loader does last.
class Packed {
public:
    ChunkForm form()
    {
        ChunkForm form = standardForm();
        form.pack = [this, pack = form.pack](const Chunk& chunk, std::span<std::byte> data) {
            pack(chunk, data);
            const std::lock_guard lock(_mutex);
            _frames[chunk.key] = frame;
            ++packed;
        };
        return form;
    }
    std::uint64_t frameOf(const ChunkKey& key)
    {
        const std::lock_guard lock(_mutex);
        return _frames.at(key);
    }

    std::uint64_t frame = 0;
    std::uint64_t packed = 0;

private:
    std::mutex _mutex;
    std::map<ChunkKey, std::uint64_t> _frames;
};

TEST(ChunkLoading, holdsNoMoreOnTheHostThanItMay)
{
    const auto store = shared(tests::city(4, 4, false));
    for (const std::uint64_t bound : {std::uint64_t{60'000}, std::uint64_t{1}}) {
        auto random = tests::random(31);
        Packed packed;
        StreamingSettings settings = settingsFor(0.02);
        settings.form = packed.form();
        settings.hostBytes = bound;
        settings.uploadBytes = 3000; // so that much waits while the view goes on
        Flight flight(store, settings);
        flight.feedback = Feedback::none;
        const ChunkTree& tree = flight.streamer->tree();
        // What was loaded for one frame and uploaded for a later one, without having been loaded
        // again, was on the host all the time.
        std::map<std::uint64_t, std::uint64_t> held;
        std::map<std::uint64_t, std::size_t> chunks;
        for (int i = 0; i < tests::trials(30); ++i) {
            const BlockCamera camera = anyCamera(random, 128);
            for (int j = 0; j < 12; ++j) {
                packed.frame = flight.frame + 1;
                for (const ChunkUpload& upload : flight.step(camera).uploads) {
                    const ChunkEntry& entry = tree[upload.index].entry;
                    if (!upload.isLast)
                        continue;
                    for (std::uint64_t at = packed.frameOf(entry.key); at < flight.frame; ++at) {
                        held[at] += settings.form.bytes(entry);
                        ++chunks[at];
                    }
                }
            }
        }
        std::uint64_t most = 0;
        for (const auto& [frame, bytes] : held) {
            EXPECT_TRUE(bytes <= bound || chunks[frame] == 1) << bytes << " in frame " << frame;
            most = std::max(most, bytes);
        }
        EXPECT_GT(most, bound / 2) << "it makes use of what it may";
        if (tests::areAllTrialsMade()) {
            EXPECT_GT(packed.packed, 100U);
        }
    }
}

TEST(ChunkLoading, goesOnWhereOneChunkExceedsAllThatMayWait)
{
    auto random = tests::random(32);
    const auto store = shared(tests::city(4, 4, false));
    for (const core::JobsBackend backend :
         {core::JobsBackend::inlined, core::JobsBackend::threads}) {
        StreamingSettings settings = settingsFor(0.02);
        settings.hostBytes = 1;
        Flight flight(store, settings, backend);
        flight.feedback = Feedback::none;
        for (int i = 0; i < tests::trials(6); ++i) {
            // turns away while chunks are being read
            for (int j = 0; j < 3; ++j)
                flight.step(anyCamera(random, 128));
            const BlockCamera camera = anyCamera(random, 128);
            flight.settle(camera, 100'000);
            EXPECT_EQ(flight.step(camera).missing, 0U);
        }
    }
}

} // namespace
} // namespace isofront::voxels

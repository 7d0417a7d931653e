#include "isofront/voxels/ChunkForm.h"

#include "support/Random.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <vector>

namespace isofront::voxels {
namespace {

/// A chunk whose voxels have sets of every kind, or none.
Chunk anyChunk(std::mt19937_64& random, bool coloured, bool faced)
{
    const auto word = [&] { return static_cast<std::uint32_t>(random()); };
    std::map<std::uint32_t, Voxel> places;
    while (places.size() < 500) {
        // many in the border, where faces are added
        const auto coordinate = [&] {
            const std::size_t kind = tests::below(random, 4);
            return kind == 0   ? 0U
                   : kind == 1 ? kChunkEdge - 1
                               : static_cast<std::uint32_t>(tests::below(random, kChunkEdge));
        };
        const std::uint32_t place = packPlace(coordinate(), coordinate(), coordinate(), 0);
        places[place] = {place | (word() & kAllFaces) << 24U, word() & 0x3fffffffU};
    }
    Chunk chunk;
    for (const auto& [place, voxel] : places) {
        chunk.voxels.push_back(voxel);
        if (coloured)
            chunk.colours.push_back(word());
        if (!faced || tests::below(random, 3) > 0)
            continue;
        const std::uint32_t mask = word() & kAllFaces;
        const auto first = static_cast<std::uint32_t>(chunk.faceAttributes.size());
        chunk.faceSets.push_back(
            {static_cast<std::uint32_t>(chunk.voxels.size() - 1), first | mask << 26U});
        for (int i = 0; i < std::popcount(mask); ++i)
            chunk.faceAttributes.push_back({word() & 0x3fffffffU, coloured ? word() : 0});
    }
    return chunk;
}

TEST(ChunkForm, saysOfEveryFaceWhatTheChunkSays)
{
    auto random = tests::random(31);
    for (const bool coloured : {false, true})
        for (const bool faced : {false, true}) {
            const Chunk chunk = anyChunk(random, coloured, faced);
            ASSERT_TRUE(hasSoundFaces(chunk));
            std::vector<std::byte> bytes(standardForm().bytes(entryOf(chunk)));
            ASSERT_EQ(bytes.size(), chunk.bytes());
            packInto(chunk, bytes);
            std::vector<std::uint32_t> words(bytes.size() / 4);
            std::memcpy(words.data(), bytes.data(), bytes.size());

            const std::vector<std::uint8_t> faces = cappedFaces(chunk);
            std::size_t sets = 0;
            for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
                const Voxel stored{words[2 * i], words[2 * i + 1]};
                ASSERT_EQ(stored.order(), chunk.voxels[i].order());
                ASSERT_EQ(stored.faces(), faces[i]);
                const bool has = (stored.normal & kHasFaces) != 0;
                sets += has ? 1U : 0U;
                const std::uint32_t colour =
                    coloured ? words[2 * chunk.voxels.size() + i] : std::uint32_t{0};
                for (std::size_t face = 0; face < kFaces; ++face) {
                    FaceAttributes look{stored.normal, colour};
                    if (has) {
                        const std::size_t set = stored.normal & ~kHasFaces;
                        ASSERT_LT(set + 1, words.size());
                        look.normal = words[set] & 0x3fffffffU;
                        const std::uint32_t mask = words[set] >> 30U | words[set + 1] >> 28U << 2U;
                        const std::uint32_t below = mask & ((1U << face) - 1);
                        const std::size_t own = (words[set + 1] & 0x0fffffffU) +
                                                2 * static_cast<std::size_t>(std::popcount(below));
                        if ((mask >> face & 1U) != 0) {
                            ASSERT_LT(own + 1, words.size());
                            look = {words[own], words[own + 1]};
                        }
                    }
                    ASSERT_EQ(look, attributesOf(chunk, i, static_cast<Face>(face)));
                }
            }
            EXPECT_EQ(sets, chunk.faceSets.size());
        }
}

TEST(ChunkForm, takesNoNormalForASet)
{
    // bits that no voxel has, as a damaged file may
    const Chunk chunk{.key = {}, .voxels = {{packPlace(1, 2, 3, 1), 0xc0000123U}}};
    std::vector<std::byte> bytes(chunk.bytes());
    packInto(chunk, bytes);
    Voxel stored;
    std::memcpy(&stored, bytes.data(), sizeof stored);
    EXPECT_EQ(stored, (Voxel{packPlace(1, 2, 3, 1), 0x123U}));
}

} // namespace
} // namespace isofront::voxels

#include "ChunkOccupancy.h"

#include "support/Random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

namespace isofront::voxels {
namespace {

TEST(ChunkOccupancy, tellsTheLargestEmptyCubeAroundAnyPlace)
{
    auto random = tests::random(72);
    for (const std::size_t count : {0U, 1U, 2U, 60U, 5000U}) {
        std::set<std::uint32_t> orders;
        for (std::size_t i = 0; i < count; ++i) {
            // in clusters, so that there is empty space of all sizes
            const auto base = static_cast<std::uint32_t>(tests::below(random, 7)) * 0x1f2b3dU;
            const auto near = static_cast<std::uint32_t>(random()) & 0x1f0f07U;
            orders.insert((base + near) & 0xffffffU);
        }
        std::vector<Voxel> voxels;
        for (const std::uint32_t order : orders)
            voxels.push_back({order, 0});
        const ChunkOccupancy occupancy(voxels);
        for (int trial = 0; trial < tests::trials(3000); ++trial) {
            auto order = static_cast<std::uint32_t>(tests::below(random, 1U << 24U));
            if (trial % 2 == 0 && !voxels.empty()) // near one
                order = (voxels[tests::below(random, voxels.size())].order() +
                         static_cast<std::uint32_t>(tests::below(random, 4)) * 0x010101U) &
                        0xffffffU;
            const Voxel place{order, 0};
            int expected = ChunkOccupancy::kFullCube;
            for (int bits = 0; bits <= 8; ++bits) {
                const auto isIn = [&](const Voxel& v) {
                    return v.x() >> bits == place.x() >> bits &&
                           v.y() >> bits == place.y() >> bits && v.z() >> bits == place.z() >> bits;
                };
                if (std::ranges::any_of(voxels, isIn))
                    break;
                expected = bits;
            }
            ASSERT_EQ(occupancy.emptyAround(place.x(), place.y(), place.z()), expected);
        }
    }
    const ChunkOccupancy none(std::span<const Voxel>{});
    EXPECT_EQ(none.emptyAround(1, 2, 3), 8);
}

} // namespace
} // namespace isofront::voxels

#include "support/Random.h"

#include <isofront/volume/VolumeField.h>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <type_traits>
#include <vector>

namespace isofront::volume {
namespace {

template <typename T>
class VoxelKernel : public testing::Test {
};

using Types =
    testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, float>;
TYPED_TEST_SUITE(VoxelKernel, Types);

template <typename T>
std::shared_ptr<const T[]> randomVoxels(std::mt19937_64& generator, std::size_t count)
{
    // no longer than it must be, so that AddressSanitizer sees a look-up beyond the end
    auto owned = std::make_unique<T[]>(count);
    for (T& voxel : std::span(owned.get(), count)) {
        if constexpr (std::is_floating_point_v<T>) {
            voxel = static_cast<T>(tests::uniform(generator, -1e3, 1e3));
            if (tests::below(generator, 20) == 0)
                voxel = tests::below(generator, 2) == 0 ? std::numeric_limits<T>::quiet_NaN()
                                                        : -std::numeric_limits<T>::infinity();
        } else {
            voxel = static_cast<T>(generator());
        }
    }
    return owned;
}

/// A coordinate of any kind about an axis of so many voxels.
double coordinate(std::mt19937_64& generator, int voxels)
{
    switch (tests::below(generator, 8)) {
    case 0:
        return static_cast<double>(tests::below(generator, static_cast<std::size_t>(voxels)));
    case 1:
        return voxels - 1;
    case 2:
        return std::nextafter(voxels - 1.0, 0.0);
    case 3:
        return tests::below(generator, 2) == 0 ? std::numeric_limits<double>::quiet_NaN() : -1e300;
    default:
        return tests::uniform(generator, -1.5, voxels + 0.5);
    }
}

/// Has only the instruction sets used that are in the mask; 0 gives all back.
void useOnly(std::int64_t targets)
{
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

// A point that stands alone is sampled by plain code, many together by vector instructions.
TYPED_TEST(VoxelKernel, givesTheSameBitsForManyPointsAsForOne)
{
    std::vector<std::int64_t> sets{0};
    for (const std::int64_t set : {std::int64_t{HWY_AVX2}, std::int64_t{HWY_SSE4}})
        if ((hwy::SupportedTargets() & set) != 0)
            sets.push_back(set);
    auto generator = tests::random(11);
    for (int trial = 0; trial < 60 * tests::intensity(); ++trial) {
        const auto edge = [&] { return 1 + static_cast<int>(tests::below(generator, 9)); };
        const glm::ivec3 size(edge(), edge(), edge());
        const VolumeField<TypeParam> field(
            size,
            randomVoxels<TypeParam>(
                generator,
                static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                    static_cast<std::size_t>(size.z)));
        const std::size_t count = 1 + tests::below(generator, 300);
        std::vector<double> x(count);
        std::vector<double> y(count);
        std::vector<double> z(count);
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = coordinate(generator, size.x);
            y[i] = coordinate(generator, size.y);
            z[i] = coordinate(generator, size.z);
        }
        std::vector<float> together(count);
        useOnly(sets[static_cast<std::size_t>(trial) % sets.size()]);
        field.sample({x, y, z}, together);
        useOnly(0);
        for (std::size_t i = 0; i < count; ++i) {
            float alone = 0;
            field.sample({{&x[i], 1}, {&y[i], 1}, {&z[i], 1}}, {&alone, 1});
            ASSERT_EQ(std::isnan(alone), std::isnan(together[i]));
            if (!std::isnan(alone)) {
                ASSERT_EQ(std::memcmp(&alone, &together[i], sizeof(float)), 0)
                    << alone << " and " << together[i];
            }
        }
    }
}

} // namespace
} // namespace isofront::volume

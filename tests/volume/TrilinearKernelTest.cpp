#include "fields/FieldChecks.h"
#include "support/NumberTypes.h"
#include "support/Random.h"

#include <isofront/volume/VolumeField.h>

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace isofront::volume {
namespace {

template <typename T>
class TrilinearKernel : public testing::Test {
};

TYPED_TEST_SUITE(TrilinearKernel, tests::VoxelTypes);

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

/// What a sample is by its definition, one point at a time.
template <typename T>
float plainSample(const glm::ivec3& size, const T* voxels, const glm::dvec3& point)
{
    glm::ivec3 cell;
    glm::dvec3 t;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double last = size[axis] - 1;
        double inside = point[axis] > 0 ? point[axis] : 0; // NaN is not above
        inside = inside < last ? inside : last;
        cell[axis] = static_cast<int>(inside);
        t[axis] = inside - cell[axis];
    }
    const auto mixed = [](double a, double b, double share) {
        return std::is_floating_point_v<T> && share == 0 ? a : a + share * (b - a);
    };
    const auto at = [&](int x, int y, int z) {
        const glm::ivec3 place = glm::min(cell + glm::ivec3(x, y, z), size - 1);
        return static_cast<double>(voxels[(place.z * size.y + place.y) * size.x + place.x]);
    };
    const auto alongX = [&](int y, int z) { return mixed(at(0, y, z), at(1, y, z), t.x); };
    const auto alongY = [&](int z) { return mixed(alongX(0, z), alongX(1, z), t.y); };
    return static_cast<float>(mixed(alongY(0), alongY(1), t.z));
}

bool haveSameBits(float a, float b)
{
    return std::isnan(a) ? std::isnan(b) : std::memcmp(&a, &b, sizeof(float)) == 0;
}

TYPED_TEST(TrilinearKernel, givesTheBitsOfTheDefinitionOnEveryInstructionSet)
{
    auto generator = tests::random(11);
    for (int trial = 0; trial < 60 * tests::intensity(); ++trial) {
        const auto edge = [&] { return 1 + static_cast<int>(tests::below(generator, 9)); };
        const glm::ivec3 size(edge(), edge(), edge());
        const auto voxels = randomVoxels<TypeParam>(
            generator,
            static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                static_cast<std::size_t>(size.z));
        const VolumeField<TypeParam> field(size, voxels);
        const std::size_t count = 1 + tests::below(generator, 300);
        std::vector<double> x(count);
        std::vector<double> y(count);
        std::vector<double> z(count);
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = coordinate(generator, size.x);
            y[i] = coordinate(generator, size.y);
            z[i] = coordinate(generator, size.z);
        }
        fields::test::onEveryInstructionSet([&](const std::string& target) {
            std::vector<float> together(count);
            field.sample({x, y, z}, together);
            for (std::size_t i = 0; i < count; ++i) {
                const float expected = plainSample(size, voxels.get(), {x[i], y[i], z[i]});
                ASSERT_TRUE(haveSameBits(together[i], expected))
                    << target << ": " << together[i] << " and " << expected;
            }
        });
    }
}

// Neighbouring cells have the same point in blocks with other points and radii.
TYPED_TEST(TrilinearKernel, filtersAPointAloneAsAmongOthersOnEveryInstructionSet)
{
    auto generator = tests::random(12);
    for (int trial = 0; trial < 12 * tests::intensity(); ++trial) {
        const auto edge = [&] { return 1 + static_cast<int>(tests::below(generator, 40)); };
        const glm::ivec3 size(edge(), edge(), edge());
        const VolumeField<TypeParam> field(
            size,
            randomVoxels<TypeParam>(
                generator,
                static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                    static_cast<std::size_t>(size.z)));
        const std::size_t count = 1 + tests::below(generator, 200);
        std::vector<double> x(count);
        std::vector<double> y(count);
        std::vector<double> z(count);
        std::vector<double> radius(count);
        const double most = tests::uniform(generator, -2, 7);
        for (std::size_t i = 0; i < count; ++i) {
            x[i] = coordinate(generator, size.x);
            y[i] = coordinate(generator, size.y);
            z[i] = coordinate(generator, size.z);
            radius[i] = std::exp2(tests::uniform(generator, -3, most));
        }
        std::vector<float> alone(count);
        for (std::size_t i = 0; i < count; ++i)
            field.sample({{&x[i], 1}, {&y[i], 1}, {&z[i], 1}, {&radius[i], 1}}, {&alone[i], 1});
        fields::test::onEveryInstructionSet([&](const std::string& target) {
            std::vector<float> together(count);
            field.sample({x, y, z, radius}, together);
            for (std::size_t i = 0; i < count; ++i)
                ASSERT_TRUE(haveSameBits(together[i], alone[i]))
                    << target << ": " << together[i] << " and " << alone[i];
        });
    }
}

} // namespace
} // namespace isofront::volume

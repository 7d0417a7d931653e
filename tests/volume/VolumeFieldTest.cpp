#include "support/NumberTypes.h"
#include "volume/Files.h"

#include <isofront/volume/VolumeField.h>

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <limits>
#include <type_traits>

namespace isofront::volume {
namespace {

using test::countExcludedSamples;
using test::sampleAt;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename T>
std::shared_ptr<const T[]> shared(const std::vector<T>& values)
{
    std::shared_ptr<T[]> voxels(new T[values.size()]);
    std::copy(values.begin(), values.end(), voxels.get());
    return voxels;
}

std::size_t countOf(glm::ivec3 size)
{
    return static_cast<std::size_t>(size.x * size.y * size.z);
}

template <typename T>
std::vector<T> randomVoxels(glm::ivec3 size, std::uint32_t seed)
{
    std::mt19937_64 random(seed);
    std::vector<T> values(countOf(size));
    for (T& value : values) {
        if constexpr (std::is_integral_v<T>)
            value = static_cast<T>(random()); // the whole range of the type
        else
            value = static_cast<T>(std::uniform_real_distribution<double>(-1e3, 1e3)(random));
    }
    return values;
}

template <typename T>
class VolumeFieldOf : public testing::Test {
};
TYPED_TEST_SUITE(VolumeFieldOf, tests::VoxelTypes);

TYPED_TEST(VolumeFieldOf, givesTheVoxelAtItsCentre)
{
    const glm::ivec3 size(7, 5, 9);
    const auto voxels = randomVoxels<TypeParam>(size, 1);
    const VolumeField<TypeParam> field(size, shared(voxels));
    std::size_t next = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                ASSERT_EQ(sampleAt(field, {x, y, z}), static_cast<float>(voxels[next++]))
                    << x << ' ' << y << ' ' << z;
}

TYPED_TEST(VolumeFieldOf, interpolatesTrilinearlyAndClampsOutside)
{
    const glm::ivec3 size(6, 11, 4);
    const auto voxels = randomVoxels<TypeParam>(size, 2);
    const VolumeField<TypeParam> field(size, shared(voxels));
    // Independent of the field's own order of work: a weighted sum over all voxels near the point.
    const auto oracle = [&](glm::dvec3 point) {
        point = glm::clamp(point, glm::dvec3(0.0), glm::dvec3(size - 1));
        long double sum = 0;
        for (int z = 0; z < size.z; ++z) {
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    const glm::dvec3 weight =
                        glm::max(1.0 - glm::abs(point - glm::dvec3(x, y, z)), glm::dvec3(0.0));
                    sum += static_cast<long double>(weight.x) * static_cast<long double>(weight.y) *
                           static_cast<long double>(weight.z) *
                           static_cast<long double>(
                               voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)]);
                }
            }
        }
        return static_cast<double>(sum);
    };
    double range = 0;
    for (const TypeParam voxel : voxels)
        range = std::max(range, std::abs(static_cast<double>(voxel)));
    std::mt19937 random(3);
    for (int i = 0; i < 3000; ++i) {
        const auto between = [&](double low, double high) {
            return std::uniform_real_distribution<double>(low, high)(random);
        };
        const glm::dvec3 point(
            between(-3, size.x + 2), between(-3, size.y + 2), between(-3, size.z + 2));
        // One rounding to float, and a few of double before it.
        ASSERT_NEAR(double{sampleAt(field, point)}, oracle(point), range * 0x1p-23);
    }
}

TYPED_TEST(VolumeFieldOf, neverExcludesASampleFromItsBounds)
{
    const glm::ivec3 size(45, 18, 31);
    const VolumeField<TypeParam> field(size, shared(randomVoxels<TypeParam>(size, 4)));
    EXPECT_EQ(countExcludedSamples(field, *field.dataBox(), 3000, 5), 0U);
}

TYPED_TEST(VolumeFieldOf, givesTheSameBitsWhereverAPointStandsInItsBatch)
{
    const glm::ivec3 size(20, 20, 20);
    const VolumeField<TypeParam> field(size, shared(randomVoxels<TypeParam>(size, 6)));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-1.0, 21.0);
    std::vector<double> x(301);
    std::vector<double> y(301);
    std::vector<double> z(301);
    for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] = coordinate(random);
        y[i] = coordinate(random);
        z[i] = coordinate(random);
    }
    std::vector<float> together(x.size());
    field.sample({x, y, z}, together);
    for (std::size_t i = 0; i < x.size(); ++i)
        ASSERT_EQ(together[i], sampleAt(field, {x[i], y[i], z[i]}));
}

TEST(VolumeField, hasExactBoundsOverABoxOfOneBrick)
{
    // A brick has 8 cells an axis and shares its border samples with the next.
    const glm::ivec3 size(25, 25, 25);
    std::vector<std::uint8_t> voxels(countOf(size), 10);
    const auto at = [&](int x, int y, int z) -> std::uint8_t& {
        return voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)];
    };
    at(8, 4, 4) = 200;
    at(17, 4, 4) = 90;
    const VolumeField<std::uint8_t> field(size, shared(voxels));
    const auto bounds = [&](double from, double to) {
        return field.bounds({{from, 0, 0}, {to, 8, 8}}, {0, 0});
    };
    EXPECT_EQ(bounds(0, 8).high, 200);
    EXPECT_EQ(bounds(8, 16).high, 200);
    EXPECT_EQ(bounds(16, 24).high, 90);
    EXPECT_EQ(bounds(16, 24).low, 10);
    EXPECT_EQ(field.bounds({{0, 8, 8}, {8, 16, 16}}, {0, 0}).high, 10);
    EXPECT_EQ(bounds(-100, 100).high, 200);
    EXPECT_EQ(bounds(30, 100).high, 10) << "outside, the last plane counts, and no other";
    at(24, 4, 4) = 70;
    EXPECT_EQ(
        VolumeField<std::uint8_t>(size, shared(voxels))
            .bounds({{30, 0, 0}, {100, 8, 8}}, {0, 0})
            .high,
        70);
}

TEST(VolumeField, boundsEverythingWhereTheBoxIsEmptyOrNotANumber)
{
    const glm::ivec3 size(9, 9, 9);
    std::vector<std::int16_t> voxels(countOf(size), 3);
    voxels[5] = -7;
    voxels.back() = 11;
    const VolumeField<std::int16_t> field(size, shared(voxels));
    for (const core::Box& box :
         {core::Box{}, core::Box{{NAN, 0, 0}, {1, 1, 1}}, core::Box{{0, 0, 0}, {1, NAN, 1}}}) {
        const core::Interval bounds = field.bounds(box, {0, 0});
        EXPECT_EQ(bounds.low, -7);
        EXPECT_EQ(bounds.high, 11);
    }
    const core::Interval all =
        field.bounds({glm::dvec3(-kInfinity), glm::dvec3(kInfinity)}, {0, kInfinity});
    EXPECT_EQ(all.low, -7);
    EXPECT_EQ(all.high, 11);
}

template <typename T>
class NonFiniteVolume : public testing::Test {
};
using FloatTypes = testing::Types<float, double>;
TYPED_TEST_SUITE(NonFiniteVolume, FloatTypes);

TYPED_TEST(NonFiniteVolume, neverExcludesASampleFromItsBounds)
{
    const glm::ivec3 size(40, 23, 17);
    auto voxels = randomVoxels<TypeParam>(size, 8);
    std::mt19937 random(9);
    constexpr auto kLimits = std::numeric_limits<TypeParam>{};
    const std::array<TypeParam, 6> odd = {
        kLimits.quiet_NaN(),
        kLimits.infinity(),
        -kLimits.infinity(),
        kLimits.max(),
        kLimits.lowest(),
        kLimits.denorm_min()};
    for (std::size_t i = 0; i < 60; ++i)
        voxels[random() % voxels.size()] = odd[i % odd.size()];
    const VolumeField<TypeParam> field(size, shared(voxels));
    EXPECT_EQ(countExcludedSamples(field, *field.dataBox(), 4000, 10), 0U);
}

TYPED_TEST(NonFiniteVolume, keepsANonFiniteVoxelFromTheCentresOfOthers)
{
    const glm::ivec3 size(3, 3, 3);
    std::vector<TypeParam> voxels(27, TypeParam(2));
    voxels[13] = std::numeric_limits<TypeParam>::quiet_NaN();
    const VolumeField<TypeParam> field(size, shared(voxels));
    for (int i = 0; i < 27; ++i) {
        const float value = sampleAt(field, {i % 3, i / 3 % 3, i / 9});
        if (i == 13)
            EXPECT_TRUE(std::isnan(value));
        else
            EXPECT_EQ(value, 2.0F) << i;
    }
    EXPECT_TRUE(std::isnan(sampleAt(field, {0.5, 1, 1})));
}

TEST(VolumeField, widensOnlyBricksWithNonFiniteVoxels)
{
    const glm::ivec3 size(33, 9, 9);
    std::vector<float> voxels(countOf(size), 5.0F);
    voxels[4] = NAN;
    voxels[20] = INFINITY;
    voxels[28] = -INFINITY;
    const VolumeField<float> field(size, shared(voxels));
    const auto bounds = [&](double from, double to) {
        return field.bounds({{from, 0, 0}, {to, 8, 8}}, {0, 0});
    };
    EXPECT_EQ(bounds(0, 8).low, -kInfinity) << "NaN counts as outside";
    EXPECT_EQ(bounds(0, 8).high, 5);
    EXPECT_EQ(bounds(8, 16).low, 5);
    EXPECT_EQ(bounds(8, 16).high, 5);
    EXPECT_EQ(bounds(16, 24).high, kInfinity);
    EXPECT_EQ(bounds(24, 32).low, -kInfinity);
    EXPECT_EQ(bounds(24, 32).high, 5);
}

TEST(VolumeField, isDefinedForOneVoxelAndForFlatVolumes)
{
    const VolumeField<std::uint16_t> one(glm::ivec3(1), shared<std::uint16_t>({777}));
    EXPECT_EQ(sampleAt(one, {0, 0, 0}), 777.0F);
    EXPECT_EQ(sampleAt(one, {-5, 1e30, NAN}), 777.0F);
    EXPECT_EQ(one.bounds({{-1, -1, -1}, {4, 4, 4}}, {0, 0}).low, 777);
    EXPECT_EQ(one.bounds({{-1, -1, -1}, {4, 4, 4}}, {0, 0}).high, 777);

    const VolumeField<std::uint8_t> flat({2, 1, 3}, shared<std::uint8_t>({0, 10, 20, 30, 40, 50}));
    EXPECT_EQ(sampleAt(flat, {0.5, 9, 1.5}), 35.0F);
    EXPECT_EQ(countExcludedSamples(flat, *flat.dataBox(), 200, 11), 0U);
}

TEST(VolumeField, takesAnyCoordinate)
{
    const glm::ivec3 size(4, 4, 4);
    const auto voxels = randomVoxels<std::int32_t>(size, 12);
    const VolumeField<std::int32_t> field(size, shared(voxels));
    const float low = static_cast<float>(voxels.front());
    const float high = static_cast<float>(voxels.back());
    EXPECT_EQ(sampleAt(field, glm::dvec3(-kInfinity)), low);
    EXPECT_EQ(sampleAt(field, glm::dvec3(-DBL_MAX)), low);
    EXPECT_EQ(sampleAt(field, glm::dvec3(-0.0)), low);
    EXPECT_EQ(sampleAt(field, glm::dvec3(NAN)), low);
    EXPECT_EQ(sampleAt(field, glm::dvec3(DBL_MIN)), low);
    EXPECT_EQ(sampleAt(field, glm::dvec3(DBL_MAX)), high);
    EXPECT_EQ(sampleAt(field, glm::dvec3(kInfinity)), high);
}

TEST(VolumeField, hasTheGradientOfALinearRamp)
{
    const glm::ivec3 size(12, 10, 8);
    std::vector<float> voxels(countOf(size));
    std::size_t next = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                voxels[next++] = static_cast<float>(3 * x - 2 * y + 5 * z);
    const VolumeField<float> field(size, shared(voxels));
    const std::array<double, 1> x = {4.3};
    const std::array<double, 1> y = {5.1};
    const std::array<double, 1> z = {2.9};
    std::array<double, 1> dx{};
    std::array<double, 1> dy{};
    std::array<double, 1> dz{};
    field.gradient({x, y, z}, {dx, dy, dz});
    EXPECT_NEAR(dx[0], 3, 1e-5);
    EXPECT_NEAR(dy[0], -2, 1e-5);
    EXPECT_NEAR(dz[0], 5, 1e-5);
}

TEST(VolumeField, takesLittleMoreMemoryThanItsVoxels)
{
    const glm::ivec3 size(129, 129, 129);
    const VolumeField<std::uint8_t> field(size, shared(randomVoxels<std::uint8_t>(size, 13)));
    EXPECT_LT(static_cast<double>(field.memoryBytes()), 1.01 * static_cast<double>(countOf(size)));
}

} // namespace
} // namespace isofront::volume

#include "FilterBands.h"
#include "fields/FieldChecks.h"
#include "support/NumberTypes.h"
#include "support/Random.h"
#include "volume/ExpectedWeight.h"
#include "volume/Files.h"

#include <isofront/volume/VolumeField.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>
#include <type_traits>

namespace isofront::volume {
namespace {

using test::countExcludedSamples;
using test::sampleAt;

template <typename T>
using Voxels = std::vector<T>;

template <typename T>
std::shared_ptr<const VolumeField<T>> fieldOf(const glm::ivec3& size, const Voxels<T>& values)
{
    std::shared_ptr<T[]> voxels(new T[values.size()]);
    std::copy(values.begin(), values.end(), voxels.get());
    return std::make_shared<const VolumeField<T>>(size, voxels);
}

template <typename T>
Voxels<T> filled(const glm::ivec3& size, const std::function<double(glm::dvec3)>& value)
{
    Voxels<T> voxels;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                voxels.push_back(static_cast<T>(value({x, y, z})));
    return voxels;
}

// ---- The whole filter against a slow twin -------------------------------------------------------

/// The same pyramid by its definition: in double, without separating axes, taking every tap at its
/// place in space from an interpolation that is reflected beyond the last voxel; summed by bands.
class SlowPyramid {
public:
    SlowPyramid(const glm::ivec3& size, std::vector<double> voxels) : _size(size)
    {
        _levels.push_back(std::move(voxels));
        while ((1 << top()) < std::max({size.x, size.y, size.z}) - 1)
            _levels.push_back(coarser(top()));
    }

    [[nodiscard]] int top() const { return static_cast<int>(_levels.size()) - 1; }

    /// Sum of the bands with weights w(band).
    [[nodiscard]] double at(const glm::dvec3& point, const std::function<double(int)>& weight) const
    {
        double sum = interpolated(top(), point);
        for (int band = 0; band < top(); ++band)
            sum += weight(band) * (interpolated(band, point) - interpolated(band + 1, point));
        return sum;
    }

private:
    [[nodiscard]] int nodesAlong(std::size_t axis, int level) const
    {
        int count = 1;
        while (place(axis, level, count - 1) < _size[axis] - 1)
            ++count;
        return count;
    }
    [[nodiscard]] int place(std::size_t axis, int level, int node) const
    {
        return std::min(node << level, _size[axis] - 1);
    }
    [[nodiscard]] double node(int level, const glm::ivec3& index) const
    {
        return _levels[static_cast<std::size_t>(level)][static_cast<std::size_t>(
            (index.z * nodesAlong(1, level) + index.y) * nodesAlong(0, level) + index.x)];
    }

    /// Of points on the far side of the last voxel, too.
    [[nodiscard]] double interpolated(int level, const glm::dvec3& point) const
    {
        glm::ivec3 low;
        glm::dvec3 t(0.0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double last = _size[axis] - 1;
            if (point[axis] > last) { // odd reflection
                glm::dvec3 border = point;
                border[axis] = last;
                glm::dvec3 mirrored = point;
                mirrored[axis] = 2 * last - point[axis];
                return 2 * interpolated(level, border) - interpolated(level, mirrored);
            }
            low[axis] = 0;
            while (low[axis] + 2 < nodesAlong(axis, level) &&
                   place(axis, level, low[axis] + 1) <= point[axis])
                ++low[axis];
            if (nodesAlong(axis, level) > 1) {
                const double a = place(axis, level, low[axis]);
                t[axis] = (point[axis] - a) / (place(axis, level, low[axis] + 1) - a);
            }
        }
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1;
            glm::ivec3 index = low;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const bool isHigh = (corner >> axis & 1) != 0;
                weight *= isHigh ? t[axis] : 1.0 - t[axis];
                index[axis] += isHigh ? 1 : 0;
            }
            if (weight != 0)
                sum += weight * node(level, index);
        }
        return sum;
    }

    [[nodiscard]] std::vector<double> coarser(int level) const
    {
        constexpr std::array<double, 5> kTaps = {1, 4, 6, 4, 1};
        std::vector<double> values;
        const auto isBorder = [&](std::size_t axis, int position) {
            return position == 0 || position == _size[axis] - 1;
        };
        for (int z = 0; z < nodesAlong(2, level + 1); ++z) {
            for (int y = 0; y < nodesAlong(1, level + 1); ++y) {
                for (int x = 0; x < nodesAlong(0, level + 1); ++x) {
                    const glm::ivec3 centre(
                        place(0, level + 1, x), place(1, level + 1, y), place(2, level + 1, z));
                    double sum = 0;
                    for (int tap = 0; tap < 125; ++tap) {
                        const std::array<int, 3> index = {tap % 5, tap / 5 % 5, tap / 25};
                        glm::dvec3 point(centre);
                        double weight = 1;
                        for (std::size_t axis = 0; axis < 3; ++axis) {
                            const int i = index[axis];
                            if (isBorder(axis, centre[axis])) {
                                // both sides of the border cancel out
                                weight *= i == 2 ? 1.0 : 0.0;
                                continue;
                            }
                            weight *= kTaps[static_cast<std::size_t>(i)] / 16;
                            point[axis] += (i - 2) * (1 << level);
                        }
                        if (weight != 0)
                            sum += weight * interpolated(level, point);
                    }
                    values.push_back(sum);
                }
            }
        }
        return values;
    }

    glm::ivec3 _size;
    std::vector<std::vector<double>> _levels;
};

template <typename T>
class PyramidOf : public testing::Test {
public:
    /// Values that the type can hold, with most of its range, but no overflow in float.
    static double drawn(std::mt19937_64& random)
    {
        if constexpr (std::is_integral_v<T>)
            return static_cast<double>(static_cast<T>(random()));
        else
            return std::uniform_real_distribution<double>(-1e3, 1e3)(random);
    }
    /// By how much the levels of the type may be off, relative to the range of the data.
    static constexpr double kRounding = sizeof(T) == 1   ? 2.0 / 4095
                                        : sizeof(T) == 2 ? 2.0 / 65535
                                                         : 4e-7;
};
TYPED_TEST_SUITE(PyramidOf, tests::VoxelTypes);

TYPED_TEST(PyramidOf, agreesWithASlowTwinOnVolumesOfAnySize)
{
    std::mt19937_64 random(11);
    for (int trial = 0; trial < 8; ++trial) {
        glm::ivec3 size;
        for (std::size_t axis = 0; axis < 3; ++axis)
            size[axis] = 1 + static_cast<int>(random() % (trial < 6 ? 12 : 25));
        if (trial == 0)
            size = {1, 2, 17};
        if (trial == 1)
            size = {9, 1, 1};
        const auto voxels =
            filled<TypeParam>(size, [&](glm::dvec3) { return this->drawn(random); });
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (const TypeParam voxel : voxels) {
            low = std::min(low, static_cast<double>(voxel));
            high = std::max(high, static_cast<double>(voxel));
        }
        const auto field = fieldOf(size, voxels);
        const SlowPyramid twin(size, std::vector<double>(voxels.begin(), voxels.end()));
        for (int i = 0; i < 150; ++i) {
            glm::dvec3 point;
            for (std::size_t axis = 0; axis < 3; ++axis)
                point[axis] =
                    std::uniform_real_distribution<double>(0, std::max(size[axis] - 1, 1))(random);
            point = glm::min(point, glm::dvec3(size - 1));
            if (i % 5 == 0)
                point = glm::dvec3(size - 1); // the far corner
            const double radius = std::exp2(std::uniform_real_distribution<double>(-2, 8)(random));
            const double expected =
                twin.at(point, [&](int band) { return expectedWeight(band, radius); });
            ASSERT_NEAR(
                double{sampleAt(*field, point, radius)},
                expected,
                this->kRounding * (high - low) + 1e-7 * std::max(-low, high))
                << size.x << 'x' << size.y << 'x' << size.z << " r " << radius;
        }
    }
}

TYPED_TEST(PyramidOf, isTheVolumeItselfToTheLastBitUpToTheFirstBand)
{
    std::mt19937_64 random(12);
    const glm::ivec3 size(19, 24, 33);
    const auto field =
        fieldOf(size, filled<TypeParam>(size, [&](glm::dvec3) { return this->drawn(random); }));
    constexpr std::size_t kCount = 500;
    std::vector<double> x(kCount);
    std::vector<double> y(kCount);
    std::vector<double> z(kCount);
    std::vector<double> radius(kCount);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (std::size_t i = 0; i < kCount; ++i) {
        x[i] = -1 + 21 * unit(random);
        y[i] = -1 + 26 * unit(random);
        z[i] = -1 + 35 * unit(random);
        // In blocks with filtered points and in blocks without.
        radius[i] = i % 2 == 0 && i < 250 ? 40 * unit(random) : detail::kPlainRadius * unit(random);
    }
    std::vector<float> plain(kCount);
    std::vector<float> filtered(kCount);
    field->sample({x, y, z}, plain);
    field->sample({x, y, z, radius}, filtered);
    std::size_t differing = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const bool isSame =
            std::bit_cast<std::uint32_t>(plain[i]) == std::bit_cast<std::uint32_t>(filtered[i]);
        if (radius[i] <= detail::kPlainRadius) {
            ASSERT_TRUE(isSame) << radius[i];
        }
        differing += isSame ? 0U : 1U;
        ASSERT_EQ(filtered[i], sampleAt(*field, {x[i], y[i], z[i]}, radius[i]))
            << "a value mustn't depend on its batch";
    }
    EXPECT_GT(differing, 100U) << "the others are filtered";
}

TYPED_TEST(PyramidOf, givesTheBitsOfSixSamplesAsGradientOnEveryInstructionSet)
{
    std::mt19937_64 random(25);
    const glm::ivec3 size(22, 19, 27);
    const auto field =
        fieldOf(size, filled<TypeParam>(size, [&](glm::dvec3) { return this->drawn(random); }));
    constexpr std::size_t kCount = 333;
    std::vector<double> x(kCount);
    std::vector<double> y(kCount);
    std::vector<double> z(kCount);
    std::vector<double> radius(kCount);
    std::uniform_real_distribution<double> unit(-0.1, 1.1);
    for (std::size_t i = 0; i < kCount; ++i) {
        x[i] = 21 * unit(random);
        y[i] = 18 * unit(random);
        z[i] = 26 * unit(random);
        radius[i] = i < 100 ? 0.0 : std::exp2(10 * unit(random) - 2);
        if (i % 7 == 0) // voxels' centres, where a cell ends
            x[i] = std::round(x[i]);
    }
    struct Answer {
        std::vector<float> value = std::vector<float>(kCount);
        std::vector<double> x = std::vector<double>(kCount);
        std::vector<double> y = std::vector<double>(kCount);
        std::vector<double> z = std::vector<double>(kCount);
        bool operator==(const Answer&) const = default;
    };
    for (const bool isFiltered : {false, true}) {
        const fields::SampleBatch batch{
            x, y, z, isFiltered ? std::span<const double>(radius) : std::span<const double>()};
        Answer expected;
        field->sample(batch, expected.value);
        field->Field::gradient(batch, {expected.x, expected.y, expected.z});
        fields::test::onEveryInstructionSet([&](const std::string& target) {
            Answer apart;
            field->sample(batch, apart.value);
            field->gradient(batch, {apart.x, apart.y, apart.z});
            EXPECT_TRUE(apart == expected) << target;
            Answer together;
            field->sampleWithGradient(batch, together.value, {together.x, together.y, together.z});
            EXPECT_TRUE(together == expected) << target;
        });
    }
}

TYPED_TEST(PyramidOf, leavesAConstantAloneAtEveryRadius)
{
    std::mt19937_64 random(13);
    for (const glm::ivec3& size : {glm::ivec3(20, 15, 34), glm::ivec3(1, 2, 3)}) {
        const double constant = static_cast<double>(static_cast<TypeParam>(this->drawn(random)));
        const auto field =
            fieldOf(size, filled<TypeParam>(size, [&](glm::dvec3) { return constant; }));
        std::uniform_real_distribution<double> unit(-0.1, 1.1);
        for (int i = 0; i < 500; ++i) {
            const glm::dvec3 point =
                glm::dvec3(unit(random), unit(random), unit(random)) * glm::dvec3(size);
            ASSERT_EQ(
                sampleAt(*field, point, std::exp2(0.03 * i - 2)), static_cast<float>(constant));
        }
    }
}

TYPED_TEST(PyramidOf, neverExcludesAFilteredSampleFromItsBounds)
{
    std::mt19937_64 random(14);
    for (const glm::ivec3& size :
         {glm::ivec3(45, 18, 31), glm::ivec3(33, 65, 17), glm::ivec3(2, 70, 1)}) {
        const auto field =
            fieldOf(size, filled<TypeParam>(size, [&](glm::dvec3) { return this->drawn(random); }));
        EXPECT_EQ(countExcludedSamples(*field, *field->dataBox(), 1200, 15, 100.0), 0U);
    }
}

TYPED_TEST(PyramidOf, takesLittleMemory)
{
    const glm::ivec3 size(129, 129, 129);
    std::mt19937_64 random(16);
    const auto field =
        fieldOf(size, filled<TypeParam>(size, [&](glm::dvec3) { return this->drawn(random); }));
    const double voxels = 129.0 * 129.0 * 129.0 * sizeof(TypeParam);
    EXPECT_LT(static_cast<double>(field->memoryBytes()), 1.01 * voxels) << "nothing was filtered";
    sampleAt(*field, {1, 1, 1}, 5.0);
    EXPECT_GT(static_cast<double>(field->memoryBytes()), 1.05 * voxels);
    EXPECT_LT(static_cast<double>(field->memoryBytes()), 1.25 * voxels);
}

// ---- What the filter does -----------------------------------------------------------------------

TEST(Pyramid, sumsItsBandsToTheTrilinearVolume)
{
    // What "exact at r = 0" means for the slow twin, whose bands are summed one by one.
    std::mt19937_64 random(17);
    const glm::ivec3 size(17, 14, 33);
    const auto voxels = filled<float>(
        size, [&](glm::dvec3) { return std::uniform_real_distribution<double>(0, 1)(random); });
    const auto field = fieldOf(size, voxels);
    const SlowPyramid twin(size, std::vector<double>(voxels.begin(), voxels.end()));
    for (int i = 0; i < 300; ++i) {
        glm::dvec3 point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = std::uniform_real_distribution<double>(0, size[axis] - 1)(random);
        ASSERT_NEAR(double{sampleAt(*field, point)}, twin.at(point, [](int) { return 1.0; }), 1e-7);
    }
}

TEST(Pyramid, leavesALinearFunctionAloneUpToTheBorderAtEveryRadius)
{
    std::mt19937_64 random(18);
    for (const glm::ivec3& size :
         {glm::ivec3(33, 65, 17), glm::ivec3(34, 50, 19), glm::ivec3(1, 2, 130)}) {
        const auto linear = [](glm::dvec3 p) { return 3 + 2 * p.x - 5 * p.y + 0.25 * p.z; };
        const auto field = fieldOf(size, filled<float>(size, linear));
        for (int i = 0; i < 2000; ++i) {
            glm::dvec3 point;
            for (std::size_t axis = 0; axis < 3; ++axis)
                point[axis] = (size[axis] - 1) *
                              (i % 3 == 0 ? double(random() % 2)
                                          : std::uniform_real_distribution<double>(0, 1)(random));
            ASSERT_NEAR(
                double{sampleAt(*field, point, std::exp2(0.008 * i - 2))}, linear(point), 4e-5)
                << size.x << ' ' << point.x << ' ' << point.y << ' ' << point.z;
        }
    }
}

TEST(Pyramid, dampsAWaveAsItsBandsSayAndMoreWithEveryRadius)
{
    // A level damps by the response of the filters before it, cos^4(pi f 2^j) each, and an
    // interpolation by that of the hat function, sinc^2(f 2^k).
    constexpr double kPi = 3.14159265358979;
    const glm::ivec3 size(257, 9, 9);
    for (const double wavelength : {5.3, 9.1, 17.7, 32.9, 61.0}) {
        const double f = 1 / wavelength;
        const auto field = fieldOf(
            size, filled<float>(size, [&](glm::dvec3 p) { return std::cos(2 * kPi * f * p.x); }));
        double before = 2;
        for (int step = 0; step < 40; ++step) {
            const double radius = 0.2 * std::exp2(0.25 * step);
            const detail::LevelWeights weights = detail::levelWeights(radius, 8);
            double expected = 0;
            for (int i = 0; i < weights.count; ++i) {
                double response = 1;
                for (int j = 0; j < weights.first + i; ++j)
                    response *= std::pow(std::cos(kPi * f * std::exp2(j)), 4);
                const double x = kPi * f * std::exp2(weights.first + i);
                expected += weights.weight[static_cast<std::size_t>(i)] * response *
                            std::pow(std::sin(x) / x, 2);
            }
            // The part of the result that has the wave's frequency, over whole waves, windowed.
            double real = 0;
            double imaginary = 0;
            double total = 0;
            for (double x = 32; x < 224; x += 0.25) {
                const double window = std::pow(std::sin(kPi * (x - 32) / 192), 2);
                const double value = double{sampleAt(*field, {x, 4, 4}, radius)};
                real += window * value * std::cos(2 * kPi * f * x);
                imaginary += window * value * std::sin(2 * kPi * f * x);
                total += window;
            }
            const double amplitude = 2 * std::hypot(real, imaginary) / total;
            EXPECT_NEAR(amplitude, expected, 0.05) << wavelength << ' ' << radius;
            EXPECT_LT(amplitude, before + 0.01) << wavelength << ' ' << radius;
            before = amplitude;
        }
        EXPECT_LT(before, 0.06) << "a large radius leaves nothing of " << wavelength;
    }
}

TEST(Pyramid, isNotPoisonedByValuesThatAreNotFinite)
{
    const glm::ivec3 size(41, 38, 33);
    const glm::dvec3 centre(20, 19, 16);
    std::mt19937_64 random(19);
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(),
          std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()}) {
        const auto ramp = [](glm::dvec3 p) { return 0.5 * p.x + p.y - 0.25 * p.z; };
        auto voxels = filled<float>(size, ramp);
        std::size_t next = 0;
        for (int z = 0; z < size.z; ++z)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x, ++next)
                    if (glm::length(glm::dvec3(x, y, z) - centre) < 7)
                        voxels[next] = bad;
        const auto field = fieldOf(size, voxels);
        std::size_t healed = 0;
        std::size_t spoiled = 0;
        for (int i = 0; i < 20000; ++i) {
            glm::dvec3 point;
            for (std::size_t axis = 0; axis < 3; ++axis)
                point[axis] = std::uniform_real_distribution<double>(0, size[axis] - 1)(random);
            const double radius = std::exp2(std::uniform_real_distribution<double>(-2, 8)(random));
            const float plain = sampleAt(*field, point);
            const float filtered = sampleAt(*field, point, radius);
            if (std::isfinite(plain)) {
                ASSERT_TRUE(std::isfinite(filtered)) << "what is finite stays so";
                ASSERT_GE(filtered, -8.0F);
                ASSERT_LE(filtered, 57.0F);
            } else {
                (std::isfinite(filtered) ? healed : spoiled) += 1;
            }
            if (glm::length(point - centre) > 12 && radius < 2) {
                ASSERT_NEAR(double{filtered}, ramp(point), 0.02) << "far from the ball";
            }
        }
        EXPECT_GT(healed, 100U) << "where only coarse levels count";
        EXPECT_GT(spoiled, 100U) << "where the finest does";
        EXPECT_EQ(countExcludedSamples(*field, *field->dataBox(), 2000, 20, 100.0), 0U);
    }
    const auto nothing =
        fieldOf<float>(glm::ivec3(9), Voxels<float>(729, std::numeric_limits<float>::quiet_NaN()));
    EXPECT_TRUE(std::isnan(sampleAt(*nothing, glm::dvec3(4), 1e3)));
}

TEST(Pyramid, survivesValuesAtTheEndOfFloat)
{
    const glm::ivec3 size(17, 20, 23);
    std::mt19937_64 random(21);
    const auto field = fieldOf(size, filled<float>(size, [&](glm::dvec3) {
                                   return random() % 2 == 0 ? 3.4e38 : -3.4e38;
                               }));
    for (int i = 0; i < 500; ++i)
        ASSERT_TRUE(std::isfinite(sampleAt(*field, glm::dvec3(0.03 * i), std::exp2(0.02 * i - 2))));
    EXPECT_EQ(countExcludedSamples(*field, *field->dataBox(), 500, 22, 50.0), 0U);
}

TEST(Pyramid, hasBoundsThatNarrowAsTheFilterGrows)
{
    // Noise about zero: what a bound over everything says of a strong filter is far less than the
    // noise, or coarse cells would never be skipped.
    const glm::ivec3 size(65, 65, 65);
    std::mt19937_64 random(23);
    const auto field = fieldOf(size, filled<float>(size, [&](glm::dvec3) {
                                   return std::uniform_real_distribution<double>(-1, 1)(random);
                               }));
    const core::Box middle{glm::dvec3(16), glm::dvec3(48)};
    double before = 2;
    for (const double radius : {0.0, 2.0, 8.0, 32.0}) {
        const core::Interval bounds = field->bounds(middle, {radius, radius});
        const double width = bounds.high - bounds.low;
        EXPECT_LT(width, before * (radius > 0 ? 0.9 : 1.01)) << radius;
        before = width;
    }
    EXPECT_LT(before, 0.6);
}

TEST(Pyramid, isBuiltOnceHoweverManyThreadsAskFirst)
{
    const glm::ivec3 size(70, 80, 90);
    std::mt19937_64 random(24);
    const auto voxels = filled<std::int16_t>(
        size, [&](glm::dvec3) { return static_cast<double>(random() % 4096); });
    constexpr std::size_t kCount = 400;
    std::vector<double> x(kCount);
    std::vector<double> y(kCount);
    std::vector<double> z(kCount);
    std::vector<double> radius(kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
        x[i] = static_cast<double>(random() % 69) + 0.25;
        y[i] = static_cast<double>(random() % 79) + 0.75;
        z[i] = static_cast<double>(random() % 89) + 0.5;
        radius[i] = static_cast<double>(random() % 64);
    }
    std::vector<float> expected(kCount);
    fieldOf(size, voxels)->sample({x, y, z, radius}, expected);
    for (int trial = 0; trial < 5; ++trial) {
        const auto field = fieldOf(size, voxels);
        constexpr std::size_t kThreads = 8;
        std::vector<std::vector<float>> values(kThreads, std::vector<float>(kCount));
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < kThreads; ++t)
            threads.emplace_back([&, t] {
                if (t % 2 == 0)
                    (void)field->bounds(*field->dataBox(), {0, 30});
                field->sample({x, y, z, radius}, values[t]);
            });
        for (std::thread& thread : threads)
            thread.join();
        for (const auto& each : values)
            ASSERT_EQ(each, expected);
    }
}

TEST(Pyramid, stepsForGradientsAtTheScaleOfTheFilter)
{
    const auto field = fieldOf<float>(glm::ivec3(4), Voxels<float>(64, 1.0F));
    EXPECT_EQ(field->differenceStep(0), 1.0);
    EXPECT_EQ(field->differenceStep(2), 1.0);
    EXPECT_EQ(field->differenceStep(16), 8.0);
}

} // namespace
} // namespace isofront::volume

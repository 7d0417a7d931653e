#include "HeightPyramid.h"
#include "fields/FieldChecks.h"
#include "support/Random.h"

#include <isofront/elevation/ElevationField.h>
#include <isofront/surface/MeshExtraction.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace isofront::elevation {
namespace {

HeightGrid gridOf(
    int columns, int rows, glm::dvec2 spacing, const std::function<double(double, double)>& height)
{
    HeightGrid grid;
    grid.columns = columns;
    grid.rows = rows;
    grid.spacing = spacing;
    grid.origin = {-300, 150};
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const glm::dvec2 p = grid.origin + spacing * glm::dvec2(column, row);
            grid.heights.push_back(static_cast<float>(height(p.x, p.y)));
        }
    return grid;
}

HeightGrid randomGrid(int columns, int rows, std::uint64_t seed)
{
    auto random = tests::random(seed);
    return gridOf(columns, rows, {30, 45}, [&](double, double) {
        return tests::uniform(random, -100, 2000);
    });
}

struct Points {
    std::vector<double> x, y, z, radius;
    [[nodiscard]] fields::SampleBatch batch() const { return {x, y, z, radius}; }
};

Points randomPoints(const core::Box& box, double radius, std::size_t count, std::uint64_t seed)
{
    auto random = tests::random(seed);
    Points points;
    for (std::size_t i = 0; i < count; ++i) {
        points.x.push_back(tests::uniform(random, box.low.x, box.high.x));
        points.y.push_back(tests::uniform(random, box.low.y, box.high.y));
        points.z.push_back(tests::uniform(random, box.low.z, box.high.z));
        points.radius.push_back(
            random() % 4 == 0 ? 0.0 : std::exp2(tests::uniform(random, -8, std::log2(radius))));
    }
    return points;
}

double heightAt(const ElevationField& field, double x, double y, double radius = 0)
{
    const double z = 0;
    float value = 0;
    field.sample({{&x, 1}, {&y, 1}, {&z, 1}, {&radius, 1}}, {&value, 1});
    return double(value);
}

TEST(ElevationField, goesThroughEveryPostExactly)
{
    const HeightGrid grid = randomGrid(23, 17, 1);
    const ElevationField field(grid, 100);
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column)
            ASSERT_EQ(
                heightAt(field, grid.origin.x + 30 * column, grid.origin.y + 45 * row),
                double(grid.heights[grid.index(column, row)]));
}

TEST(ElevationField, leavesAPlaneAPlaneAtEveryRadius)
{
    const auto plane = [](double x, double y) { return 400 + 0.3 * x - 0.7 * y; };
    for (const auto& [columns, rows] : {std::pair{2, 2}, {2, 40}, {3, 7}, {33, 33}, {50, 21}}) {
        const HeightGrid grid = gridOf(columns, rows, {30, 45}, plane);
        const ElevationField field(grid, 100);
        const Points points = randomPoints(*field.dataBox(), 5000, 500, 2);
        for (std::size_t i = 0; i < points.x.size(); ++i)
            ASSERT_NEAR(
                heightAt(field, points.x[i], points.y[i], points.radius[i]),
                plane(points.x[i], points.y[i]),
                0.002)
                << columns << " x " << rows << ", radius " << points.radius[i];
    }
}

TEST(ElevationField, stopsAtItsBorderAndTakesNumbersThatAreNone)
{
    const ElevationField field(randomGrid(9, 6, 3), 100);
    const core::Box box = *field.dataBox();
    EXPECT_EQ(heightAt(field, box.low.x - 1e9, box.low.y), heightAt(field, box.low.x, box.low.y));
    EXPECT_EQ(heightAt(field, box.high.x, 1e300), heightAt(field, box.high.x, box.high.y));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(heightAt(field, nan, nan), heightAt(field, box.low.x, box.low.y));
    for (const double radius : {nan, 1e300, -1.0})
        EXPECT_TRUE(std::isfinite(heightAt(field, box.low.x + 40, box.low.y + 50, radius)))
            << radius;
}

/// The same pyramid, written in the plainest way: bands d_k = g_k - U(g_(k+1)) in double.
class PlainPyramid {
public:
    explicit PlainPyramid(const HeightGrid& grid) : _spacing(std::sqrt(30.0 * 45.0))
    {
        Level level{grid.columns, grid.rows, {grid.heights.begin(), grid.heights.end()}};
        while (true) {
            _levels.push_back(level);
            if (level.columns <= 2 && level.rows <= 2)
                return;
            Level next{level.columns / 2 + 1, level.rows / 2 + 1, {}};
            for (int row = 0; row < next.rows; ++row)
                for (int column = 0; column < next.columns; ++column) {
                    constexpr std::array<double, 5> kBinomial{1, 4, 6, 4, 1};
                    double sum = 0;
                    for (int j = -2; j <= 2; ++j)
                        for (int i = -2; i <= 2; ++i)
                            sum += kBinomial[std::size_t(i + 2)] * kBinomial[std::size_t(j + 2)] *
                                   level.at(2 * column + i, 2 * row + j);
                    next.values.push_back(sum / 256);
                }
            level = next;
        }
    }

    /// Sum of the bands, each with its weight; u and v in posts.
    [[nodiscard]] double at(double u, double v, double radius) const
    {
        double sum = _levels.back().spline(u, v, _levels.size() - 1);
        for (std::size_t k = 0; k + 1 < _levels.size(); ++k) {
            const double x = 0.3 * std::exp2(-double(k)) / _spacing * radius;
            const double weight = x < 1.0 / 64 ? 1 : x >= 3 ? 0 : std::exp(-x * x);
            sum += weight * (_levels[k].spline(u, v, k) - _levels[k + 1].spline(u, v, k + 1));
        }
        return sum;
    }

private:
    struct Level {
        int columns, rows;
        std::vector<double> values;

        [[nodiscard]] double at(int column, int row) const
        {
            if (column < 0)
                return 2 * at(0, row) - at(-column, row);
            if (column >= columns)
                return 2 * at(columns - 1, row) - at(2 * (columns - 1) - column, row);
            if (row < 0)
                return 2 * at(column, 0) - at(column, -row);
            if (row >= rows)
                return 2 * at(column, rows - 1) - at(column, 2 * (rows - 1) - row);
            return values[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
        }
        static double cubic(double a, double b, double c, double d, double t)
        {
            return b +
                   0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
        }
        [[nodiscard]] double spline(double u, double v, std::size_t k) const
        {
            const double s = std::ldexp(u, -int(k));
            const double t = std::ldexp(v, -int(k));
            const int column = std::min(int(s), columns - 2);
            const int row = std::min(int(t), rows - 2);
            std::array<double, 4> across{};
            for (int j = 0; j < 4; ++j)
                across[std::size_t(j)] = cubic(
                    at(column - 1, row - 1 + j),
                    at(column, row - 1 + j),
                    at(column + 1, row - 1 + j),
                    at(column + 2, row - 1 + j),
                    s - column);
            return cubic(across[0], across[1], across[2], across[3], t - row);
        }
    };

    double _spacing;
    std::vector<Level> _levels;
};

TEST(ElevationField, isTheLaplacianPyramidOfItsPosts)
{
    auto random = tests::random(4);
    for (int trial = 0; trial < 12; ++trial) {
        const int columns = 2 + static_cast<int>(random() % 40);
        const int rows = 2 + static_cast<int>(random() % 40);
        const HeightGrid grid = randomGrid(columns, rows, random());
        const ElevationField field(grid, 100);
        const PlainPyramid plain(grid);
        const Points points = randomPoints(*field.dataBox(), 3000, 300, random());
        for (std::size_t i = 0; i < points.x.size(); ++i) {
            const double u = (points.x[i] - grid.origin.x) / 30;
            const double v = (points.y[i] - grid.origin.y) / 45;
            // 2100 m of range, by floats and weights that are good to 1e-5
            ASSERT_NEAR(
                heightAt(field, points.x[i], points.y[i], points.radius[i]),
                plain.at(u, v, points.radius[i]),
                0.05)
                << columns << " x " << rows << ", radius " << points.radius[i];
        }
    }
}

TEST(ElevationField, dampsAWaveTheMoreTheLargerTheRadius)
{
    for (const double posts : {4.0, 8.0, 16.0}) {
        const double wavelength = 30 * posts;
        const ElevationField field(
            gridOf(
                257,
                257,
                {30, 30},
                [&](double x, double) {
                    return 100 * std::sin(2 * std::numbers::pi * (x + 300) / wavelength);
                }),
            100);
        const double crest = -300 + wavelength * (std::floor(128 / posts) + 0.25);
        double before = heightAt(field, crest, 4000);
        EXPECT_NEAR(before, 100, 3);
        for (double radius = 1; radius < 3000; radius *= 1.1) {
            const double amplitude = heightAt(field, crest, 4000, radius);
            ASSERT_LE(amplitude, before + 1e-3) << radius;
            before = amplitude;
        }
        EXPECT_NEAR(before, 0, 1);
        // What the lattice could hold stays, what it could not is gone.
        EXPECT_GT(heightAt(field, crest, 4000, wavelength / 32), 95);
        EXPECT_LT(heightAt(field, crest, 4000, wavelength * 2), 15);
    }
}

TEST(ElevationField, givesTheDerivativesOfItsHeights)
{
    const ElevationField field(randomGrid(33, 29, 5), 100);
    const Points points = randomPoints(*field.dataBox(), 2000, 400, 6);
    std::vector<float> values(400);
    std::vector<float> alone(400);
    std::array<std::vector<double>, 3> g{
        std::vector<double>(400), std::vector<double>(400), std::vector<double>(400)};
    std::array<std::vector<double>, 3> h = g;
    field.sampleWithGradient(points.batch(), values, {g[0], g[1], g[2]});
    field.gradient(points.batch(), {h[0], h[1], h[2]});
    field.sample(points.batch(), alone);
    EXPECT_EQ(values, alone);
    EXPECT_EQ(g, h);
    constexpr double kStep = 0.25;
    for (std::size_t i = 0; i < 400; ++i) {
        const double x = points.x[i];
        const double y = points.y[i];
        const double r = points.radius[i];
        const double dx = heightAt(field, x + kStep, y, r) - heightAt(field, x - kStep, y, r);
        const double dy = heightAt(field, x, y + kStep, r) - heightAt(field, x, y - kStep, r);
        const core::Box box = *field.dataBox();
        if (x - box.low.x < 1 || box.high.x - x < 1 || y - box.low.y < 1 || box.high.y - y < 1)
            continue;
        ASSERT_NEAR(g[0][i], dx / (2 * kStep), 0.25) << r;
        ASSERT_NEAR(g[1][i], dy / (2 * kStep), 0.25) << r;
        ASSERT_EQ(g[2][i], -1);
    }
}

TEST(ElevationField, givesTheSameBitsWhereverAPointStandsInItsBatchOnEveryInstructionSet)
{
    const ElevationField field(randomGrid(40, 40, 7), 100);
    const Points points = randomPoints(*field.dataBox(), 500, 200, 8);
    struct Answer {
        std::vector<float> value = std::vector<float>(200);
        std::vector<double> x = std::vector<double>(200);
        std::vector<double> y = std::vector<double>(200);
        std::vector<double> z = std::vector<double>(200);
        bool operator==(const Answer&) const = default;
    };
    Answer alone;
    for (std::size_t i = 0; i < 200; ++i)
        field.sampleWithGradient(
            {{&points.x[i], 1}, {&points.y[i], 1}, {&points.z[i], 1}, {&points.radius[i], 1}},
            {&alone.value[i], 1},
            {{&alone.x[i], 1}, {&alone.y[i], 1}, {&alone.z[i], 1}});
    fields::test::onEveryInstructionSet([&](const std::string& target) {
        Answer whole;
        field.sampleWithGradient(points.batch(), whole.value, {whole.x, whole.y, whole.z});
        EXPECT_TRUE(whole == alone) << target;
        std::vector<float> values(200);
        field.sample(points.batch(), values);
        EXPECT_EQ(values, alone.value) << target;
    });
}

TEST(ElevationField, neverExcludesASampleFromItsBounds)
{
    auto random = tests::random(9);
    std::size_t tight = 0;
    constexpr std::size_t kBoxes = 3000;
    for (const auto& [columns, rows] : {std::pair{2, 2}, {5, 60}, {200, 150}}) {
        const ElevationField field(randomGrid(columns, rows, random()), 100);
        const core::Box range = *field.dataBox();
        for (std::size_t b = 0; b < kBoxes; ++b) {
            core::Box box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double size = range.size()[axis] * std::exp2(-tests::uniform(random, 0, 9));
                box.low[axis] = tests::uniform(
                    random, range.low[axis] - 0.1 * size, range.high[axis] - 0.9 * size);
                box.high[axis] = box.low[axis] + size;
                if (b % 3 == 0 && axis < 2) { // on posts
                    const double step = axis == 0 ? 30 : 45;
                    const double origin = axis == 0 ? -300 : 150;
                    box.low[axis] = origin + step * std::floor((box.low[axis] - origin) / step);
                    box.high[axis] = box.low[axis] + step * std::ceil(size / step);
                }
            }
            const double most = b % 2 == 0 ? 0 : std::exp2(tests::uniform(random, -3, 11));
            const double least = b % 4 == 1 ? 0 : most * tests::uniform(random, 0, 1);
            const core::Interval bounds = field.bounds(box, {least, most});
            Points points = randomPoints(box, 1, 40, random());
            for (double& radius : points.radius)
                radius = tests::uniform(random, least, most);
            points.x[0] = box.low.x; // corners are part of the box
            points.y[0] = box.high.y;
            points.z[0] = box.low.z;
            std::vector<float> values(points.x.size());
            field.sample(points.batch(), values);
            for (const float value : values)
                ASSERT_TRUE(bounds.contains(double(value)))
                    << value << " not in [" << bounds.low << ", " << bounds.high << "], radius "
                    << least << " to " << most;
            const auto [low, high] = std::minmax_element(values.begin(), values.end());
            if (bounds.high - bounds.low < 4 * double(*high - *low))
                ++tight;
        }
    }
    EXPECT_GT(tight, kBoxes); // and they say something
}

TEST(FilterWeight, isTheExponentialFromOneToZeroWithoutEverRising)
{
    double before = 1;
    for (double x = 0; x < 3.2; x += 0.0007) {
        const double weight = filterWeight(x);
        EXPECT_NEAR(weight, std::exp(-x * x), 3e-4) << x;
        ASSERT_LE(weight, before);
        before = weight;
    }
    EXPECT_EQ(filterWeight(0), 1);
    EXPECT_EQ(filterWeight(0.0156), 1);
    EXPECT_EQ(filterWeight(3), 0);
    EXPECT_EQ(filterWeight(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(ElevationField, enclosesTheVolumeUnderItsGround)
{
    // A dome: the volume between the data box's floor and the ground is that of the heights.
    const auto dome = [](double x, double y) {
        const double dx = (x - 180) / 480;
        const double dy = (y - 630) / 480;
        return 900 * std::exp(-dx * dx - dy * dy);
    };
    const HeightGrid grid = gridOf(33, 33, {30, 30}, dome);
    const auto field = std::make_shared<const ElevationField>(grid, 120);
    const core::Box box = *field->dataBox();
    double under = 0; // by the trapezoidal rule, as fine as the mesh
    constexpr int kSteps = 512;
    for (int j = 0; j <= kSteps; ++j)
        for (int i = 0; i <= kSteps; ++i) {
            const double share =
                (i % kSteps == 0 ? 0.5 : 1.0) * (j % kSteps == 0 ? 0.5 : 1.0) / kSteps / kSteps;
            under += share * (heightAt(
                                  *field,
                                  box.low.x + box.size().x * i / kSteps,
                                  box.low.y + box.size().y * j / kSteps) -
                              box.low.z);
        }
    const double expected = under * box.size().x * box.size().y;

    // The domain's walls are apart from those of the data on all sides, so that the mesh closes.
    const hierarchy::Domain domain{box.centre() - 1024.0, 2048};
    std::array<std::vector<glm::dvec3>, 2> positions;
    for (const double filter : {0.0, 1.0}) {
        for (const bool skipEmpty : {true, false}) {
            extractor::ExtractionSettings settings;
            settings.latticeSize = 4;
            settings.filterStrength = filter;
            settings.closed = true;
            settings.skipEmptyCells = skipEmpty;
            const auto jobs = core::makeJobs(core::JobsBackend::automatic, 2);
            surface::MeshExtractionOptions options;
            options.detail.level = 12;
            const auto extracted = surface::extractMesh(
                std::make_shared<const extractor::CellExtractor>(field, domain, settings),
                *jobs,
                options);
            ASSERT_TRUE(extracted) << extracted.error().message;
            const surface::TriangleMesh& mesh = extracted->mesh;
            double volume = 0;
            for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
                const auto corner = [&](std::size_t i) {
                    return mesh.positions[mesh.indices[t + i]] - box.centre();
                };
                volume += glm::dot(corner(0), glm::cross(corner(1), corner(2))) / 6;
            }
            EXPECT_NEAR(volume / expected, 1, filter > 0 ? 0.02 : 0.01);
            positions[skipEmpty ? 0 : 1].assign(mesh.positions.begin(), mesh.positions.end());
        }
        EXPECT_EQ(positions[0], positions[1]) << "bounds have left something out";
    }
}

} // namespace
} // namespace isofront::elevation

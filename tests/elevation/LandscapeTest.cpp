#include "support/Random.h"

#include <isofront/elevation/Landscape.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace isofront::elevation {
namespace {

/// Hills of 300 m every kilometre or so, posts 30 m apart.
LoadedElevation hills()
{
    HeightGrid grid;
    grid.columns = grid.rows = 129;
    grid.spacing = {30, 30};
    grid.origin = {-1920, -1920};
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column)
            grid.heights.push_back(
                static_cast<float>(300 * std::sin(column * 0.17) * std::cos(row * 0.13)));
    LoadedElevation loaded;
    loaded.info.columns = loaded.info.rows = 129;
    loaded.info.spacing = {30, 30};
    loaded.field = std::make_shared<const ElevationField>(std::move(grid), 200);
    loaded.dataBox = *loaded.field->dataBox();
    return loaded;
}

std::vector<float>
column(const fields::Field& field, double x, double y, const std::vector<double>& z, double radius)
{
    std::vector<double> xs(z.size(), x);
    std::vector<double> ys(z.size(), y);
    std::vector<double> radii(z.size(), radius);
    std::vector<float> values(z.size());
    field.sample({xs, ys, z, radii}, values);
    return values;
}

TEST(Landscape, overhangsOnlyWhereItIsRugged)
{
    const LoadedElevation ground = hills();
    std::vector<double> z;
    for (double height = -400; height < 400; height += 1)
        z.push_back(height);
    const auto overhangs = [&](const fields::Field& field) {
        int count = 0;
        for (double x = -1800; x < 1800; x += 60)
            for (double y = -1800; y < 1800; y += 60) {
                const std::vector<float> values = column(field, x, y, z, 0);
                for (std::size_t i = 1; i < values.size(); ++i)
                    count += values[i - 1] < 0 && values[i] >= 0 ? 1 : 0; // solid over air
            }
        return count;
    };
    EXPECT_EQ(overhangs(*ground.field), 0);
    const auto rugged = landscape(ground, {.preset = "rugged"});
    ASSERT_TRUE(rugged);
    EXPECT_GT(overhangs(**rugged), 20);
}

TEST(Landscape, keepsToItsBoundsAndToTheRastersBox)
{
    const LoadedElevation ground = hills();
    auto random = tests::random(17);
    for (const LandscapePreset& preset : landscapePresets()) {
        const auto made = landscape(ground, {.preset = preset.name});
        ASSERT_TRUE(made);
        const fields::Field& field = **made;
        ASSERT_TRUE(field.dataBox());
        EXPECT_EQ(field.dataBox()->low, ground.dataBox.low);
        EXPECT_EQ(field.dataBox()->high, ground.dataBox.high);
        for (int b = 0; b < 500; ++b) {
            const double size = std::exp2(tests::uniform(random, 0, 10));
            core::Box box;
            box.low = {
                tests::uniform(random, -1900, 1900 - size),
                tests::uniform(random, -1900, 1900 - size),
                tests::uniform(random, -500, 500)};
            box.high = box.low + size;
            const double most = b % 2 == 0 ? 0 : size / 8;
            const core::Interval bounds = field.bounds(box, {0, most});
            std::vector<double> z;
            for (int i = 0; i < 20; ++i)
                z.push_back(tests::uniform(random, box.low.z, box.high.z));
            for (const float value : column(
                     field,
                     tests::uniform(random, box.low.x, box.high.x),
                     tests::uniform(random, box.low.y, box.high.y),
                     z,
                     tests::uniform(random, 0, most)))
                ASSERT_TRUE(bounds.contains(double(value))) << preset.name;
        }
    }
}

TEST(Landscape, isTheFilteredRasterFromAfar)
{
    const LoadedElevation ground = hills();
    const auto natural = landscape(ground);
    ASSERT_TRUE(natural);
    auto random = tests::random(18);
    double near = 0;
    for (int i = 0; i < 300; ++i) {
        const double x = tests::uniform(random, -1800, 1800);
        const double y = tests::uniform(random, -1800, 1800);
        const std::vector<double> z{tests::uniform(random, -300, 300)};
        // beyond three wavelengths of the longest wave nothing of it is left
        EXPECT_NEAR(
            column(**natural, x, y, z, 200)[0],
            0.8 * double(column(*ground.field, x, y, z, 200)[0]),
            1e-3);
        near = std::max(
            near,
            std::abs(
                double(column(**natural, x, y, z, 0)[0]) -
                0.8 * double(column(*ground.field, x, y, z, 0)[0])));
    }
    EXPECT_GT(near, 0.3);
    EXPECT_LT(near, 6);
}

TEST(Landscape, ofUnknownNameListsTheKnownOnes)
{
    const auto made = landscape(hills(), {.preset = "flat"});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, core::ErrorCode::usage);
    EXPECT_NE(made.error().message.find("natural, rugged"), std::string::npos);
}

} // namespace
} // namespace isofront::elevation

// Colours of textured triangles.

#include "LinearColour.h"
#include "MipMap.h"
#include "Models.h"
#include "support/Random.h"

#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

namespace isofront::voxels {
namespace {

Texture textureOf(int width, int height, const std::function<std::uint32_t(int, int)>& colour)
{
    Texture texture;
    texture.image.width = width;
    texture.image.height = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (unsigned i = 0; i < 4; ++i)
                texture.image.rgba.push_back(
                    static_cast<std::uint8_t>(colour(x, y) >> 8 * i & 0xffU));
    return texture;
}

/// The unit square in the plane z = 0 with a whole texture on it.
TriangleModel square(Texture texture)
{
    TriangleModel model;
    model.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    model.triangles = {{0, 1, 2}, {0, 2, 3}};
    model.textures.push_back(std::move(texture));
    model.textureOf = {0, 0};
    model.textureCorners = {
        {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1)},
        {glm::vec2(0, 0), glm::vec2(1, 1), glm::vec2(0, 1)}};
    return model;
}

TEST(MipMaps, haveTheMeanOfAllLight)
{
    auto random = tests::random(1);
    for (const auto& [width, height] : {std::pair{1, 1}, {64, 64}, {64, 4}, {1, 32}}) {
        const Texture texture = textureOf(width, height, [&](int, int) {
            return static_cast<std::uint32_t>(random()) | 0xff000000U;
        });
        std::array<double, 3> mean{};
        for (std::size_t i = 0; i < texture.image.rgba.size(); ++i)
            if (i % 4 < 3)
                mean[i % 4] += static_cast<double>(linear(texture.image.rgba[i])) /
                               (static_cast<double>(width) * height);
        const MipMap map(texture);
        for (int trial = 0; trial < 5; ++trial) {
            const auto colour =
                map.at({tests::uniform(random, -9, 9), tests::uniform(random, 0, 1)}, 1e9);
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_NEAR(double(colour[i]), mean[i], 2e-4);
            EXPECT_NEAR(double(colour[3]), 1, 1e-6);
        }
    }
}

TEST(MipMaps, giveEachPixelItsOwnColourInItsMiddle)
{
    auto random = tests::random(2);
    for (const auto wrap : {Texture::Wrap::repeat, Texture::Wrap::clamp, Texture::Wrap::mirror}) {
        Texture texture = textureOf(
            5, 3, [&](int, int) { return static_cast<std::uint32_t>(random()) | 0xff000000U; });
        texture.acrossX = wrap;
        texture.acrossY = wrap;
        const MipMap map(texture);
        const auto expected = [&](int x, int size) {
            if (wrap == Texture::Wrap::clamp)
                return std::clamp(x, 0, size - 1);
            const int period = wrap == Texture::Wrap::repeat ? size : 2 * size;
            const int in = (x % period + period) % period;
            return in < size ? in : 2 * size - 1 - in;
        };
        for (int y = -7; y < 8; ++y)
            for (int x = -12; x < 12; ++x) {
                const auto colour = map.at({(x + 0.5) / 5, (y + 0.5) / 3}, 0.1);
                const std::uint8_t* const pixel =
                    texture.image.pixel(expected(x, 5), expected(y, 3));
                for (std::size_t i = 0; i < 3; ++i)
                    ASSERT_NEAR(colour[i], linear(pixel[i]), 2e-5F) << x << " " << y;
            }
        for (const double odd : {HUGE_VAL, -HUGE_VAL, std::nan(""), 1e300})
            for (const float value : map.at({odd, 0}, odd))
                EXPECT_TRUE(value >= 0 && value <= 1.001F);
    }
}

TEST(MipMaps, leaveOutWhatCantBeSeen)
{
    // red where it is opaque; the rest would be green
    const MipMap map(
        textureOf(8, 8, [](int x, int) { return x % 2 == 0 ? 0xff0000ffU : 0x0000ff00U; }));
    const auto colour = map.at({0.5, 0.5}, 1e6);
    EXPECT_NEAR(colour[0], 0.5F, 1e-4F);
    EXPECT_EQ(colour[1], 0);
    EXPECT_NEAR(colour[3], 0.5F, 1e-4F);
}

/// Coarse and fine: a voxel has the mean light of what of the texture lies in it.
TEST(Textures, giveVoxelsTheirMeanLight)
{
    constexpr int kSize = 256;
    const auto light = [](double x, double y) {
        return std::array<double, 2>{
            0.5 + 0.45 * std::sin(5 * x + 1), 0.5 + 0.45 * std::cos(4 * y + x)};
    };
    const auto code = [](double c) {
        const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
        return static_cast<std::uint32_t>(std::lround(255 * s));
    };
    Texture texture = textureOf(kSize, kSize, [&](int x, int y) {
        const auto [red, green] = light((x + 0.5) / kSize, (y + 0.5) / kSize);
        return code(red) | code(green) << 8U | 0xff800000U;
    });
    texture.acrossX = Texture::Wrap::clamp;
    texture.acrossY = Texture::Wrap::clamp;
    const TriangleModel model = square(std::move(texture));
    for (const std::uint32_t resolution : {7U, 40U, 200U, 500U}) {
        tests::KeptChunks kept;
        const auto jobs = core::makeJobs(core::JobsBackend::inlined);
        VoxelizationSettings settings;
        settings.resolution = resolution;
        const auto report = voxelize(model, settings, kept, *jobs);
        ASSERT_TRUE(report) << report.error().message;
        std::size_t voxels = 0;
        for (const auto& [key, chunk] : kept.chunks) {
            if (key.level > 0)
                continue;
            ASSERT_EQ(chunk.colours.size(), chunk.voxels.size());
            for (std::size_t i = 0; i < chunk.voxels.size(); ++i, ++voxels) {
                const double edge = report->lattice.edge;
                const auto span = [&](std::uint32_t place, std::uint32_t of, double origin) {
                    const double low = origin + edge * (place + kChunkEdge * of);
                    return std::pair{std::max(low, 0.0), std::min(low + edge, 1.0)};
                };
                const auto [x0, x1] = span(chunk.voxels[i].x(), key.x, report->lattice.origin.x);
                const auto [y0, y1] = span(chunk.voxels[i].y(), key.y, report->lattice.origin.y);
                std::array<double, 2> mean{};
                constexpr int kParts = 8;
                for (int j = 0; j < kParts; ++j)
                    for (int k = 0; k < kParts; ++k) {
                        const auto one = light(
                            x0 + (x1 - x0) * (k + 0.5) / kParts,
                            y0 + (y1 - y0) * (j + 0.5) / kParts);
                        for (std::size_t channel = 0; channel < 2; ++channel)
                            mean[channel] += one[channel] / (kParts * kParts);
                    }
                // a coarse voxel is filtered over some of what lies around it
                const double allowed = resolution < 10 ? 12 : 3;
                for (unsigned channel = 0; channel < 2; ++channel)
                    ASSERT_NEAR(
                        chunk.colours[i] >> 8 * channel & 0xffU, code(mean[channel]), allowed)
                        << resolution;
                ASSERT_EQ(chunk.colours[i] >> 16U, 0xff80U);
            }
        }
        EXPECT_EQ(voxels, std::size_t{resolution} * resolution);
    }
}

TEST(Textures, multiplyTheColoursOfPositions)
{
    TriangleModel model = square(textureOf(1, 1, [](int, int) { return 0xffbcbcbcU; }));
    model.colours.assign(4, 0x80bcff00U);
    model.textureOf[1] = kNoTexture;
    tests::KeptChunks kept;
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    ASSERT_TRUE(voxelize(model, {.resolution = 50}, kept, *jobs));
    std::set<std::uint32_t> colours;
    for (const auto& [key, chunk] : kept.chunks)
        colours.insert(chunk.colours.begin(), chunk.colours.end());
    // a half of light (188) of each channel, and where there is no texture, the colour itself;
    // along the diagonal there are mixtures
    EXPECT_TRUE(colours.contains(0x80bcff00U));
    EXPECT_TRUE(colours.contains(0x808abc00U)) << "188 of 188 is a quarter of light, 138";
}

TEST(Textures, thatDontFitTheModelAreRefused)
{
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    const auto refused = [&](const std::function<void(TriangleModel&)>& change) {
        TriangleModel model = square(textureOf(2, 2, [](int, int) { return 0xffffffffU; }));
        tests::KeptChunks kept;
        EXPECT_TRUE(voxelize(model, {.resolution = 4}, kept, *jobs));
        change(model);
        tests::KeptChunks none;
        const auto result = voxelize(model, {.resolution = 4}, none, *jobs);
        return !result && result.error().code == core::ErrorCode::badData;
    };
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textureOf[1] = 1; }));
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textureOf.pop_back(); }));
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textureCorners.pop_back(); }));
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textures[0].image.rgba.pop_back(); }));
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textures[0].image.width = 0; }));
    EXPECT_TRUE(refused([](TriangleModel& m) { m.textures[0].image.height = -2; }));
}

} // namespace
} // namespace isofront::voxels

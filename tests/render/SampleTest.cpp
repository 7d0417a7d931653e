#include "Samples.h"
#include "render/support/VoxelFixture.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::test {
namespace {

const hierarchy::Domain kDomain{.edge = 64.0};

double linear(std::uint8_t code)
{
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double code(double light)
{
    return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

/// A cube of voxels, of which only the shell is there.
Chunk shell(std::uint32_t low, std::uint32_t high)
{
    Chunk chunk;
    for (std::uint32_t z = low; z <= high; ++z)
        for (std::uint32_t y = low; y <= high; ++y)
            for (std::uint32_t x = low; x <= high; ++x) {
                glm::dvec3 normal(0);
                std::uint8_t faces = 0;
                const std::array at{x, y, z};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    if (at[axis] != low && at[axis] != high)
                        continue;
                    faces =
                        static_cast<std::uint8_t>(faces | (at[axis] == low ? 1U : 2U) << 2 * axis);
                    normal[axis] = at[axis] == low ? -1 : 1;
                }
                if (faces != 0)
                    chunk.voxels.push_back(
                        {voxels::packPlace(x, y, z, faces), voxels::packNormal(normal)});
            }
    return chunk;
}

class Samples : public VoxelFixture {
protected:
    /// As many samples as the device has, beyond one; 1 if it has no more.
    [[nodiscard]] int most() const
    {
        for (const int samples : {8, 4})
            if (render::checkSamples(*device, samples))
                return samples;
        return 1;
    }
    std::unique_ptr<render::Renderer> rendererOf(int samples)
    {
        render::RendererOptions wanted = options();
        wanted.samples = samples;
        return renderer(kDomain, wanted);
    }
};

TEST_F(Samples, areThoseOfAPictureWithMorePixels)
{
    const int samples = most();
    if (samples == 1)
        GTEST_SKIP() << "the device has one sample a pixel";
    // Where a picture of so many times more pixels has the middles of its own.
    const int finer = samples == 4 ? 4 : 8;
    const Chunk chunk = shell(24, 40);
    const VoxelDraw draw{chunk.key};
    const std::vector<surface::ShownCell> ball = cut(sphere({0.6, 0.45, 0.5}, 0.17, 24), 2, 1);
    const auto several = rendererOf(samples);
    const auto one = rendererOf(1);
    for (render::Renderer* each : {several.get(), one.get()}) {
        show(*each, showing(ball));
        add(*each, {&chunk, 1});
    }
    const hierarchy::View view = lookingAt({2, -30, 59}, {34, 32, 32}, 72, 54);
    hierarchy::View large = view;
    large.width *= finer;
    large.height *= finer;
    for (const VoxelWay way : kWays) {
        const render::VoxelScene scene{.lattice = {.edge = 1.0}, .draws = {&draw, 1}, .way = way};
        const VoxelShot shot = shootVoxels(*several, view, scene);
        const VoxelShot fine = shootVoxels(*one, large, scene);
        std::size_t far = 0;
        std::size_t odd = 0;
        std::size_t edges = 0;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const auto pixel = static_cast<std::size_t>(y * view.width + x);
                std::array<double, 3> sum{};
                std::vector<float> depths;
                std::size_t first = 0;
                for (const glm::ivec2& place : render::samplePlaces(samples)) {
                    const int column = x * finer + place.x * finer / 16;
                    const int row = y * finer + place.y * finer / 16;
                    const auto at = static_cast<std::size_t>(row * large.width + column);
                    for (std::size_t i = 0; i < 3; ++i)
                        sum[i] += linear(fine.image.rgba[4 * at + i]) / samples;
                    first = depths.empty() ? at : first;
                    depths.push_back(fine.depth[at]);
                }
                double most = 0;
                for (std::size_t i = 0; i < 3; ++i)
                    most = std::max(most, std::abs(code(sum[i]) - shot.image.rgba[4 * pixel + i]));
                far += most > 3 ? 1U : 0U;
                const auto [least, greatest] = std::ranges::minmax(depths);
                edges += least < 0.9F * greatest ? 1U : 0U;
                const float depth = fine.depth[first];
                odd += std::abs(shot.depth[pixel] - depth) > 1e-4F * depth ? 1U : 0U;
                odd += shot.voxels[pixel] == fine.voxels[first] ? 0U : 1U;
            }
        EXPECT_GT(edges, 30U);
        // Normals of a mesh's triangles are taken in the middle of what is covered of a pixel.
        EXPECT_LE(far, shot.depth.size() / 100) << (way == VoxelWay::cubes ? "cubes" : "splats");
        EXPECT_LE(odd, shot.depth.size() / 200) << (way == VoxelWay::cubes ? "cubes" : "splats");
    }
}

TEST_F(Samples, coverAnEdgeByTheirNumber)
{
    const int samples = most();
    if (samples == 1)
        GTEST_SKIP() << "the device has one sample a pixel";
    // A cube of one voxel; the sky behind is white.
    const Chunk chunk{.key = {}, .voxels = {{voxels::packPlace(9, 9, 9, 63), 511U << 20U}}};
    const VoxelDraw draw{chunk.key};
    const glm::dvec3 eye(9.3, 8.9, 40);
    const hierarchy::View view = lookingAt(eye, {9.5, 9.6, 9}, 60, 60);
    const auto shown = rendererOf(samples);
    add(*shown, {&chunk, 1});
    for (const VoxelWay way : kWays) {
        hierarchy::View near = view;
        near.verticalFieldOfView = 0.06;
        const VoxelShot shot = shootVoxels(
            *shown,
            near,
            {.lattice = {.edge = 1.0}, .draws = {&draw, 1}, .way = way},
            {.look = render::Look::studio, .backdrop = glm::vec3(1)});
        const auto coverage = [&](int x, int y) {
            const glm::dvec3 middle = pixelRay(near, x, y);
            const glm::dvec3 right = pixelRay(near, x + 1, y) - middle;
            const glm::dvec3 down = pixelRay(near, x, y + 1) - middle;
            int inside = 0;
            for (const glm::ivec2& place : render::samplePlaces(samples)) {
                const glm::dvec3 ray =
                    middle + (place.x - 8) / 16.0 * right + (place.y - 8) / 16.0 * down;
                const glm::dvec3 a = (glm::dvec3(9) - eye) / ray;
                const glm::dvec3 b = (glm::dvec3(10) - eye) / ray;
                const glm::dvec3 from = glm::min(a, b);
                const glm::dvec3 to = glm::max(a, b);
                inside += std::max({from.x, from.y, from.z}) < std::min({to.x, to.y, to.z}) ? 1 : 0;
            }
            return inside;
        };
        // The face itself is nearly of one colour.
        const double face = linear(*shot.image.pixel(30, 30));
        ASSERT_EQ(coverage(30, 30), samples);
        std::vector<std::size_t> met(static_cast<std::size_t>(samples) + 1);
        std::size_t odd = 0;
        for (int y = 0; y < near.height; ++y)
            for (int x = 0; x < near.width; ++x) {
                const int inside = coverage(x, y);
                ++met[static_cast<std::size_t>(inside)];
                const double share = static_cast<double>(inside) / samples;
                const double expected = code(share * face + (1 - share));
                odd += std::abs(expected - *shot.image.pixel(x, y)) > 3 ? 1U : 0U;
            }
        // The rasteriser rounds corners.
        EXPECT_LE(odd, way == VoxelWay::cubes ? 2U : 0U);
        for (const std::size_t count : met)
            EXPECT_GT(count, 0U);
    }
}

TEST_F(Samples, lookNearlyLikeOneInALandscape)
{
    const int samples = most();
    const Chunk chunk = shell(24, 40);
    const VoxelDraw draw{chunk.key};
    const auto shown = rendererOf(samples);
    const auto plain = rendererOf(1);
    for (render::Renderer* each : {shown.get(), plain.get()}) {
        show(*each, showing(cut(sheet(8, [](double, double) { return 0.5; }), 2, 1)));
        add(*each, {&chunk, 1});
    }
    const hierarchy::View view = lookingAt({2, -30, 59}, {34, 32, 32}, 90, 60);
    for (const VoxelWay way : kWays) {
        const render::VoxelScene scene{.lattice = {.edge = 1.0}, .draws = {&draw, 1}, .way = way};
        const VoxelShot a = shootVoxels(*shown, view, scene, {});
        const VoxelShot b = shootVoxels(*plain, view, scene, {.antialias = false});
        EXPECT_EQ(a.sight, b.sight);
        double apart = 0;
        for (std::size_t i = 0; i < a.image.rgba.size(); ++i)
            apart += std::abs(int{a.image.rgba[i]} - int{b.image.rgba[i]});
        EXPECT_LT(apart / static_cast<double>(a.image.rgba.size()), 3.0);
        EXPECT_EQ(a.image.rgba, shootVoxels(*shown, view, scene, {}).image.rgba);
    }
}

TEST_F(Samples, thatTheDeviceDoesNotHaveAreRefusedWithThoseThatItHas)
{
    render::RendererOptions wanted = options();
    for (const int samples : {0, 2, 3, 16, -1}) {
        wanted.samples = samples;
        const auto refused = render::Renderer::create(*device, kDomain, wanted);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, core::ErrorCode::usage);
    }
    wanted.samples = 8;
    const auto refused = render::Renderer::create(*device, kDomain, wanted);
    if (refused)
        return;
    EXPECT_EQ(refused.error().code, core::ErrorCode::noDevice);
    EXPECT_NE(refused.error().message.find("it has 1"), std::string::npos);
    EXPECT_NE(refused.error().message.find(device->description().name), std::string::npos);
}

} // namespace
} // namespace isofront::test

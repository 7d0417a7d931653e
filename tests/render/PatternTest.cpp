#include "render/support/VoxelFixture.h"

#include <isofront/voxels/LevelEvaluation.h>

#include <algorithm>
#include <bit>
#include <map>
#include <optional>

namespace isofront::test {
namespace {

using render::ShownVoxel;

/// What a picture shows nearest to the eye, as voxels::patternNode finds it on the CPU.
struct Twin {
    std::optional<voxels::PatternNode> node;
    std::uint64_t voxelPixels = 0;
    /// Of equally near voxels all but the number is the same.
    std::vector<ShownVoxel> nearest;
};

class Patterns : public VoxelFixture {
protected:
    static Twin twinOf(const VoxelShot& shot)
    {
        Twin twin;
        float nearest = 0;
        for (std::size_t i = 0; i < shot.voxels.size(); ++i) {
            if (!shot.voxels[i].isThere)
                continue;
            ++twin.voxelPixels;
            nearest = std::max(nearest, shot.depth[i]);
        }
        for (std::size_t i = 0; i < shot.voxels.size(); ++i)
            if (shot.voxels[i].isThere && shot.depth[i] == nearest &&
                std::ranges::count(twin.nearest, shot.voxels[i]) == 0)
                twin.nearest.push_back(shot.voxels[i]);
        return twin;
    }
    /// Gives voxels numbers so that the one that the renderer took comes first among its equals,
    /// then lets the CPU find it.
    static void expectTwin(const VoxelShot& shot, const std::optional<render::ShownPattern>& found)
    {
        Twin twin = twinOf(shot);
        ASSERT_EQ(found.has_value(), !twin.nearest.empty());
        if (!found)
            return;
        EXPECT_EQ(std::ranges::count(twin.nearest, found->voxel), 1);
        std::vector<std::uint64_t> picture;
        for (std::size_t i = 0; i < shot.voxels.size(); ++i) {
            const ShownVoxel& voxel = shot.voxels[i];
            const std::uint64_t depth = ~std::bit_cast<std::uint32_t>(shot.depth[i]);
            const std::uint64_t id = voxel == found->voxel ? 0 : 1;
            picture.push_back(voxel.isThere ? depth << 32U | id : voxels::kNoPatternPixel);
        }
        const std::optional<voxels::PatternNode> node = voxels::patternNode(picture);
        ASSERT_TRUE(node);
        EXPECT_EQ(found->node.depth, node->depth);
        EXPECT_EQ(found->node.pixels, node->pixels);
        EXPECT_EQ(found->voxelPixels, twin.voxelPixels);
    }
};

TEST_F(Patterns, areTheNearestVoxelsOfAPicture)
{
    const HillyModel model(300);
    const std::vector<Chunk> chunks = model.cut(0);
    const std::vector<VoxelDraw> draws = drawsOf(chunks);
    // of pictures with several samples a pixel, the first ones, which are those that are read
    render::RendererOptions sampled = options();
    sampled.samples = 4;
    const auto many = renderer({.edge = 1024.0}, sampled);
    add(*many, chunks);
    for (const VoxelWay way : kWays) {
        const VoxelShot shot = shootVoxels(
            *many,
            lookingAt({0.9, -1.6, 0.7}, {0, 0, 0}, 96, 72),
            {.lattice = model.lattice, .draws = draws, .way = way, .findsPattern = true});
        const auto found = many->readPattern();
        ASSERT_TRUE(found && *found);
        expectTwin(shot, *found);
    }
    const auto shown = renderer({.edge = 1024.0}, options());
    add(*shown, chunks);
    std::size_t seen = 0;
    // sizes that don't fill a group, that fill many, and one pixel
    for (const auto& [width, height] : {std::pair{96, 72}, std::pair{333, 251}, std::pair{1, 1}}) {
        for (const glm::dvec3 eye :
             {glm::dvec3(0.9, -1.6, 0.7), glm::dvec3(0.3, -1.25, 0.2), glm::dvec3(-4, 1, 9)}) {
            const hierarchy::View view = lookingAt(eye, {0, 0, 0}, width, height);
            for (const VoxelWay way : kWays) {
                const VoxelShot shot = shootVoxels(
                    *shown,
                    view,
                    {.lattice = model.lattice, .draws = draws, .way = way, .findsPattern = true});
                const auto found = shown->readPattern();
                ASSERT_TRUE(found) << found.error().message;
                expectTwin(shot, *found);
                seen += found->has_value() ? 1U : 0U;
            }
        }
    }
    EXPECT_EQ(seen, 18U);
}

TEST_F(Patterns, ofEquallyNearVoxelsHaveTheLeastNumber)
{
    // a wall across the view: all of it is equally far
    Chunk wall;
    wall.key = {0, 0, 0, 0};
    for (std::uint32_t z = 0; z < 64; ++z)
        for (std::uint32_t x = 0; x < 64; ++x)
            wall.voxels.push_back(
                {voxels::packPlace(x, 0, z, voxels::faceBit(voxels::Face::lowY)),
                 voxels::packNormal({0, -1, 0})});
    const auto shown = renderer({.edge = 1024.0}, options());
    add(*shown, {&wall, 1});
    const VoxelDraw draw{wall.key};
    hierarchy::View view = lookingAt({32, -100, 32}, {32, 0, 32}, 200, 150);
    std::optional<render::ShownPattern> first;
    for (int i = 0; i < 3; ++i) {
        const VoxelShot shot = shootVoxels(
            *shown,
            view,
            {.lattice = {.edge = 1},
             .draws = {&draw, 1},
             .way = VoxelWay::splats,
             .findsPattern = true});
        const auto found = shown->readPattern();
        ASSERT_TRUE(found && *found);
        expectTwin(shot, *found);
        const Twin twin = twinOf(shot);
        const auto least = std::ranges::min_element(twin.nearest, {}, &ShownVoxel::voxel);
        EXPECT_EQ((*found)->voxel, *least);
        if (first) {
            EXPECT_EQ((*found)->node, first->node);
        }
        first = *found;
    }
}

TEST_F(Patterns, areNoneWhereNoVoxelIsSeen)
{
    const HillyModel model(60);
    const auto shown = renderer({.edge = 1024.0}, options());
    const std::vector<Chunk> chunks = model.cut(0);
    add(*shown, chunks);
    const std::vector<VoxelDraw> draws = drawsOf(chunks);
    EXPECT_FALSE(shown->readPattern()->has_value()) << "no picture yet";
    const render::VoxelScene scene{.lattice = model.lattice, .draws = draws, .findsPattern = true};
    // looking away; then past it, where a corner of its box is
    hierarchy::View past = lookingAt({1.1, -4, 1.1}, {1.1, 0, 1.1}, 16, 12);
    past.verticalFieldOfView = 0.05;
    for (const hierarchy::View& view : {lookingAt({1.1, -4, 0}, {0, -9, 0}, 16, 12), past}) {
        shootVoxels(*shown, view, scene);
        EXPECT_FALSE(shown->readPattern()->has_value());
    }
    // not asked for
    render::VoxelScene silent = scene;
    silent.findsPattern = false;
    shootVoxels(*shown, lookingAt({0.9, -1.6, 0.7}, {0, 0, 0}, 96, 72), silent);
    EXPECT_FALSE(shown->readPattern()->has_value());
    shootVoxels(*shown, lookingAt({0.9, -1.6, 0.7}, {0, 0, 0}, 96, 72), scene);
    const auto found = shown->readPattern();
    ASSERT_TRUE(found && *found);
    // of a frame with a number, it comes with what else the frame has shown
    for (const bool asked : {true, false}) {
        render::VoxelScene numbered = asked ? scene : silent;
        numbered.frame = asked ? 1 : 2;
        shootVoxels(*shown, lookingAt({0.9, -1.6, 0.7}, {0, 0, 0}, 96, 72), numbered);
        const auto sights = shown->takeSights();
        ASSERT_TRUE(sights);
        ASSERT_EQ(sights->size(), 1U);
        EXPECT_EQ(sights->front().frame, numbered.frame);
        ASSERT_EQ(sights->front().pattern.has_value(), asked);
        if (asked) {
            EXPECT_EQ(sights->front().pattern->voxel, (*found)->voxel);
            EXPECT_EQ(sights->front().pattern->node, (*found)->node);
        }
    }
}

} // namespace
} // namespace isofront::test

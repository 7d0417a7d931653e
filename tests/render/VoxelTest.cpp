#include "render/support/VoxelFixture.h"

#include <isofront/voxels/VoxelRay.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace isofront::test {
namespace {

using render::ShownVoxel;
using voxels::packPlace;

const hierarchy::Domain kDomain{.edge = 1024.0};

/// A block of voxels of level 0 with outward normals and the faces that can be seen.
Chunk block(ChunkKey key, std::array<std::uint32_t, 3> low, std::array<std::uint32_t, 3> high)
{
    Chunk chunk;
    chunk.key = key;
    for (std::uint32_t z = low[2]; z <= high[2]; ++z) {
        for (std::uint32_t y = low[1]; y <= high[1]; ++y) {
            for (std::uint32_t x = low[0]; x <= high[0]; ++x) {
                const std::array at{x, y, z};
                std::uint8_t faces = 0;
                glm::dvec3 normal(0);
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    if (at[axis] == low[axis]) {
                        faces = static_cast<std::uint8_t>(faces | 1U << 2 * axis);
                        normal[axis] -= 1;
                    }
                    if (at[axis] == high[axis]) {
                        faces = static_cast<std::uint8_t>(faces | 2U << 2 * axis);
                        normal[axis] += 1;
                    }
                }
                if (faces != 0)
                    chunk.voxels.push_back({packPlace(x, y, z, faces), voxels::packNormal(normal)});
            }
        }
    }
    return chunk;
}

class Voxels : public VoxelFixture {
protected:
    /// Holds a picture against exactly cast rays. Where the rays a hundredth of a pixel around the
    /// middle don't agree, either of what they meet is right.
    /// @param oddShare  how many of the pixels may still show something else
    static void expectExact(
        const VoxelShot& shot,
        const hierarchy::View& view,
        const voxels::VoxelRayCaster& caster,
        double near,
        double oddShare,
        const std::string& what)
    {
        const auto jobs = core::makeJobs(core::JobsBackend::automatic);
        constexpr std::array<std::array<double, 2>, 5> kOffsets{
            {{0, 0}, {-0.01, -0.01}, {0.01, -0.01}, {-0.01, 0.01}, {0.01, 0.01}}};
        std::vector<voxels::Ray> rays;
        const glm::dvec3 right = pixelRay(view, 1, 0) - pixelRay(view, 0, 0);
        const glm::dvec3 down = pixelRay(view, 0, 1) - pixelRay(view, 0, 0);
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                for (const auto& [dx, dy] : kOffsets)
                    rays.push_back(
                        {.start = view.eye,
                         .direction = pixelRay(view, x, y) + dx * right + dy * down});
            }
        }
        const auto hits = caster.cast(rays, *jobs);
        ASSERT_TRUE(hits) << hits.error().message;
        std::size_t odd = 0;
        std::size_t clear = 0;
        std::size_t shown = 0;
        for (std::size_t pixel = 0; pixel < shot.voxels.size(); ++pixel) {
            const ShownVoxel& now = shot.voxels[pixel];
            shown += now.isThere ? 1U : 0U;
            bool fits = false;
            bool agree = true;
            const auto& middle = (*hits)[pixel * kOffsets.size()];
            for (std::size_t i = 0; i < kOffsets.size(); ++i) {
                const auto& hit = (*hits)[pixel * kOffsets.size() + i];
                const bool same =
                    hit ? now.isThere && now.chunk == hit->chunk && now.voxel == hit->index
                        : !now.isThere;
                fits = fits || same;
                agree = agree && hit.has_value() == middle.has_value() &&
                        (!hit || (hit->chunk == middle->chunk && hit->index == middle->index));
            }
            odd += fits ? 0U : 1U;
            if (!agree || !middle)
                continue;
            ++clear;
            const glm::dvec3 ray = rays[pixel * kOffsets.size()].direction;
            const double along = middle->distance / glm::length(ray);
            const double length = near / static_cast<double>(shot.depth[pixel]);
            odd += std::abs(length - along) < 1e-4 * along ? 0U : 1U;
        }
        EXPECT_LE(static_cast<double>(odd), oddShare * static_cast<double>(shown)) << what;
        EXPECT_GT(clear, shot.voxels.size() / 20) << what << ": next to nothing to compare";
        EXPECT_GT(clear, shown / 2) << what;
    }
};

TEST_F(Voxels, showExactlyWhatRaysMeet)
{
    const HillyModel model(300);
    const auto shown = renderer(kDomain, options());
    const double near = shown->defaultNearPlane();
    for (const std::uint32_t level : {0U, 1U}) {
        const std::vector<Chunk> chunks = model.cut(level);
        add(*shown, chunks);
        voxels::ChunkCut keys;
        for (const Chunk& chunk : chunks)
            keys.push_back(chunk.key);
        auto caster = voxels::VoxelRayCaster::create(*model.store, keys);
        ASSERT_TRUE(caster) << caster.error().message;
        const std::vector<VoxelDraw> draws = drawsOf(chunks);
        // Voxels of one pixel, and of several.
        for (const glm::dvec3 eye : {glm::dvec3(0.9, -1.6, 0.7), glm::dvec3(0.5, -1.0, 0.4)}) {
            const hierarchy::View view = lookingAt(eye, {0, 0, 0}, 96, 72);
            for (const VoxelWay way : kWays) {
                const VoxelShot shot = shootVoxels(
                    *shown, view, {.lattice = model.lattice, .draws = draws, .way = way});
                expectExact(
                    shot,
                    view,
                    *caster,
                    near,
                    // The rasteriser takes the depth of steep, small faces less exactly.
                    way == VoxelWay::cubes ? 0.005 : 0.0,
                    "level " + std::to_string(level) + " as " +
                        (way == VoxelWay::cubes ? "cubes" : "splats"));
                EXPECT_EQ(
                    shot.stats.voxels.splatted,
                    way == VoxelWay::cubes ? 0 : shot.stats.voxels.voxels);
            }
        }
        std::vector<ChunkKey> all(keys);
        shown->removeChunks(all);
    }
}

TEST_F(Voxels, areTheSameFarFromTheOrigin)
{
    const Chunk chunk = block({0, 1, 2, 3}, {100, 90, 110}, {140, 130, 120});
    std::vector<ShownVoxel> first;
    for (const double far : {0.0, 1e9}) {
        const auto shown = renderer(kDomain, options());
        add(*shown, {&chunk, 1});
        const VoxelDraw draw{chunk.key};
        // Powers of two, so that the places relative to the eye are the same numbers.
        const voxels::VoxelLattice lattice{
            .origin = glm::dvec3(std::ldexp(std::round(far), 1)), .edge = 0.25};
        const glm::dvec3 target =
            lattice.origin + 0.25 * glm::dvec3(256 + 120, 512 + 110, 768 + 115);
        const hierarchy::View view = lookingAt(target + glm::dvec3(9, -14, 8), target, 80, 60);
        for (const VoxelWay way : kWays) {
            const VoxelShot shot =
                shootVoxels(*shown, view, {.lattice = lattice, .draws = {&draw, 1}, .way = way});
            if (first.empty())
                first = shot.voxels;
            std::size_t different = 0;
            for (std::size_t i = 0; i < first.size(); ++i)
                different += shot.voxels[i] == first[i] ? 0U : 1U;
            EXPECT_LT(different, first.size() / 100);
            EXPECT_TRUE(shot.voxels[30 * 80 + 40].isThere);
        }
    }
}

TEST_F(Voxels, fillTheSilhouetteOfABoxWithoutHoles)
{
    // Over a corner where eight chunks meet.
    std::vector<Chunk> chunks;
    for (std::uint32_t i = 0; i < 8; ++i) {
        std::array<std::uint32_t, 3> low{};
        std::array<std::uint32_t, 3> high{};
        for (unsigned axis = 0; axis < 3; ++axis) {
            const bool upper = (i >> axis & 1U) != 0;
            low[axis] = upper ? 0 : 240;
            high[axis] = upper ? 15 : 255;
        }
        chunks.push_back(block({0, i & 1U, i >> 1U & 1U, i >> 2U}, low, high));
    }
    const auto shown = renderer(kDomain, options());
    add(*shown, chunks);
    const std::vector<VoxelDraw> draws = drawsOf(chunks);
    const voxels::VoxelLattice lattice{.origin = glm::dvec3(-256.0), .edge = 1.0};
    for (const glm::dvec3 eye :
         {glm::dvec3(60, -80, 50), glm::dvec3(-50, 1, 0.25), glm::dvec3(7, 19, -200)}) {
        const hierarchy::View view = lookingAt(eye, {0.3, 0.2, 0.1}, 120, 90);
        for (const VoxelWay way : kWays) {
            const VoxelShot shot =
                shootVoxels(*shown, view, {.lattice = lattice, .draws = draws, .way = way});
            for (int y = 0; y < view.height; ++y) {
                for (int x = 0; x < view.width; ++x) {
                    // The box from -16 to 16, met in closed form.
                    const glm::dvec3 ray = pixelRay(view, x, y);
                    const glm::dvec3 a = (glm::dvec3(-16.0) - eye) / ray;
                    const glm::dvec3 b = (glm::dvec3(16.0) - eye) / ray;
                    const glm::dvec3 from = glm::min(a, b);
                    const glm::dvec3 to = glm::max(a, b);
                    const double entry = std::max({from.x, from.y, from.z});
                    const double slack = std::min({to.x, to.y, to.z}) - entry;
                    if (std::abs(slack) < 0.05)
                        continue; // at the outline
                    const auto depth = static_cast<double>(shot.depthAt(x, y));
                    if (slack < 0)
                        ASSERT_EQ(depth, 0.0) << x << " " << y;
                    else
                        ASSERT_NEAR(depth * entry / shown->defaultNearPlane(), 1.0, 1e-4)
                            << x << " " << y;
                }
            }
        }
    }
}

TEST_F(Voxels, hideMeshesAndAreHiddenByThem)
{
    const hierarchy::Domain domain{.edge = 64.0};
    const auto shown = renderer(domain, options());
    show(*shown, showing(cut(sheet(8, [](double, double) { return 0.5; }), 2, 1)));
    const Chunk chunk = block({0, 0, 0, 0}, {20, 20, 20}, {43, 43, 43});
    add(*shown, {&chunk, 1});
    const VoxelDraw draw{chunk.key};
    // The block stands half above the sheet.
    const render::VoxelScene scene{.lattice = {.edge = 1.0}, .draws = {&draw, 1}};
    const hierarchy::View view = lookingAt({-20, -30, 70}, {32, 32, 32}, 120, 90);
    const VoxelShot mesh = shootVoxels(*shown, view, {});
    for (const VoxelWay way : kWays) {
        render::VoxelScene now = scene;
        now.way = way;
        const VoxelShot both = shootVoxels(*shown, view, now);
        const auto alone = renderer(domain, options());
        add(*alone, {&chunk, 1});
        const VoxelShot voxels = shootVoxels(*alone, view, now);
        std::size_t hidden = 0;
        std::size_t hiding = 0;
        for (std::size_t i = 0; i < both.depth.size(); ++i) {
            ASSERT_EQ(both.depth[i], std::max(mesh.depth[i], voxels.depth[i]));
            const bool wins = voxels.depth[i] > mesh.depth[i];
            ASSERT_EQ(both.voxels[i].isThere, wins);
            hidden += voxels.depth[i] > 0 && !wins ? 1U : 0U;
            hiding += mesh.depth[i] > 0 && wins ? 1U : 0U;
        }
        EXPECT_GT(hidden, 100U);
        EXPECT_GT(hiding, 100U);
    }
}

TEST_F(Voxels, tellWhichChunksCanBeSeen)
{
    const Chunk wall = block({0, 0, 0, 0}, {0, 100, 0}, {255, 102, 255});
    const Chunk behind = block({0, 0, 1, 0}, {100, 10, 100}, {140, 30, 140});
    const Chunk beside = block({0, 1, 1, 0}, {200, 10, 100}, {220, 30, 140});
    const std::array chunks{wall, behind, beside};
    const auto shown = renderer(kDomain, options());
    add(*shown, chunks);
    const voxels::VoxelLattice lattice{.edge = 1.0};
    const hierarchy::View view = lookingAt({128, -300, 128}, {180, 128, 128}, 120, 90);
    const std::vector<VoxelDraw> all = drawsOf(chunks);
    std::vector<VoxelDraw> tested = all;
    tested[1].occlusionOnly = tested[2].occlusionOnly = true;
    const std::vector<VoxelDraw> wallOnly{all[0]};
    for (const VoxelWay way : kWays) {
        const VoxelShot full =
            shootVoxels(*shown, view, {.lattice = lattice, .draws = all, .way = way});
        EXPECT_TRUE(sees(full, wall.key));
        EXPECT_FALSE(sees(full, behind.key));
        EXPECT_TRUE(sees(full, beside.key));
        const VoxelShot test =
            shootVoxels(*shown, view, {.lattice = lattice, .draws = tested, .way = way});
        EXPECT_TRUE(sees(test, wall.key));
        EXPECT_FALSE(sees(test, behind.key));
        EXPECT_TRUE(sees(test, beside.key));
        EXPECT_EQ(test.stats.voxels.boxes, 2U);
        // What is only tested leaves no trace.
        const VoxelShot bare =
            shootVoxels(*shown, view, {.lattice = lattice, .draws = wallOnly, .way = way});
        EXPECT_EQ(test.image.rgba, bare.image.rgba);
        EXPECT_EQ(test.depth, bare.depth);
    }
}

TEST_F(Voxels, lookTheSameInAnyOrderAndByAnyUpload)
{
    const HillyModel model(260);
    std::vector<Chunk> chunks = model.cut(0);
    const hierarchy::View view = lookingAt({1.5, -3, 1}, {0, 0, 0}, 120, 90);
    for (const VoxelWay way : {VoxelWay::cubes, VoxelWay::automatic}) {
        std::optional<VoxelShot> first;
        for (const bool other : {false, true}) {
            render::RendererOptions others = options();
            others.forceStaging = other;
            others.forceDirectDraws = other;
            const auto shown = renderer(kDomain, others);
            std::vector<VoxelDraw> draws = drawsOf(chunks);
            if (other) {
                std::reverse(draws.begin(), draws.end());
                std::reverse(chunks.begin(), chunks.end());
            }
            add(*shown, chunks);
            for (int again = 0; again < 2; ++again) {
                const VoxelShot shot = shootVoxels(
                    *shown, view, {.lattice = model.lattice, .draws = draws, .way = way});
                if (!first)
                    first = shot;
                EXPECT_EQ(shot.image.rgba, first->image.rgba);
                EXPECT_EQ(shot.depth, first->depth);
                EXPECT_EQ(shot.voxels, first->voxels);
            }
        }
    }
}

TEST_F(Voxels, showTheirOwnColours)
{
    Chunk chunk = block({0, 0, 0, 0}, {10, 10, 10}, {50, 50, 50});
    for (const voxels::Voxel& voxel : chunk.voxels)
        chunk.colours.push_back(voxel.x() < 30 ? 0xff0000c0U : 0xffc00000U);
    const auto shown = renderer(kDomain, options());
    add(*shown, {&chunk, 1});
    const VoxelDraw draw{chunk.key};
    const hierarchy::View view = lookingAt({30, -60, 40}, {30, 30, 30}, 96, 96);
    for (const render::Look look : {render::Look::studio, render::Look::terrain}) {
        for (const VoxelWay way : kWays) {
            const VoxelShot shot = shootVoxels(
                *shown,
                view,
                {.lattice = {.edge = 1.0}, .draws = {&draw, 1}, .way = way},
                {.look = look, .antialias = false});
            const auto* red = shot.image.pixel(30, 48);
            const auto* blue = shot.image.pixel(66, 48);
            EXPECT_GT(red[0], red[2] + 20);
            EXPECT_GT(blue[2], blue[0] + 20);
        }
    }
}

TEST_F(Voxels, keepWithinTheirMemory)
{
    render::RendererOptions small = options();
    small.voxelPoolBytes = 1U << 20U;
    const auto shown = renderer(kDomain, small);
    // About 60,000 voxels each.
    const Chunk one = block({0, 0, 0, 0}, {50, 50, 50}, {149, 149, 149});
    Chunk other = one;
    other.key.x = 1;
    Chunk third = one;
    third.key.x = 2;
    add(*shown, {&one, 1});
    add(*shown, {&other, 1});
    const std::uint64_t held = device->allocatedBytes();
    const auto refused = shown->addChunks({&third, 1});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, core::ErrorCode::resourceLimit);
    const VoxelDraw draw{one.key};
    const hierarchy::View view = lookingAt({-60, -160, 140}, {100, 100, 100});
    const render::VoxelScene scene{.lattice = {.edge = 1.0}, .draws = {&draw, 1}};
    const VoxelShot before = shootVoxels(*shown, view, scene);
    // What frames in flight may read is not written over.
    ASSERT_TRUE(shown->draw(view, {.look = render::Look::studio, .antialias = false}, scene));
    shown->removeChunks(std::array{other.key});
    add(*shown, {&third, 1});
    EXPECT_EQ(shootVoxels(*shown, view, scene).image.rgba, before.image.rgba);
    EXPECT_LE(shown->draw(view, {}, scene)->voxels.poolBytesUsed, 1U << 20U);
    EXPECT_LT(device->allocatedBytes(), held + (4U << 20U));
}

/// A chunk and its parent, made by hand: every second voxel of a block, and colours.
struct Family {
    Chunk child = block({0, 0, 0, 0}, {20, 20, 20}, {39, 39, 39});
    Chunk parent;
    voxels::TransitionNodes nodes;

    explicit Family(bool coloured)
    {
        std::erase_if(child.voxels, [](const voxels::Voxel& v) {
            return (v.x() * 7 + v.y() * 3 + v.z() * 5) % 4 < 2;
        });
        std::map<std::uint32_t, glm::dvec3> normals; // by place
        for (voxels::Voxel& v : child.voxels) {
            v.place |= std::uint32_t{voxels::kAllFaces} << 24U; // it can be seen into
            normals[packPlace(v.x() / 2, v.y() / 2, v.z() / 2, voxels::kAllFaces)] +=
                voxels::unpackNormal(v.normal);
            if (coloured)
                child.colours.push_back(v.x() % 2 == 0 ? 0xff2040c0U : 0xffc08020U);
        }
        parent.key = child.key.parent();
        for (const auto& [place, normal] : normals) {
            parent.voxels.push_back({place, voxels::packNormal(normal)});
            if (coloured)
                parent.colours.push_back(0xff60a060U);
        }
        nodes = *voxels::transitionNodes(child, parent);
    }
};

TEST_F(Voxels, onTheirWayShowTheParentAtFirstAndThemselvesAtLast)
{
    for (const bool coloured : {false, true}) {
        const Family family(coloured);
        const auto shown = renderer(kDomain, options());
        add(*shown, std::array{family.child, family.parent});
        ASSERT_TRUE(shown->addTransitions(
            std::array{render::VoxelTransition{family.child.key, family.nodes}}));
        const voxels::VoxelLattice lattice{.edge = 1.0, .levels = 2};
        const hierarchy::View view = lookingAt({2, -15, 55}, {30, 30, 30}, 96, 96);
        for (const VoxelWay way : kWays) {
            const auto shot = [&](const VoxelDraw& draw) {
                return shootVoxels(
                    *shown, view, {.lattice = lattice, .draws = {&draw, 1}, .way = way});
            };
            const VoxelShot parent = shot({family.parent.key});
            const VoxelShot child = shot({family.child.key});
            const VoxelShot first = shot({.key = family.child.key, .weight = 0});
            const VoxelShot last = shot({.key = family.child.key, .weight = 1});
            EXPECT_EQ(last.image.rgba, child.image.rgba);
            EXPECT_EQ(last.depth, child.depth);
            // the same cube in eight parts: the rasteriser's depths may differ in the last bits
            std::size_t odd = 0;
            for (std::size_t i = 0; i < first.depth.size(); ++i) {
                const float a = first.depth[i];
                const float b = parent.depth[i];
                odd += std::abs(a - b) > 1e-4F * std::max(a, b) ? 1U : 0U;
                for (std::size_t channel = 0; channel < 3; ++channel)
                    odd += std::abs(
                               first.image.rgba[4 * i + channel] -
                               parent.image.rgba[4 * i + channel]) > 2
                               ? 1U
                               : 0U;
            }
            EXPECT_LT(odd, first.depth.size() / 200);
            EXPECT_NE(first.depth, last.depth);
        }
    }
}

TEST_F(Voxels, onTheirWayAreTheBoxesOfTheTransition)
{
    const Family family(false);
    const auto shown = renderer(kDomain, options());
    add(*shown, std::array{family.child, family.parent});
    ASSERT_TRUE(
        shown->addTransitions(std::array{render::VoxelTransition{family.child.key, family.nodes}}));
    const voxels::VoxelLattice lattice{.edge = 1.0, .levels = 2};
    const glm::dvec3 eye(2.125, -15.25, 55.5);
    const hierarchy::View view = lookingAt(eye, {30, 30, 30}, 50, 50);
    const double near = shown->defaultNearPlane();
    for (const float weight : {0.25F, 0.75F}) {
        std::vector<voxels::TransitionBox> boxes;
        std::map<std::uint32_t, unsigned> children;
        for (const voxels::Voxel& v : family.child.voxels)
            children[packPlace(v.x() / 2, v.y() / 2, v.z() / 2, 0)] |=
                1U << ((v.x() & 1U) | (v.y() & 1U) << 1U | (v.z() & 1U) << 2U);
        for (const auto& [place, mask] : children) {
            const voxels::Voxel parent{place, 0};
            const auto some = voxels::transitionBoxes(
                {parent.x(), parent.y(), parent.z()},
                static_cast<std::uint8_t>(mask),
                static_cast<double>(weight));
            boxes.insert(boxes.end(), some.begin(), some.end());
        }
        std::vector<double> expected;
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const glm::dvec3 ray = pixelRay(view, x, y);
                double nearest = 1e9;
                for (const voxels::TransitionBox& box : boxes) {
                    const glm::dvec3 a = (box.low - eye) / ray;
                    const glm::dvec3 b = (box.high - eye) / ray;
                    const glm::dvec3 from = glm::min(a, b);
                    const glm::dvec3 to = glm::max(a, b);
                    const double entry = std::max({from.x, from.y, from.z});
                    if (entry <= std::min({to.x, to.y, to.z}))
                        nearest = std::min(nearest, entry);
                }
                expected.push_back(nearest);
            }
        }
        for (const VoxelWay way : kWays) {
            const VoxelDraw draw{.key = family.child.key, .weight = weight};
            const VoxelShot shot =
                shootVoxels(*shown, view, {.lattice = lattice, .draws = {&draw, 1}, .way = way});
            std::size_t odd = 0;
            std::size_t seen = 0;
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const auto depth = static_cast<double>(shot.depth[i]);
                seen += depth > 0 ? 1U : 0U;
                odd += (expected[i] == 1e9) != (depth == 0) ||
                               (depth > 0 && std::abs(depth * expected[i] / near - 1) > 1e-4)
                           ? 1U
                           : 0U;
            }
            EXPECT_GT(seen, 300U);
            // at outlines, where the ray grazes a box
            EXPECT_LE(odd, seen / 100) << weight << (way == VoxelWay::cubes ? " cubes" : " splats");
            // nodes that go are named after the chunk's voxels
            std::size_t redundant = 0;
            for (const ShownVoxel& voxel : shot.voxels)
                redundant += voxel.isThere && voxel.voxel >= family.child.voxels.size() ? 1U : 0U;
            EXPECT_GT(redundant, 0U);
        }
    }
}

TEST_F(Voxels, withoutTheirParentLookLikeThemselves)
{
    const Family family(false);
    const auto shown = renderer(kDomain, options());
    const render::VoxelTransition transition{family.child.key, family.nodes};
    const auto early = shown->addTransitions({&transition, 1});
    ASSERT_FALSE(early);
    EXPECT_EQ(early.error().code, core::ErrorCode::usage);
    add(*shown, {&family.child, 1});
    const hierarchy::View view = lookingAt({2, -15, 55}, {30, 30, 30}, 64, 64);
    const voxels::VoxelLattice lattice{.edge = 1.0, .levels = 2};
    const VoxelDraw whole{family.child.key};
    const VoxelDraw half{.key = family.child.key, .weight = 0.5F};
    const auto shot = [&](const VoxelDraw& draw) {
        return shootVoxels(*shown, view, {.lattice = lattice, .draws = {&draw, 1}}).depth;
    };
    const auto self = shot(whole);
    EXPECT_EQ(shot(half), self);
    render::VoxelTransition wrong = transition;
    wrong.nodes.parents.pop_back();
    const auto bad = shown->addTransitions({&wrong, 1});
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, core::ErrorCode::badData);
    ASSERT_TRUE(shown->addTransitions({&transition, 1}));
    EXPECT_FALSE(shown->addTransitions({&transition, 1}));
    EXPECT_EQ(shot(half), self);
    add(*shown, {&family.parent, 1});
    EXPECT_NE(shot(half), self);
    // removed with the chunk
    shown->removeChunks(std::array{family.child.key});
    add(*shown, {&family.child, 1});
    EXPECT_EQ(shot(half), self);
    // one that was made from a larger parent isn't used, or it would be read beyond its end
    for (const std::uint32_t beyond :
         {static_cast<std::uint32_t>(family.parent.voxels.size()), 0xffffffffU}) {
        render::VoxelTransition larger = transition;
        larger.nodes.parents.back() = beyond;
        ASSERT_TRUE(shown->addTransitions({&larger, 1}));
        EXPECT_EQ(shot(half), self);
        shown->removeChunks(std::array{family.child.key});
        add(*shown, {&family.child, 1});
    }
}

TEST_F(Voxels, refuseWhatMakesNoSense)
{
    const auto shown = renderer(kDomain, options());
    const Chunk chunk = block({0, 0, 0, 0}, {1, 1, 1}, {2, 2, 2});
    const VoxelDraw missing{{3, 0, 0, 0}};
    const hierarchy::View view = lookingAt({9, 9, 9}, {0, 0, 0});
    const auto drawn = shown->draw(view, {}, {.lattice = {}, .draws = {&missing, 1}});
    ASSERT_FALSE(drawn);
    EXPECT_EQ(drawn.error().code, core::ErrorCode::usage);
    add(*shown, {&chunk, 1});
    const auto twice = shown->addChunks({&chunk, 1});
    ASSERT_FALSE(twice);
    EXPECT_EQ(twice.error().code, core::ErrorCode::usage);
    Chunk odd = chunk;
    odd.key.x = 1;
    odd.colours.resize(3);
    const auto bad = shown->addChunks({&odd, 1});
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, core::ErrorCode::badData);
    // Inside the model, and so far away that it can't be told: no picture, but no failure either.
    const VoxelDraw draw{chunk.key};
    for (const glm::dvec3 eye : {glm::dvec3(1.5), glm::dvec3(1e30, 0, 0), glm::dvec3(2, 2, 2)}) {
        for (const VoxelWay way : kWays) {
            const VoxelShot shot = shootVoxels(
                *shown,
                lookingAt(eye, eye + glm::dvec3(-1, 0.1, 0.2) * glm::length(eye)),
                {.lattice = {.edge = 1.0}, .draws = {&draw, 1}, .way = way});
            EXPECT_EQ(shot.voxels.size(), shot.depth.size());
        }
    }
}

} // namespace
} // namespace isofront::test

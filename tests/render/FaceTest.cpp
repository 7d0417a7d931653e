#include "render/support/VoxelFixture.h"

#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/LevelTransition.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/geometric.hpp>

#include <array>
#include <bit>
#include <cstring>
#include <random>

namespace isofront::test {
namespace {

using voxels::FaceAttributes;
using voxels::kFaces;

const hierarchy::Domain kDomain{.edge = 64.0};

/// Any look: random normals and strong colours, so that no two faces are alike.
FaceAttributes anyLook(std::mt19937_64& random)
{
    const auto part = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
    return {
        voxels::packNormal({part(), part(), part() + 1e-3}),
        static_cast<std::uint32_t>(random()) | 0xff000000U};
}

/// Scattered voxels with all faces. Of every other one some faces have looks of their own.
Chunk scattered(std::mt19937_64& random, bool coloured)
{
    Chunk chunk;
    for (std::uint32_t z = 0; z < 12; ++z)
        for (std::uint32_t y = 0; y < 12; ++y)
            for (std::uint32_t x = 0; x < 12; ++x) {
                if (random() % 7 != 0)
                    continue;
                const FaceAttributes mean = anyLook(random);
                chunk.voxels.push_back(
                    {voxels::packPlace(x, y, z, voxels::kAllFaces), mean.normal});
                if (coloured)
                    chunk.colours.push_back(mean.colour);
                if (random() % 2 == 0)
                    continue;
                const auto mask = static_cast<std::uint32_t>(random() % 64);
                chunk.faceSets.push_back(
                    {static_cast<std::uint32_t>(chunk.voxels.size() - 1),
                     static_cast<std::uint32_t>(chunk.faceAttributes.size()) | mask << 26U});
                for (int i = 0; i < std::popcount(mask); ++i)
                    chunk.faceAttributes.push_back(anyLook(random));
            }
    return chunk;
}

/// The same voxels, which look from all sides as they do from one.
Chunk likeFace(const Chunk& chunk, std::size_t face)
{
    Chunk plain{.key = chunk.key, .voxels = chunk.voxels, .colours = chunk.colours};
    for (std::size_t i = 0; i < plain.voxels.size(); ++i) {
        const FaceAttributes look = attributesOf(chunk, i, static_cast<voxels::Face>(face));
        plain.voxels[i].normal = look.normal;
        if (!plain.colours.empty())
            plain.colours[i] = look.colour;
    }
    return plain;
}

std::array<std::uint8_t, 3> colourAt(const core::Image& image, std::size_t pixel)
{
    return {image.rgba[4 * pixel], image.rgba[4 * pixel + 1], image.rgba[4 * pixel + 2]};
}

class Faces : public VoxelFixture {};

TEST_F(Faces, lookAsTheyDoInBothWays)
{
    std::mt19937_64 random(7);
    for (const bool coloured : {false, true}) {
        const Chunk chunk = scattered(random, coloured);
        const voxels::VoxelLattice lattice{.edge = 1.0, .resolution = 12, .levels = 1};
        auto store = voxels::memoryStore();
        ASSERT_FALSE(store->put(chunk));
        ASSERT_FALSE(store->finish({.name = "scattered", .lattice = lattice}));
        const auto caster = voxels::VoxelRayCaster::create(*store, {chunk.key});
        ASSERT_TRUE(caster);
        const auto shown = renderer(kDomain, options());
        std::array<std::unique_ptr<render::Renderer>, kFaces> likeFaces;
        add(*shown, {&chunk, 1});
        for (std::size_t face = 0; face < kFaces; ++face) {
            likeFaces[face] = renderer(kDomain, options());
            const Chunk plain = likeFace(chunk, face);
            add(*likeFaces[face], {&plain, 1});
        }
        const VoxelDraw draw{chunk.key};
        for (const glm::dvec3 eye : {glm::dvec3(-9, -14, 20), glm::dvec3(25, 21, -6)}) {
            const hierarchy::View view = lookingAt(eye, {6, 6, 6}, 90, 80);
            for (const VoxelWay way : kWays) {
                const render::VoxelScene scene{.lattice = lattice, .draws = {&draw, 1}, .way = way};
                const VoxelShot shot = shootVoxels(*shown, view, scene);
                std::array<VoxelShot, kFaces> plain;
                for (std::size_t face = 0; face < kFaces; ++face)
                    plain[face] = shootVoxels(*likeFaces[face], view, scene);
                std::size_t odd = 0;
                std::size_t seen = 0;
                std::size_t different = 0;
                for (int y = 0; y < view.height; ++y)
                    for (int x = 0; x < view.width; ++x) {
                        const auto pixel = static_cast<std::size_t>(y * view.width + x);
                        const auto hit =
                            caster->cast({.start = eye, .direction = pixelRay(view, x, y)});
                        ASSERT_TRUE(hit);
                        if (!*hit || !shot.voxels[pixel].isThere)
                            continue;
                        ++seen;
                        const auto face = static_cast<std::size_t>(*(*hit)->face);
                        const auto now = colourAt(shot.image, pixel);
                        odd += now == colourAt(plain[face].image, pixel) ? 0U : 1U;
                        different +=
                            now == colourAt(plain[(face + 2) % kFaces].image, pixel) ? 0U : 1U;
                    }
                EXPECT_GT(seen, 1000U);
                // edges, where rounding decides which of two faces a ray meets
                EXPECT_LE(odd, seen / 200) << (way == VoxelWay::cubes ? "cubes" : "splats");
                EXPECT_GT(different, seen / 10) << "all faces look alike";
            }
        }
    }
}

TEST_F(Faces, ofTheParentAndTheChunkBlendOnTheWay)
{
    std::mt19937_64 random(8);
    Chunk child = scattered(random, true);
    Chunk parent;
    parent.key = child.key.parent();
    for (std::uint32_t z = 0; z < 6; ++z)
        for (std::uint32_t y = 0; y < 6; ++y)
            for (std::uint32_t x = 0; x < 6; ++x) {
                const bool isThere =
                    std::ranges::any_of(child.voxels, [&](const voxels::Voxel& voxel) {
                        return voxel.x() / 2 == x && voxel.y() / 2 == y && voxel.z() / 2 == z;
                    });
                if (!isThere)
                    continue;
                const auto index = static_cast<std::uint32_t>(parent.voxels.size());
                const FaceAttributes mean = anyLook(random);
                parent.voxels.push_back(
                    {voxels::packPlace(x, y, z, voxels::kAllFaces), mean.normal});
                parent.colours.push_back(mean.colour);
                if (index % 3 == 0)
                    continue;
                parent.faceSets.push_back(
                    {index,
                     static_cast<std::uint32_t>(parent.faceAttributes.size()) | 0x3fU << 26U});
                for (std::size_t face = 0; face < kFaces; ++face)
                    parent.faceAttributes.push_back(anyLook(random));
            }
    const auto nodes = voxels::transitionNodes(child, parent);
    ASSERT_TRUE(nodes);
    const render::VoxelTransition transition{child.key, *nodes};
    const voxels::VoxelLattice lattice{.edge = 1.0, .resolution = 12, .levels = 2};
    // Straight from above nothing but upper faces is seen.
    hierarchy::View view = lookingAt({6.1, 5.9, 400}, {6.1, 5.9, 6}, 60, 60);
    view.verticalFieldOfView = 0.04;
    const auto face = static_cast<std::size_t>(voxels::Face::highZ);
    const auto shown = renderer(kDomain, options());
    const auto plain = renderer(kDomain, options());
    add(*shown, std::array{child, parent});
    ASSERT_TRUE(shown->addTransitions({&transition, 1}));
    add(*plain, std::array{likeFace(child, face), likeFace(parent, face)});
    ASSERT_TRUE(plain->addTransitions({&transition, 1}));
    for (const float weight : {0.0F, 0.3F, 0.8F})
        for (const VoxelWay way : kWays) {
            const VoxelDraw draw{.key = child.key, .weight = weight};
            const render::VoxelScene scene{.lattice = lattice, .draws = {&draw, 1}, .way = way};
            const VoxelShot a = shootVoxels(*shown, view, scene);
            const VoxelShot b = shootVoxels(*plain, view, scene);
            std::size_t odd = 0;
            std::size_t seen = 0;
            for (std::size_t pixel = 0; pixel < a.voxels.size(); ++pixel) {
                seen += a.voxels[pixel].isThere ? 1U : 0U;
                odd += colourAt(a.image, pixel) == colourAt(b.image, pixel) ? 0U : 1U;
            }
            EXPECT_GT(seen, 1000U);
            // the sides of nodes, a sliver in perspective
            EXPECT_LE(odd, seen / 50) << weight;
        }
}

TEST_F(Faces, ofStreamedChunksLookAsThoseOfAddedOnes)
{
    std::mt19937_64 random(9);
    const Chunk chunk = scattered(random, true);
    const voxels::VoxelLattice lattice{.edge = 1.0, .resolution = 12, .levels = 1};
    auto store = voxels::memoryStore();
    ASSERT_FALSE(store->put(chunk));
    ASSERT_FALSE(store->finish({.name = "scattered", .lattice = lattice}));
    const auto added = renderer(kDomain, options());
    add(*added, {&chunk, 1});
    const VoxelDraw draw{chunk.key};
    const hierarchy::View view = lookingAt({-9, -14, 20}, {6, 6, 6}, 90, 80);
    const VoxelShot expected = shootVoxels(*added, view, {.lattice = lattice, .draws = {&draw, 1}});

    const auto shown = renderer(kDomain, options());
    auto streamer = voxels::ChunkStreamer::create(
        std::move(store),
        {.voxelPixels = 1e-3, .cacheBytes = 4U << 20U},
        core::makeJobs(core::JobsBackend::inlined));
    ASSERT_TRUE(streamer);
    const voxels::ChunkView eye = voxels::perspectiveView(
        view.eye, view.forward, view.up, view.verticalFieldOfView, view.width, view.height, 1e-3);
    for (std::uint64_t number = 1;; ++number) {
        ASSERT_LT(number, 10U);
        const voxels::ChunkFrame& frame = (*streamer)->update(eye, number, number - 1);
        ASSERT_TRUE(shown->apply(frame));
        const VoxelShot shot = shootVoxels(
            *shown,
            view,
            {.lattice = lattice, .placed = frame.draws, .tree = &(*streamer)->tree()});
        if (!frame.isComplete || frame.draws.empty())
            continue;
        EXPECT_EQ(shot.image.rgba, expected.image.rgba);
        break;
    }
}

TEST_F(Faces, thatNameWhatIsNotThereAreRefused)
{
    Chunk chunk{.key = {}, .voxels = {{voxels::packPlace(1, 1, 1, 1), 0}}};
    chunk.faceAttributes = {{1, 2}};
    const auto shown = renderer(kDomain, options());
    for (const voxels::FaceSet set :
         {voxels::FaceSet{1, 1U << 26U},
          voxels::FaceSet{0, 3U << 26U},
          voxels::FaceSet{0, 1U | 1U << 26U}}) {
        chunk.faceSets = {set};
        const auto refused = shown->addChunks({&chunk, 1});
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, core::ErrorCode::badData);
    }
}

} // namespace
} // namespace isofront::test

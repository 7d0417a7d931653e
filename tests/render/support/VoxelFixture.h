#pragma once

#include "render/support/RenderFixture.h"
#include "voxels/Models.h"

#include <isofront/voxels/ChunkStore.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace isofront::test {

using render::VoxelDraw;
using render::VoxelWay;
using voxels::Chunk;
using voxels::ChunkKey;

inline constexpr std::array kWays{VoxelWay::cubes, VoxelWay::splats};

/// Pictures of voxels, with all that is known of them.
class VoxelFixture : public RenderFixture {
protected:
    static render::RendererOptions options()
    {
        render::RendererOptions options = smallOptions();
        options.voxelPoolBytes = 4U << 20U;
        return options;
    }

    struct VoxelShot : Shot {
        std::vector<render::ShownVoxel> voxels;
        std::vector<render::ChunkSight> sight;
    };
    static VoxelShot shootVoxels(
        render::Renderer& renderer,
        const hierarchy::View& view,
        const render::VoxelScene& shown,
        const render::Scene& scene = {.look = render::Look::studio, .antialias = false})
    {
        VoxelShot shot;
        const auto stats = renderer.draw(view, scene, shown);
        EXPECT_TRUE(stats) << stats.error().message;
        if (!stats)
            return shot;
        shot.stats = *stats;
        shot.image = *renderer.readImage();
        shot.depth = *renderer.readDepth();
        shot.voxels = *renderer.readVoxels();
        shot.sight = *renderer.readSight();
        return shot;
    }
    static bool sees(const VoxelShot& shot, const ChunkKey& key)
    {
        for (const render::ChunkSight& sight : shot.sight) {
            if (sight.chunk == key)
                return sight.isVisible;
        }
        ADD_FAILURE() << "the chunk is not in the picture";
        return false;
    }
    static void add(render::Renderer& renderer, std::span<const Chunk> chunks)
    {
        const auto bytes = renderer.addChunks(chunks);
        ASSERT_TRUE(bytes) << bytes.error().message;
    }
};

/// A voxelised model in memory.
inline std::shared_ptr<const voxels::ChunkStore>
stored(const voxels::TriangleModel& model, std::uint32_t resolution)
{
    const auto jobs = core::makeJobs(core::JobsBackend::automatic);
    std::unique_ptr<voxels::ChunkStore> store = voxels::memoryStore();
    const auto report = voxels::voxelize(model, {.resolution = resolution}, *store, *jobs);
    EXPECT_TRUE(report) << report.error().message;
    EXPECT_FALSE(store->finish({.name = "model", .lattice = report->lattice}));
    return store;
}

/// A closed model with hills.
struct HillyModel {
    std::shared_ptr<const voxels::ChunkStore> store;
    voxels::VoxelLattice lattice;

    explicit HillyModel(std::uint32_t resolution)
        : store(stored(tests::hillySphere(24, 1.0, 0.2), resolution)),
          lattice(store->model().lattice)
    {
    }
    [[nodiscard]] std::vector<Chunk> cut(std::uint32_t level) const
    {
        std::vector<Chunk> chunks;
        for (const ChunkKey& key : store->keys()) {
            if (key.level == level)
                chunks.push_back(**store->get(key));
        }
        return chunks;
    }
};

inline std::vector<VoxelDraw> drawsOf(std::span<const Chunk> chunks)
{
    std::vector<VoxelDraw> draws;
    for (const Chunk& chunk : chunks)
        draws.push_back({chunk.key});
    return draws;
}

} // namespace isofront::test

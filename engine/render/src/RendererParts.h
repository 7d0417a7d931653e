#pragma once

#include "MeshStore.h"
#include "Passes.h"
#include "Slot.h"
#include "SunMap.h"
#include "Targets.h"
#include "VoxelPass.h"
#include "VoxelStore.h"
#include "isofront/render/Renderer.h"

#include <isofront/gpu/Commands.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::render {

/// What only those need who show voxels.
struct VoxelParts {
    VoxelStore store;
    VoxelPass pass;
};

/// What a renderer owns. Renderer.cpp has what draws, RendererVoxels.cpp what is about voxels.
struct Renderer::Parts {
    gpu::Device* device;
    hierarchy::Domain domain;
    RendererOptions options;
    bool indirect = true;
    MeshStore store;
    Targets targets;
    Passes passes;
    std::vector<Slot> slots;
    std::size_t nextSlot = 0;
    const Slot* lastSlot = nullptr; ///< of the last picture
    gpu::Commands copying;
    std::uint64_t uploadedSinceFrame = 0;
    SunMap sun;
    std::vector<std::uint32_t> seen;     ///< cells on screen, the nearest first; then fading ones
    std::size_t fading = 0;              ///< how many of them aren't shown in all pixels
    std::vector<std::uint32_t> pictures; ///< what those cells are part of
    std::vector<std::uint32_t> sunlitPictures;
    std::vector<std::uint32_t> sunlit; ///< cells that may cast shadows into the sun's map
    std::optional<VoxelParts> voxels;  ///< once there are some
    std::uint64_t voxelBytesSinceFrame = 0;
    std::optional<std::size_t> lastVoxels; ///< slot of the last picture, if that had voxels
    std::vector<FrameSight> sights;        ///< that nobody has taken yet
    std::uint64_t completedFrame = 0;      ///< number of a streamed frame

    /// Makes what voxels need, if it isn't there.
    core::Result<void> openVoxels();
    /// Notes what the slot's streamed frame has shown, if it had one; the GPU is done with it.
    void settle(std::size_t index);
    /// The same for all slots that the GPU is done with.
    core::Result<void> settleAll();
    /// Readies the voxels of a frame. Returns what they are.
    /// @param castsShadows  whether the sun's map is drawn
    core::Result<VoxelStats> prepareVoxels(
        std::size_t index,
        const hierarchy::View& view,
        const Scene& scene,
        const VoxelScene& shown,
        bool castsShadows);
    core::Result<void> resize(int width, int height);
    void issueMeshes(
        VkCommandBuffer commands, const Slot& slot, std::size_t first, std::size_t count) const;
    core::Result<void> record(
        std::size_t index,
        const hierarchy::View& view,
        const Scene& scene,
        const HandOver* handOver,
        bool redrawShadows,
        bool withVoxels,
        bool castsVoxels);
    /// Copies an image of the last picture, four bytes a pixel.
    core::Result<std::vector<std::byte>> copied(const gpu::Image& image, const gpu::Use& now);
};

} // namespace isofront::render

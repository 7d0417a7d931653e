#pragma once

#include "PatternPass.h"
#include "Stage.h"
#include "Targets.h"
#include "VoxelFrame.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace isofront::render {

/// Draws voxels among what the mesh pass has drawn, and finds out which chunks can be seen.
///
/// Cubes and splats write depth and the names of voxels; then the boxes of chunks that are only to
/// be tested are held against the depth; at last every pixel that shows a voxel gets what the
/// shading pass needs. So a voxel costs the same to shade whichever way it is drawn, and voxels and
/// meshes look alike.
class VoxelPass {
public:
    /// @param slots  how many frames may be in flight
    /// @param indirect  false: draws are issued one by one
    /// @param samples   of the targets
    /// @return noDevice if the device can't note from fragments what is visible
    static core::Result<VoxelPass>
    create(gpu::Device& device, std::uint32_t slots, bool indirect, VkSampleCountFlagBits samples);

    /// True if a picture of this size may have splats.
    [[nodiscard]] bool splatsInto(VkExtent2D extent) const;
    /// Readies a slot, which the GPU must be done with, for a frame.
    /// @param frameBlock  the slot's shared::Frame
    /// @param pool        where the chunks are
    /// @param owners      of the blocks of a hand-over: a byte each
    core::Result<void> prepare(
        std::size_t slot,
        VoxelFrame frame,
        VkExtent2D extent,
        const gpu::Buffer& frameBlock,
        const gpu::Buffer& pool,
        const gpu::Buffer& owners);
    /// Draws what casts shadows into the sun's map, in the pass that is under way.
    void drawShadows(VkCommandBuffer commands, std::size_t slot, VkExtent2D map) const;
    /// Draws what the slot was readied for. The mesh pass is done, shading comes next.
    /// @param targets  with colours
    /// @param keepsColours  whether the mesh pass has written some
    void
    record(VkCommandBuffer commands, std::size_t slot, const Targets& targets, bool keepsColours)
        const;
    /// The name of the voxel in each sample.
    [[nodiscard]] const gpu::Image& names() const { return _names; }
    /// What the slot was last readied for.
    [[nodiscard]] const VoxelFrame& frame(std::size_t slot) const { return _slots[slot].frame; }
    /// One flag for each of its chunks but those that cast shadows: whether any pixel shows it, or
    /// would. Call when the slot's commands have been carried out.
    [[nodiscard]] std::span<const std::uint32_t> visible(std::size_t slot) const;
    /// The same for the nearest voxel; none if it wasn't asked for.
    [[nodiscard]] std::optional<ShownPattern> pattern(std::size_t slot) const;

private:
    /// What one of the frames in flight owns.
    struct Slot {
        VoxelFrame frame;
        gpu::Buffer view;    ///< a shared::VoxelView
        gpu::Buffer chunks;  ///< a shared::DrawnChunk for each chunk
        gpu::Buffer blocks;  ///< a shared::VoxelBlock for each block
        gpu::Buffer cubes;   ///< a VkDrawIndexedIndirectCommand for each draw
        gpu::Buffer shadows; ///< the same, for the sun
        gpu::Buffer visible; ///< a flag for each chunk
        gpu::Buffer seen;    ///< the same, for the CPU
    };
    core::Result<void> makePipelines();
    core::Result<void> makeIndices();
    core::Result<void> resize(VkExtent2D extent);
    core::Result<void> fill(Slot& slot) const;
    void splat(VkCommandBuffer commands, std::size_t slot) const;
    void drawNames(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const;
    void drawBoxes(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const;
    void drawSurface(
        VkCommandBuffer commands,
        std::size_t slot,
        const Targets& targets,
        bool keepsColours) const;

    gpu::Device* _device = nullptr;
    bool _indirect = true;
    VkSampleCountFlagBits _samples = VK_SAMPLE_COUNT_1_BIT;
    gpu::Sampler _nearest;
    Stage _stage;
    gpu::Pipeline _cubePipeline, _fadingPipeline, _splatPipeline, _mergePipeline, _boxPipeline,
        _surfacePipeline, _shadowPipeline;
    gpu::Buffer _indices; ///< of kVoxelsInDraw voxels' faces
    gpu::Buffer _splats;  ///< depth and name of each sample
    gpu::Image _names;
    std::vector<Slot> _slots;
    std::optional<PatternPass> _pattern; ///< made when it is first asked for
};

} // namespace isofront::render

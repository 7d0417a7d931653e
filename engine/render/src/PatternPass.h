#pragma once

#include "Stage.h"
#include "Targets.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Image.h>
#include <isofront/voxels/LevelEvaluation.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::render {

/// Finds the nearest voxel of a picture on the GPU, as voxels::patternNode does of a picture in
/// memory.
class PatternPass {
public:
    /// @param slots    how many frames may be in flight
    /// @param samples  of the picture's pixels; the first ones are looked at
    static core::Result<PatternPass>
    create(gpu::Device& device, std::uint32_t slots, VkSampleCountFlagBits samples);

    /// Finds it in what was drawn. The names are sampled, the depth is drawn into, before and
    /// after.
    void record(
        VkCommandBuffer commands,
        std::size_t slot,
        const gpu::Image& names,
        const gpu::Image& depth) const;

    struct Found {
        voxels::PatternNode node; ///< its id is the name
        std::uint64_t voxelPixels = 0;
    };
    /// What the slot's commands, which have been carried out, have found; none if no pixel shows a
    /// voxel.
    [[nodiscard]] std::optional<Found> found(std::size_t slot) const;

private:
    struct Slot {
        gpu::Buffer found;   ///< a shared::Pattern
        gpu::Buffer partial; ///< of each group, as Pattern::nearest
        gpu::Buffer seen;    ///< what was found, for the CPU
    };
    gpu::Sampler _nearest;
    Stage _stage;
    gpu::Pipeline _pipeline;
    std::vector<Slot> _slots;
};

} // namespace isofront::render

#pragma once

#include "MeshStore.h"
#include "isofront/render/HandOver.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Commands.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Timestamps.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::render {

/// What one of the frames in flight owns.
struct Slot {
    gpu::Commands commands;
    gpu::Timestamps timestamps;
    std::vector<const char*> passes; ///< that its last frame had
    std::uint64_t streamed = 0;      ///< number of its streamed frame, until that is settled
    bool hasVoxels = false;          ///< whether that frame shows or tests any
    gpu::Buffer frame;               ///< a shared::Frame
    gpu::Buffer cells;               ///< a shared::DrawnCell for each draw
    gpu::Buffer draws;               ///< a VkDrawIndexedIndirectCommand for each draw
    gpu::Buffer owners;              ///< a byte for each block: HandOver::blocks
};

core::Result<Slot> makeSlot(gpu::Device& device);

/// Makes sure that the slot, which the GPU is done with, has room for so many draws.
core::Result<void> reserveDraws(gpu::Device& device, Slot& slot, std::size_t count);

/// Gives the slot, which the GPU is done with, the owners of a hand-over's blocks; null for none.
core::Result<void> fillOwners(gpu::Device& device, Slot& slot, const HandOver* handOver);

/// Writes what the passes over the mesh read of these cells, from a draw on.
/// @param pictures  what each cell is part of, by `picturesInto`
/// @param order     indices into `cells`
/// @return how many triangles they have
std::uint64_t fillDraws(
    const Slot& slot,
    std::span<const StoredCell> cells,
    std::span<const std::uint32_t> pictures,
    std::span<const std::uint32_t> order,
    std::size_t first);

} // namespace isofront::render

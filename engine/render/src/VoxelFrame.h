#pragma once

#include "SunBox.h"
#include "VoxelStore.h"
#include "isofront/render/Voxels.h"
#include "shared/voxels.h"

#include <isofront/hierarchy/View.h>

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <span>
#include <vector>

namespace isofront::render {

/// What the GPU gets to draw a frame's voxels. The chunks are in this order: shown as splats, shown
/// as cubes, shown as cubes in one of two pictures only, tested by their boxes only, and those that
/// cast shadows, which may be the same ones again; within each but the last the nearest first.
struct VoxelFrame {
    shared::VoxelView view{};
    std::vector<shared::DrawnChunk> chunks;
    std::vector<voxels::ChunkKey> keys; ///< of the chunks but those that cast shadows
    std::vector<std::uint32_t> places;  ///< of these, in the list that the frame was made from
    std::size_t listed = 0;             ///< chunks in that list
    /// Places of chunks that were only to be tested, but are too close for it.
    std::vector<std::uint32_t> untested;
    std::vector<shared::VoxelBlock> blocks;
    std::vector<VkDrawIndexedIndirectCommand> cubes;
    std::size_t fadingCubes = 0;   ///< so many of them, the last ones, fade
    std::uint32_t splatBlocks = 0; ///< the first of the blocks
    std::uint32_t firstBox = 0;    ///< chunks from there on are only tested
    std::uint32_t boxes = 0;
    std::vector<VkDrawIndexedIndirectCommand> shadows;
    VoxelStats stats;
    bool findsPattern = false;
};

/// What the voxel of a name is, which isn't 0.
ShownVoxel voxelNamed(const VoxelFrame& frame, std::uint32_t name);

/// Voxels that one draw of cubes may have: its indices have 16 bits.
inline constexpr std::uint32_t kVoxelsInDraw = 65536 / shared::kCornersOfVoxel;

/// Decides what is drawn and how: leaves out what is outside the view pyramid, and orders the rest.
/// A chunk around whose box the eye is too close to test it is shown.
///
/// @param near    distance of the near plane [world]
/// @param chunks  in any order
/// @param splats  false if nothing may be splatted
/// @param pictures  that the frame shows; chunks that are part of none of them are left out
VoxelFrame voxelFrame(
    const hierarchy::View& view,
    double near,
    const VoxelScene& scene,
    std::span<const PlacedChunk> chunks,
    bool splats,
    std::uint32_t pictures);

/// Adds those chunks that may cast shadows into the sun's map, as they are in the present picture.
/// @param sun  seen from the view's eye
void addCasters(
    VoxelFrame& frame,
    const hierarchy::View& view,
    const VoxelScene& scene,
    const SunBox& sun,
    std::span<const PlacedChunk> chunks);

} // namespace isofront::render

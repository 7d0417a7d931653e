#pragma once

#include <isofront/voxels/Chunk.h>
#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/ChunkTree.h>
#include <isofront/voxels/ChunkView.h>
#include <isofront/voxels/LevelEvaluation.h>
#include <isofront/voxels/LevelTransition.h>
#include <isofront/voxels/Voxelization.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace isofront::render {

class HandOver;

/// How voxels are drawn. Both ways give the same picture, but for single pixels at edges.
enum class VoxelWay {
    automatic, ///< by the size that a chunk's voxels have on screen, and by the device
    cubes,     ///< as up to three rasterised faces: best for voxels of many pixels
    /// By compute shaders, a thread for each voxel: best for voxels of few pixels. Devices without
    /// 64-bit atomics, and pictures of more than 16 million pixels, get cubes.
    splats,
};

/// A chunk to be drawn; it must have been added to the renderer.
struct VoxelDraw {
    voxels::ChunkKey key;
    /// Nothing of it is shown: it is only found out whether its box is hidden by what is.
    bool occlusionOnly = false;
    /// 1: it looks like itself. Less, on the way to how its parent looks at 0: see
    /// voxels::transitionWeight. That takes its transition and the parent chunk, which both must
    /// have been added; without them, it looks like itself.
    float weight = 1;
    /// Which of the two pictures of a transition it is part of: see Renderer::beginTransition. Each
    /// of them should be whole in itself.
    bool inFormer = true;
    bool inPresent = true;
};

/// What it takes to draw a chunk on the way from its parent.
struct VoxelTransition {
    voxels::ChunkKey key;
    voxels::TransitionNodes nodes;
};

/// What is shown of a voxel model in one frame: chunks that were added to the renderer, or what a
/// streamer says.
struct VoxelScene {
    voxels::VoxelLattice lattice;       ///< where the model's voxels lie
    std::span<const VoxelDraw> draws{}; ///< in any order
    /// Instead of `draws`: chunks where a streamer has placed them, of frames that were applied;
    /// those of its second pass may follow. `tree` is the streamer's.
    std::span<const voxels::ChunkDraw> placed{};
    const voxels::ChunkTree* tree = nullptr;
    /// What casts shadows, besides meshes: what the streamer says of `Renderer::sunlight`. If there
    /// is none, all chunks above do, in view or not, as fine as they are.
    std::span<const voxels::ChunkDraw> casters{};
    /// The streamer's number of the frame, by which `takeSights` and `completedFrame` name it; 0
    /// for none.
    std::uint64_t frame = 0;
    /// Where meshes and where voxels are shown, in each of the two pictures; null to show all that
    /// there is. A chunk of which nothing is shown for that reason counts as visible.
    const HandOver* handOver = nullptr;
    VoxelWay way = VoxelWay::automatic;
    /// Automatic: voxels of more pixels become cubes [px]. Both cost the same at about 7 px with a
    /// driver in software; devices with a rasteriser may do better with less.
    float largestSplat = 6;
    /// Whether to find the picture's pattern node, see ShownPattern. Costs two looks at each pixel.
    bool findsPattern = false;
};

/// What the sun's map covers in a picture, for voxels::ChunkStreamer::casters.
struct Sunlight {
    voxels::ChunkView space;
    double texel = 0; ///< width of the map's [world]
};

/// What a pixel shows of a voxel model.
struct ShownVoxel {
    voxels::ChunkKey chunk;
    /// Its index in the chunk; from the number of its voxels on, that of a redundant node.
    std::uint32_t voxel = 0;
    bool isThere = false; ///< false: a mesh or the background

    friend bool operator==(const ShownVoxel&, const ShownVoxel&) = default;
};

/// The voxel that is nearest to the eye in a picture, of equally near ones the first that was
/// drawn: what voxels::patternNode finds, but found by the GPU. For voxels::LevelControl, by
/// voxels::fillOf.
struct ShownPattern {
    ShownVoxel voxel;
    voxels::PatternNode node;      ///< its id is a number in this picture only
    std::uint64_t voxelPixels = 0; ///< that show any voxel, for LevelObservation::pixels
};

/// Whether a chunk can be seen in a picture.
struct ChunkSight {
    voxels::ChunkKey chunk;
    bool isVisible = false;

    friend bool operator==(const ChunkSight&, const ChunkSight&) = default;
};

/// Which of a streamed frame's chunks can be seen, for voxels::Visibility.
struct FrameSight {
    std::uint64_t frame = 0;
    std::vector<std::uint32_t> visible; ///< not 0 if it can; in the order of the frame's chunks
    /// If it was asked for, and any voxel is seen.
    std::optional<ShownPattern> pattern{};
};

/// What a frame's voxels were.
struct VoxelStats {
    /// In the chunks drawn, redundant nodes included. All of a chunk's count, also of one that is
    /// shown in part: at the hand-over, where meshes have some of its blocks.
    std::uint64_t voxels = 0;
    std::uint64_t splatted = 0;      ///< of these, drawn by compute shaders
    std::size_t chunksDrawn = 0;     ///< in the view pyramid, and shown
    std::size_t chunksFading = 0;    ///< of these, in one of the two pictures of a transition only
    std::size_t chunksCulled = 0;    ///< outside the view pyramid
    std::uint64_t shadowVoxels = 0;  ///< in the chunks that may cast shadows, drawn once more
    std::size_t boxes = 0;           ///< of chunks that are only tested
    std::uint64_t uploadedBytes = 0; ///< since the last frame
    std::uint64_t poolBytesUsed = 0; ///< of the voxel pool, chunks on their way out included
};

} // namespace isofront::render

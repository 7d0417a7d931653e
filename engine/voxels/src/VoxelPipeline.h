#pragma once

#include "WeightedVoxel.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkSink.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

namespace isofront::voxels {

/// Where a chunk stands among those of level 0.
using ChunkPlace = std::array<std::uint32_t, 3>;

/// What voxels are made from: all that differs between kinds of models.
class VoxelSource {
public:
    VoxelSource() = default;
    VoxelSource(const VoxelSource&) = delete;
    VoxelSource& operator=(const VoxelSource&) = delete;
    virtual ~VoxelSource() = default;

    /// A chunk that may have voxels, and how much work it is, in any unit.
    struct Task {
        ChunkPlace place{};
        std::uint64_t work = 1;
    };
    /// Chunks of level 0 along each axis.
    [[nodiscard]] virtual ChunkPlace counts() const = 0;
    [[nodiscard]] virtual bool isColoured() const = 0;
    /// Chunks that are not named have no voxels.
    [[nodiscard]] virtual std::vector<Task> tasks() = 0;
    /// The voxels of a chunk, in their order, without faces. Thread: any number at once.
    virtual void make(const ChunkPlace& place, VoxelList& list) = 0;
};

struct PipelineSettings {
    std::uint32_t levels = 1;
    bool allFaces = false;
    std::filesystem::path scratchFolder{};
};

struct PipelineReport {
    std::uint64_t voxels = 0; ///< of level 0
    std::uint64_t allVoxels = 0;
    std::uint64_t chunks = 0;
    std::uint64_t emptyRegions = 0;
    std::uint64_t scratchBytes = 0;
    double makeSeconds = 0;   ///< processor time of VoxelSource::make [s]
    double reduceSeconds = 0; ///< the same of making coarser levels from finer ones
};

/// Makes all chunks of all levels: the voxels of each chunk of level 0 wait in a file until it is
/// known what is outside; then they get their faces, and are reduced level by level.
///
/// Errors and arguments as those of `voxelize`.
core::Result<PipelineReport> runPipeline(
    VoxelSource& source,
    const PipelineSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled,
    const std::function<void(double)>& progress);

} // namespace isofront::voxels

#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkSink.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace isofront::voxels {

/// A folder, and what is free on the disk that it lies on.
struct DiskFolder {
    std::filesystem::path path;
    std::uint64_t disk = 0;      ///< the same number for folders on the same disk
    std::uint64_t freeBytes = 0; ///< for this user
};

/// @return `inputOutput` for a folder that isn't there, or of which the system tells nothing
core::Result<DiskFolder> diskFolderOf(const std::filesystem::path& path);

/// What voxelising takes on disks [bytes].
struct DiskNeed {
    std::uint64_t model = 0;   ///< all chunks, where the model goes
    std::uint64_t scratch = 0; ///< where chunks wait between the passes, gone at the end
};

/// Takes the chunks of a coarse trial and keeps nothing but what those of level 0 come to.
class TrialSink final : public ChunkSink {
public:
    std::optional<core::Error> put(Chunk chunk) override;
    [[nodiscard]] std::uint64_t bytes() const { return _bytes; } ///< as they lie in stores

private:
    std::uint64_t _bytes = 0;
};

/// How coarse a trial is that tells nearly what a resolution takes: of a sixteenth of the voxels,
/// or fewer; nothing where there is room for any model but the wildest anyway. Each is as many
/// voxels along the longest edge.
std::optional<std::uint32_t>
trialResolution(std::uint32_t resolution, const DiskFolder& model, const DiskFolder& scratch);

/// What `resolution` takes, from a trial: voxels on a surface become four times as many where
/// their edge is halved, and a third more are those of coarser levels.
/// @param level0   TrialSink::bytes
/// @param scratch  VoxelizationReport::scratchBytes of the trial
DiskNeed neededAt(
    std::uint32_t resolution, std::uint32_t trial, std::uint64_t level0, std::uint64_t scratch);

/// Refuses with `resourceLimit` what surely doesn't fit, as estimates go: a rough surface takes
/// more than a trial tells, a smooth one less, by a fifth. The message names the folder, what is
/// free there, what is needed, and a resolution that would fit.
core::Result<void> checkDiskRoom(
    const DiskNeed& need,
    std::uint32_t resolution,
    const DiskFolder& model,
    const DiskFolder& scratch);

} // namespace isofront::voxels

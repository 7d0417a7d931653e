#include "isofront/voxels/DiskRoom.h"

#include "ChunkCodec.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

namespace isofront::voxels {

namespace {

/// The finest trial [voxels along the longest edge]; a second or two, of an hour that follows.
constexpr std::uint32_t kFinestTrial = 512;
/// Below this a trial would see too little of a model's shape, and there is not much to be saved.
constexpr std::uint32_t kCoarsestTrial = 64;
/// What a voxel of level 0 takes, of the model with all its levels and between the passes [bytes]:
/// 11 to 16 and 20 to 40 were measured, the more where they have colours.
constexpr std::uint64_t kVoxelBytes = 56;
/// Voxels that nearly no surface exceeds, for each square of the resolution: a box in its whole
/// cube has 6, gyroids have 3.5.
constexpr std::uint64_t kMostVoxels = 24;
/// An estimate is refused if even so much of it doesn't fit.
constexpr double kSurely = 0.75;

std::string gibibytes(std::uint64_t bytes)
{
    std::array<char, 32> text{};
    const double amount = static_cast<double>(bytes) / 1073741824.0;
    std::snprintf(text.data(), text.size(), amount < 10 ? "%.1f GiB" : "%.0f GiB", amount);
    return amount < 1 ? std::to_string(bytes >> 20U) + " MiB" : text.data();
}

std::uint64_t scaled(std::uint64_t bytes, double factor)
{
    return static_cast<std::uint64_t>(std::min(static_cast<double>(bytes) * factor, 0x1p62));
}

/// Refuses what doesn't fit into one folder's disk.
/// @param what    it is for, before "a model of ..."
/// @param besides what else it is, after that
core::Result<void> check(
    std::uint64_t bytes,
    std::uint32_t resolution,
    const DiskFolder& folder,
    const char* what,
    const char* besides)
{
    if (kSurely * static_cast<double>(bytes) <= static_cast<double>(folder.freeBytes))
        return {};
    const double share = static_cast<double>(folder.freeBytes) / static_cast<double>(bytes);
    const auto fits = static_cast<std::uint32_t>(std::sqrt(share) * resolution);
    // to two digits or three: nobody knows more of it
    const std::uint32_t step = fits >= 1000 ? 100 : 10;
    return core::failure(
        core::ErrorCode::resourceLimit,
        folder.path.string() + ": " + gibibytes(folder.freeBytes) + " are free on this disk, and " +
            what + "a model of " + std::to_string(resolution) +
            " voxels along the longest edge would take about " + gibibytes(bytes) + besides +
            (fits >= step ? "; free some space, choose another folder, or at most --resolution " +
                                std::to_string(fits / step * step)
                          : "; free some space, or choose another folder"));
}

} // namespace

core::Result<DiskFolder> diskFolderOf(const std::filesystem::path& path)
{
    DiskFolder folder;
    folder.path = path;
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0)
        return core::failure(
            core::ErrorCode::inputOutput, path.string() + ": " + std::strerror(errno));
    folder.disk = status.st_dev;
    std::error_code failed;
    const auto space = std::filesystem::space(path, failed);
    if (failed)
        return core::failure(core::ErrorCode::inputOutput, path.string() + ": " + failed.message());
    folder.freeBytes = space.available;
    return folder;
}

std::optional<core::Error> TrialSink::put(Chunk chunk)
{
    if (chunk.key.level == 0)
        _bytes += encoded(chunk).size();
    return std::nullopt;
}

std::optional<std::uint32_t>
trialResolution(std::uint32_t resolution, const DiskFolder& model, const DiskFolder& scratch)
{
    const std::uint64_t most =
        kMostVoxels * kVoxelBytes * std::uint64_t{resolution} * std::uint64_t{resolution};
    const std::uint32_t trial = std::min(kFinestTrial, resolution / 4);
    if (trial < kCoarsestTrial || most <= std::min(model.freeBytes, scratch.freeBytes))
        return std::nullopt;
    return trial;
}

DiskNeed
neededAt(std::uint32_t resolution, std::uint32_t trial, std::uint64_t level0, std::uint64_t scratch)
{
    const double edges = static_cast<double>(resolution) / trial;
    return {
        .model = scaled(level0, edges * edges * 4 / 3), .scratch = scaled(scratch, edges * edges)};
}

core::Result<void> checkDiskRoom(
    const DiskNeed& need,
    std::uint32_t resolution,
    const DiskFolder& model,
    const DiskFolder& scratch)
{
    constexpr const char* kWaiting = "what waits there between the passes for ";
    if (model.disk == scratch.disk)
        return check(
            need.model + need.scratch,
            resolution,
            model,
            "",
            ", what waits between the passes included");
    if (const auto fits = check(need.model, resolution, model, "", ""); !fits)
        return fits;
    return check(need.scratch, resolution, scratch, kWaiting, "");
}

} // namespace isofront::voxels

#include "MeshLevelSet.h"

#include "MeshBlocks.h"

#include <isofront/core/Box.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <new>
#include <string>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

/// What OpenVDB holds of a block at most: distances, nearest triangles, masks, and copies of them
/// while threads' parts are joined. As measured, rounded up.
constexpr std::uint64_t kBytesPerBlock = 7000;
/// Of the nodes above them: eight around the origin for each of two trees, however small the mesh.
constexpr std::uint64_t kBytesAtLeast = 5'000'000;
constexpr std::uint64_t kBytesPerTriangle = 12;
constexpr std::uint64_t kBytesPerPosition = 24;

core::Result<void> checkOptions(const LevelSetOptions& options)
{
    if (options.resolution < LevelSetOptions::kLeastResolution ||
        options.resolution > LevelSetOptions::kMostResolution)
        return failure(
            ErrorCode::usage,
            "a mesh can have " + std::to_string(LevelSetOptions::kLeastResolution) + " to " +
                std::to_string(LevelSetOptions::kMostResolution) +
                " voxels along its longest edge, not " + std::to_string(options.resolution));
    if (options.reach && !(*options.reach > 0 && std::isfinite(*options.reach)))
        return failure(ErrorCode::usage, "how far distances are known must be a number above 0");
    return {};
}

/// The triangles that are sound, in voxels, so that the lowest is half a voxel from the origin:
/// walls along the axes then lie amid voxels, where their sides are plain.
core::Result<IndexedMesh> indexed(const Triangles& mesh, const LevelSetOptions& options)
{
    const std::uint64_t bytes =
        mesh.positions.size() * kBytesPerPosition + mesh.corners.size() * kBytesPerTriangle;
    if (bytes > options.memoryLimit)
        return failure(
            ErrorCode::resourceLimit,
            "the mesh takes " + std::to_string(bytes >> 20U) +
                " MiB, which is above the limit of " + std::to_string(options.memoryLimit >> 20U) +
                " MiB; raise the limit or simplify the mesh");
    if (mesh.corners.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        return failure(
            ErrorCode::resourceLimit, "the mesh has more than 2^31 triangles; simplify it");
    const auto isSound = [&](const std::array<std::uint32_t, 3>& corners) {
        return std::ranges::all_of(corners, [&](std::uint32_t corner) {
            if (corner >= mesh.positions.size())
                return false;
            const glm::dvec3& p = mesh.positions[corner];
            return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
        });
    };
    IndexedMesh result;
    core::Box box;
    for (const auto& corners : mesh.corners) {
        if (!isSound(corners))
            continue;
        result.corners.push_back(corners);
        for (const std::uint32_t corner : corners)
            box.include(mesh.positions[corner]);
    }
    if (result.corners.empty())
        return failure(
            ErrorCode::badData,
            mesh.corners.empty() ? "the mesh has no triangles, so there is no distance from it"
                                 : "none of the mesh's triangles has three finite corners that are "
                                   "there; export it again");
    const glm::dvec3 size = box.size();
    const double longest = std::max({size.x, size.y, size.z});
    result.voxel = longest / options.resolution;
    // Sizes are kept as floats, and places as doubles that must tell voxels apart.
    const double farthest = std::max(
        {std::abs(box.low.x),
         std::abs(box.low.y),
         std::abs(box.low.z),
         std::abs(box.high.x),
         std::abs(box.high.y),
         std::abs(box.high.z)});
    constexpr double kLeastVoxel = 1e-30;
    constexpr double kMostVoxel = 1e30;
    constexpr double kLeastShare = 0x1p-40; // of the distance from the origin
    if (longest == 0)
        return failure(
            ErrorCode::badData, "all corners of the mesh lie in one point; export it again");
    if (!(result.voxel >= kLeastVoxel && result.voxel <= kMostVoxel))
        return failure(
            ErrorCode::badData, "the mesh is too small or too large for floats; scale it");
    if (result.voxel < kLeastShare * farthest)
        return failure(
            ErrorCode::badData,
            "the mesh lies so far from the origin that its voxels can't be told apart; move it");
    result.origin = box.low - 0.5 * result.voxel;
    result.positions.resize(mesh.positions.size(), glm::dvec3(0.0));
    for (const auto& corners : result.corners)
        for (const std::uint32_t corner : corners)
            result.positions[corner] = (mesh.positions[corner] - result.origin) / result.voxel;
    return result;
}

/// Fails if the level set would take too much memory, by the blocks that it will have.
core::Result<void>
checkMemory(const IndexedMesh& mesh, double reach, const LevelSetOptions& options)
{
    constexpr std::size_t kBetweenLooks = 4096;
    MeshBlocks blocks(glm::dvec3(options.resolution + 1), reach + 2);
    for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
        if (i % kBetweenLooks == 0 && options.stop.stop_requested())
            return failure(ErrorCode::interrupted, "loading was stopped");
        const auto& [a, b, c] = mesh.corners[i];
        blocks.add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
    }
    const std::uint64_t bytes = kBytesAtLeast + blocks.countWithinReach() * kBytesPerBlock +
                                mesh.corners.size() * kBytesPerTriangle +
                                mesh.positions.size() * kBytesPerPosition;
    if (bytes > options.memoryLimit)
        return failure(
            ErrorCode::resourceLimit,
            "distances from the mesh would take about " + std::to_string(bytes >> 20U) +
                " MiB, which is above the limit of " + std::to_string(options.memoryLimit >> 20U) +
                " MiB; raise the limit, or choose fewer voxels or less reach");
    return {};
}

core::Result<LoadedVolume> levelSet(const Triangles& given, const LevelSetOptions& options)
{
    if (const auto checked = checkOptions(options); !checked)
        return tl::unexpected(checked.error());
    const auto mesh = indexed(given, options);
    if (!mesh)
        return tl::unexpected(mesh.error());
    constexpr double kLeastReach = 4; // [voxels]
    constexpr double kUsualShare = 1.0 / 16;
    const double most = options.resolution;
    const double asked = options.reach ? *options.reach / mesh->voxel : kUsualShare * most;
    if (asked > most * (1 + 1e-9))
        return failure(
            ErrorCode::usage,
            "distances can be known within " + std::to_string(most * mesh->voxel) +
                " of the mesh, the longest edge of its box, not " + std::to_string(*options.reach));
    const double reach = std::max(asked, kLeastReach);
    if (const auto checked = checkMemory(*mesh, reach, options); !checked)
        return tl::unexpected(checked.error());
#ifdef ISOFRONT_WITH_OPENVDB
    return levelSetThroughOpenVdb(*mesh, reach, options);
#else
    return failure(
        ErrorCode::usage,
        "this build can't turn meshes into distances; configure it with "
        "-DISOFRONT_WITH_OPENVDB=ON");
#endif
}

} // namespace

core::Result<LoadedVolume> levelSetOf(const Triangles& mesh, const LevelSetOptions& options)
{
    try {
        return levelSet(mesh, options);
    } catch (const std::bad_alloc&) {
        return failure(
            ErrorCode::resourceLimit,
            "distances from the mesh don't fit in memory; choose fewer voxels");
    } catch (const std::exception& exception) {
        return failure(
            ErrorCode::badData,
            std::string("the mesh can't be turned into distances: ") + exception.what());
    }
}

} // namespace isofront::volume

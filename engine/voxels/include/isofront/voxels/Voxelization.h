#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkSink.h>
#include <isofront/voxels/TriangleModel.h>

#include <glm/vec3.hpp>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>

namespace isofront::voxels {

/// Which voxels stand for a surface.
enum class Separability {
    /// No path from face to face gets through, and no voxel is superfluous: the fewest that hide
    /// what lies behind.
    six,
    /// Every voxel that a triangle touches, about twice as many: contains the surface.
    conservative,
};

/// Where a model's voxels lie: voxel (i, j, k) of level 0 is the cube from `origin + edge (i, j,
/// k)` on.
struct VoxelLattice {
    glm::dvec3 origin{0.0};       ///< [world]
    double edge = 1;              ///< of a voxel of level 0 [world]
    std::uint32_t resolution = 0; ///< voxels along the longest edge of the model
    std::uint32_t levels = 1;     ///< of detail; the coarsest is one chunk

    friend bool operator==(const VoxelLattice&, const VoxelLattice&) = default;
};

/// The lattice that fits a box, with a quarter of a voxel to spare at either end, so that walls
/// along the axes don't lie between two voxels.
/// @param resolution  1 to kMaxResolution
VoxelLattice latticeFor(const core::Box& bounds, std::uint32_t resolution);

/// How many levels of detail there are, so that the coarsest is one chunk.
/// @param resolution  at least 1
std::uint32_t levelsFor(std::uint32_t resolution);

inline constexpr std::uint32_t kMaxResolution = 1U << 16U;

struct VoxelizationSettings {
    std::uint32_t resolution = 256; ///< along the longest edge of the model, 1 to kMaxResolution
    Separability separability = Separability::six;
    /// Show both sides of every voxel, for models that a viewer may enter.
    bool allFaces = false;
    /// Where chunks wait between the passes; empty for the system's folder for such.
    std::filesystem::path scratchFolder{};
};

struct VoxelizationReport {
    ModelReport model;
    VoxelLattice lattice;
    std::uint64_t voxels = 0;       ///< of level 0
    std::uint64_t touched = 0;      ///< cubes of level 0 that a triangle touches
    std::uint64_t allVoxels = 0;    ///< of all levels
    std::uint64_t chunks = 0;       ///< of all levels
    std::uint64_t emptyRegions = 0; ///< parts of empty space that are closed off from outside
    std::uint64_t scratchBytes = 0; ///< what waited between the passes [bytes]
    double rasterSeconds = 0; ///< processor time of turning triangles into voxels of level 0 [s]
    double reduceSeconds = 0; ///< processor time of making coarser levels from finer ones [s]
};

/// Turns a mesh into surface voxels of all levels of detail, chunk by chunk.
///
/// A voxel's normal and colour are those of the triangles in it, weighted by the exact area within
/// the cube. Which voxels there are is decided in integers, on a lattice of 1/4096 voxel. A face
/// can be seen if the next cube is empty and connected with the space around the model; for open
/// models that is both sides. The same model gives the same chunks with any number of threads.
///
/// Memory: the model, 28 bytes a triangle, some megabytes a thread; everything else waits in the
/// scratch folder. Fails with `usage` for a resolution out of range, `badData` for a model without
/// a usable triangle, or one so large, so small or so far away that numbers can't tell its voxels
/// apart, `inputOutput` for a full disk, with what the sink says, and `interrupted`.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 3; S. Laine, "A topological approach to voxelization" (2013), for the six-separating
/// subset. Differs: masks from what is outside, not from normals, which let light through.
///
/// @param progress  told how much is done, from 0 to 1; may be null
core::Result<VoxelizationReport> voxelize(
    const TriangleModel& model,
    const VoxelizationSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled = nullptr,
    const std::function<void(double)>& progress = nullptr);

} // namespace isofront::voxels

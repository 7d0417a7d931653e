#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace isofront::voxels {

/// A half-line to be cast through a model.
struct Ray {
    glm::dvec3 start{0.0};                                  ///< [world]
    glm::dvec3 direction{0, 0, 1};                          ///< of any length but 0 [world]
    double reach = std::numeric_limits<double>::infinity(); ///< no hits beyond it [world]
};

/// The first voxel on a ray.
struct VoxelHit {
    ChunkKey chunk;                       ///< that holds it; its level is the voxel's
    std::uint32_t index = 0;              ///< among the chunk's voxels
    std::array<std::uint32_t, 3> place{}; ///< among the voxels of its level
    std::optional<Face> face;             ///< that the ray came in by; none if it starts inside
    double distance = 0;                  ///< from the ray's start [world]
    glm::dvec3 normal{0, 0, 1}; ///< of the surface in the voxel, outward, seen from that face
    std::optional<std::uint32_t> colour; ///< as in Chunk, if the model has colours

    friend bool operator==(const VoxelHit&, const VoxelHit&) = default;
};

/// Chunks that stand for a model together, each place at one level of detail: the keys of a level,
/// or what a view's selection shows.
using ChunkCut = std::vector<ChunkKey>;

/// All chunks of one level.
ChunkCut cutOfLevel(const ChunkStore& store, std::uint32_t level);

struct RayCasterSettings {
    /// Loaded chunks are kept up to this many bytes. Each thread that casts holds one chunk beside
    /// them at most.
    std::size_t cacheBytes = std::size_t{256} << 20U;
};

/// What casting took.
struct RayCasterStatistics {
    std::uint64_t loads = 0;   ///< of chunks from the store
    std::size_t bytes = 0;     ///< of chunks that are kept now
    std::size_t treeBytes = 0; ///< of these, for finding empty space
};

/// Casts rays through the voxels of a model, for picking and as a check of pictures. Voxels are
/// solid from all sides, whichever faces they show.
///
/// Start and direction are rounded once: to 2^-30 of the edge of the model's coarsest chunk, and
/// 2^-30 of the direction's longest component. From there on all is exact, in integers, without a
/// tolerance: nothing leaks through edges and corners, a coarser level is hit where a finer one is
/// or before, and the result is the same on every machine. A ray that meets an edge or a corner is
/// walked as if its start lay infinitely little further along x, even less along y, and still less
/// along z.
///
/// Chunks are read when a ray first comes to them. Empty space is crossed in cubes of up to a
/// chunk.
///
/// Thread: any number may cast at once.
///
/// Source: C. Willcocks, "Sparse volumetric deformation" (2013), section 4.3, for leaping over
/// empty space. Differs: exact; the source moves the ray on by a small distance, which misses cubes
/// and gets stuck.
class VoxelRayCaster {
public:
    /// @param store  must outlive the caster
    /// @return `usage` if chunks of the cut overlap or the store has none of such name
    static core::Result<VoxelRayCaster>
    create(const ChunkStore& store, const ChunkCut& cut, const RayCasterSettings& settings = {});

    VoxelRayCaster(VoxelRayCaster&&) noexcept;
    VoxelRayCaster& operator=(VoxelRayCaster&&) noexcept;
    ~VoxelRayCaster();

    /// @return the first voxel on a ray, or none. Rays that are not finite, or without a direction,
    /// are `usage`; a chunk that can't be read is what the store says.
    [[nodiscard]] core::Result<std::optional<VoxelHit>> cast(const Ray& ray) const;
    /// The same for many rays, on all cores, in their order. Of failures, the first ray's counts.
    [[nodiscard]] core::Result<std::vector<std::optional<VoxelHit>>>
    cast(std::span<const Ray> rays, core::Jobs& jobs) const;

    [[nodiscard]] RayCasterStatistics statistics() const;

private:
    struct Parts;
    explicit VoxelRayCaster(std::unique_ptr<Parts> parts);

    std::unique_ptr<Parts> _parts;
};

} // namespace isofront::voxels

#pragma once

#include "isofront/volume/LoadVolume.h"

#include <isofront/core/Result.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

namespace isofront::volume {

/// A mesh as it lies in memory.
struct Triangles {
    std::span<const glm::dvec3> positions; ///< [world]
    /// Of corners. Those that name a position that isn't there, or one that isn't finite, are left
    /// out.
    std::span<const std::array<std::uint32_t, 3>> corners;
};

struct LevelSetOptions {
    static constexpr int kLeastResolution = 8;
    static constexpr int kMostResolution = 2048;

    int resolution = 256; ///< voxels along the longest edge of the mesh's box
    /// [world] How far from the surface distances are known, on either side: at least four voxels,
    /// at most the longest edge of the box. Nothing: a sixteenth of that edge.
    std::optional<double> reach = {};
    /// Whether what the mesh encloses is solid. If not, a shell around the triangles is.
    bool isSolid = true;
    /// [bytes] What the work may hold at once, about: checked by an estimate before it begins.
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U;
    std::stop_token stop = {}; ///< looked at all along
};

/// The distance from a mesh as a sparse volume of cubic voxels: negative inside, as in a level set
/// from a file, and like that the field is negated with its isovalue. So an isovalue is an offset
/// in world units: 0 shows the mesh, 1 what lies up to 1 outside of it, -1 what lies at least 1
/// inside. Beyond the reach, distances are cut off; there is no surface at isovalues beyond it.
///
/// Inside is what can't be reached from without, at the voxels' resolution: how triangles are wound
/// doesn't matter, overlapping parts become one, cavities are filled, gaps narrower than a voxel
/// are closed, and parts thinner than a voxel may be missed. Through a wider gap the outside
/// enters; so a mesh with open edges should be asked for as a shell: solid within 1.5 voxels of its
/// triangles, without holes, and thicker where it is filtered, so that it is seen from afar. A mesh
/// that encloses nothing that a voxel could hold becomes a shell, too, and a note says so.
///
/// A voxel's value is the distance from it to the nearest triangle, as near as a float holds it;
/// near the reach, where nearest triangles are handed on from voxel to voxel, it can be a little
/// larger. The voxels are the same on any number of threads.
///
/// Errors: usage for options out of range, and in a build without OpenVDB; badData for no
/// usable triangle, and a size or a place that voxels can't express; resourceLimit; interrupted.
/// Thread: any; the work is done by all threads of oneTBB.
core::Result<LoadedVolume> levelSetOf(const Triangles& mesh, const LevelSetOptions& options = {});

} // namespace isofront::volume

#pragma once

#include "isofront/volume/MeshLevelSet.h"

#include <vector>

namespace isofront::volume {

/// A mesh among voxels, all of it sound.
struct IndexedMesh {
    std::vector<glm::dvec3> positions; ///< [voxels]
    std::vector<std::array<std::uint32_t, 3>> corners;
    glm::dvec3 origin{0.0}; ///< [world] of voxel (0, 0, 0)
    double voxel = 1;       ///< [world]
};

/// Turns a mesh into a level set through OpenVDB. May throw what OpenVDB throws.
/// @param reach  [voxels]
core::Result<LoadedVolume>
levelSetThroughOpenVdb(const IndexedMesh& mesh, double reach, const LevelSetOptions& options);

} // namespace isofront::volume

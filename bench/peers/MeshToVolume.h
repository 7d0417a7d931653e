#pragma once

// What the module of OpenVDB's voxeliser and its callers agree upon, as in VolumeToMesh.h.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::bench::peers {

/// What OpenVDB makes of a mesh: voxels within one voxel's edge of it, with their distances.
struct PeerVoxels {
    std::size_t voxels = 0;
    std::size_t bytes = 0; ///< of the tree in memory
};

/// `isofrontMeshToVolume`: on one thread.
/// @param positions  in voxels
/// @param isSigned   says what is inside, too
using MeshToVolume = PeerVoxels (*)(
    const std::vector<std::array<double, 3>>& positions,
    const std::vector<std::array<std::uint32_t, 3>>& triangles,
    bool isSigned);

} // namespace isofront::bench::peers

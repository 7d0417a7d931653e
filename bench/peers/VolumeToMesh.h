#pragma once

// What the module of OpenVDB's mesher and its callers agree upon. It is loaded only when it is
// measured, so that the benchmarks link no mesher that nothing else needs.

#include "PeerMesh.h"

#include <array>
#include <vector>

namespace isofront::bench::peers {

/// `isofrontVolumeToMesh`: the mesh, without normals, on one thread. Quadrangles are cut along
/// their shorter diagonal. What closes the surface at the border of the samples is left out.
/// @param values      x fastest, then y; solid is at or above the isovalue
/// @param adaptivity  0: all quadrangles of one size; up to 1: larger ones where it is flat
using VolumeToMesh = void (*)(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue,
    double adaptivity,
    PeerMesh& mesh);

/// `isofrontOpenVdbVersion`.
using OpenVdbVersion = const char* (*)();

} // namespace isofront::bench::peers

#pragma once

// What the module of VTK's flying edges and its callers agree upon. The module is compiled as C++17
// and without our warnings, because VTK 9.1's headers are no C++20, and loaded only when it is
// measured, so that the program itself needs no VTK.

#include "PeerMesh.h"

#include <array>
#include <vector>

namespace isofront::bench::peers {

/// `isofrontFlyingEdgesTime`: what it takes, normals included.
/// @param size       voxels along each axis
/// @param bytesEach  1: uint8, 2: int16, 4: float; x fastest, then y
/// @param result     processor seconds, seconds by the clock, triangles, vertices
using FlyingEdgesTime = void (*)(
    const int* size,
    int bytesEach,
    const void* voxels,
    double isovalue,
    int threads,
    double* result);

/// `isofrontFlyingEdgesMesh`: the mesh, with normals, on one thread.
/// @param values  x fastest, then y; not changed
using FlyingEdgesMesh = void (*)(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue,
    PeerMesh& mesh);

/// `isofrontVtkVersion`.
using VtkVersion = const char* (*)();

} // namespace isofront::bench::peers

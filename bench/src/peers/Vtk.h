#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::bench::peers {

/// A mesh as this peer hands it over, in plain vectors: its file is compiled as C++17 and without
/// our warnings, because VTK 9.1's headers are no C++20.
struct VtkMesh {
    std::vector<double> positions;      ///< x, y, z of each vertex
    std::vector<float> normals;         ///< the same
    std::vector<std::uint32_t> indices; ///< three a triangle
};

/// vtkFlyingEdges3D with normals, on one thread.
/// @param values  x fastest, then y; not changed
VtkMesh flyingEdges(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue);

std::string vtkVersion();

} // namespace isofront::bench::peers

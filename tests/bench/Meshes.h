#pragma once

#include <isofront/surface/TriangleMesh.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace isofront::tests {

/// A sphere of triangles: an icosahedron, each triangle cut into four so many times, its vertices
/// on the sphere.
inline surface::TriangleMesh icosphere(const glm::dvec3& centre, double radius, int cuts)
{
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<glm::dvec3> at = {
        {-1, g, 0},
        {1, g, 0},
        {-1, -g, 0},
        {1, -g, 0},
        {0, -1, g},
        {0, 1, g},
        {0, -1, -g},
        {0, 1, -g},
        {g, 0, -1},
        {g, 0, 1},
        {-g, 0, -1},
        {-g, 0, 1}};
    std::vector<std::array<std::uint32_t, 3>> triangles = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int cut = 0; cut < cuts; ++cut) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [found, isNew] = middles.try_emplace(
                {std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(at.size()));
            if (isNew)
                at.push_back(glm::normalize(at[a]) + glm::normalize(at[b]));
            return found->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        triangles = finer;
    }
    surface::TriangleMesh mesh;
    for (const glm::dvec3& p : at) {
        const glm::dvec3 n = glm::normalize(p);
        mesh.positions.push_back(centre + radius * n);
        mesh.normals.emplace_back(n);
        mesh.bounds.include(mesh.positions.back());
    }
    for (const auto& t : triangles)
        mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
    return mesh;
}

/// A square of side 1 at a height, cut into two triangles for each of n^2 squares.
inline surface::TriangleMesh square(double height, std::uint32_t n)
{
    surface::TriangleMesh mesh;
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x) {
            mesh.positions.emplace_back(double(x) / n, double(y) / n, height);
            mesh.normals.emplace_back(0, 0, 1);
            mesh.bounds.include(mesh.positions.back());
        }
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = x + y * (n + 1);
            const std::uint32_t c = a + n + 1;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, c + 1, a, c + 1, c});
        }
    return mesh;
}

inline void append(surface::TriangleMesh& mesh, const surface::TriangleMesh& other)
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
    for (const std::uint32_t index : other.indices)
        mesh.indices.push_back(first + index);
}

} // namespace isofront::tests

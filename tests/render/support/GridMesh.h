#pragma once

#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/Delta.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace isofront::test {

/// A mesh whose vertices lie on the world grid, before it is cut into cells.
struct GridMesh {
    std::vector<hierarchy::GridPoint> points; ///< multiples of 2^kExponent grid units
    std::vector<glm::dvec3> normals;          ///< unit, in field space
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// All points are snapped to 2^kExponent grid units, that is 2^-15 of the domain's edge.
inline constexpr int kExponent = 31;

/// A closed sphere: a cube's faces, each of n x n squares, blown up.
/// @param centre, radius  [fraction of the domain's edge]
GridMesh sphere(const glm::dvec3& centre, double radius, int n);

/// An open sheet z = height(x, y) over the whole domain, all in fractions of its edge.
GridMesh sheet(int n, const std::function<double(double, double)>& height);

/// Cuts a mesh into cells, one for each block of a regular partition that has triangles. Corners
/// and exponents differ at random, so that neighbours name their shared vertices differently.
/// @param firstIndex  distinguishes the cells of several meshes (`CellId::index`)
std::vector<surface::ShownCell>
cut(const GridMesh& mesh, int blocks, std::uint32_t seed, std::uint8_t firstIndex = 0);

/// The delta that shows exactly these cells.
surface::Delta showing(std::vector<surface::ShownCell> cells, std::uint64_t version = 1);

} // namespace isofront::test

#pragma once

#include <isofront/extractor/CellMesh.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace isofront::tests {

using CellPosition = std::array<std::uint16_t, 3>;

inline std::set<CellPosition> positionsOf(const extractor::CellMesh& mesh)
{
    std::set<CellPosition> positions;
    for (const extractor::CellVertex& vertex : mesh.vertices)
        positions.insert(vertex.position);
    return positions;
}

/// How many triangles each edge of a cell's mesh has, by vertices.
inline std::map<std::pair<std::uint16_t, std::uint16_t>, int>
edgeUses(const extractor::CellMesh& mesh)
{
    std::map<std::pair<std::uint16_t, std::uint16_t>, int> uses;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k)
            ++uses[std::minmax(mesh.indices[i + k], mesh.indices[i + (k + 1) % 3])];
    return uses;
}

inline int mostTrianglesAtAnEdge(const extractor::CellMesh& mesh)
{
    int most = 0;
    for (const auto& [edge, count] : edgeUses(mesh))
        most = std::max(most, count);
    return most;
}

/// The edges of one triangle, by the positions of their ends.
inline std::multiset<std::pair<CellPosition, CellPosition>>
borderEdges(const extractor::CellMesh& mesh)
{
    std::multiset<std::pair<CellPosition, CellPosition>> edges;
    for (const auto& [edge, count] : edgeUses(mesh))
        if (count == 1)
            edges.insert(std::minmax(
                mesh.vertices[edge.first].position, mesh.vertices[edge.second].position));
    return edges;
}

inline long eulerNumber(const extractor::CellMesh& mesh)
{
    return static_cast<long>(mesh.vertices.size()) - static_cast<long>(edgeUses(mesh).size()) +
           static_cast<long>(mesh.triangleCount());
}

inline glm::dvec3 localPosition(const extractor::CellVertex& vertex)
{
    return {vertex.position[0], vertex.position[1], vertex.position[2]};
}

/// Distance of a point from a triangle, by the nearest of its inside, sides and corners.
inline double
distanceTo(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& p)
{
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const auto onInnerSide = [&](const glm::dvec3& from, const glm::dvec3& to) {
        return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
    };
    if (onInnerSide(a, b) && onInnerSide(b, c) && onInnerSide(c, a))
        return std::abs(glm::dot(p - a, glm::normalize(normal)));
    const auto toSegment = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 d = to - from;
        const double t = std::clamp(glm::dot(p - from, d) / glm::dot(d, d), 0.0, 1.0);
        return glm::distance(p, from + t * d);
    };
    return std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
}

/// Distance of a vertex, of another mesh of the same cell, from the mesh [cell units].
inline double distanceTo(const extractor::CellMesh& mesh, const extractor::CellVertex& vertex)
{
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        least = std::min(
            least,
            distanceTo(
                localPosition(mesh.vertices[mesh.indices[i]]),
                localPosition(mesh.vertices[mesh.indices[i + 1]]),
                localPosition(mesh.vertices[mesh.indices[i + 2]]),
                localPosition(vertex)));
    return least;
}

/// 4 sqrt(3) area over the sum of the squared sides: 1 for an equilateral triangle.
inline double shapeOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    return 2 * std::sqrt(3.0) * glm::length(glm::cross(b - a, c - a)) /
           (glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c));
}

} // namespace isofront::tests

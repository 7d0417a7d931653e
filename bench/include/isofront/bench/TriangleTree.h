#pragma once

#include <isofront/core/Box.h>
#include <isofront/surface/TriangleMesh.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <limits>
#include <vector>

namespace isofront::bench {

/// The nearest point of a triangle.
glm::dvec3 nearestOnTriangle(
    const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

/// Finds the nearest triangle of a mesh, and whether a segment meets one.
///
/// A tree of boxes, halved at the median of the longest axis. Cost: n log n to build, about log n a
/// query. Immutable; any thread. The mesh must outlive the tree.
class TriangleTree {
public:
    struct Nearest {
        double distance = std::numeric_limits<double>::infinity();
        glm::dvec3 point{0.0};
        std::uint32_t triangle = 0;
    };

    explicit TriangleTree(const surface::TriangleMesh& mesh);

    /// Of all triangles nearer than `reach`; an infinite distance if there are none.
    [[nodiscard]] Nearest
    nearest(const glm::dvec3& point, double reach = std::numeric_limits<double>::infinity()) const;

    /// True if a triangle meets the open segment, its first and last `margin` left out (a share of
    /// its length).
    [[nodiscard]] bool
    isBlocked(const glm::dvec3& from, const glm::dvec3& to, double margin = 0) const;

private:
    struct Node {
        core::Box box;
        std::uint32_t first = 0; ///< of its triangles in `_order`, or its second child
        std::uint32_t count = 0; ///< of its triangles; 0 for an inner node, its first child is next
    };

    void build(std::uint32_t first, std::uint32_t count, const std::vector<core::Box>& boxes);
    [[nodiscard]] const glm::dvec3& corner(std::uint32_t triangle, std::size_t i) const
    {
        return _mesh->positions[_mesh->indices[3 * std::size_t{triangle} + i]];
    }

    const surface::TriangleMesh* _mesh;
    std::vector<std::uint32_t> _order;
    std::vector<Node> _nodes;
};

} // namespace isofront::bench

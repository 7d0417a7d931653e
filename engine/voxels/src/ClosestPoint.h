#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>

namespace isofront::voxels {

/// The point of the triangle 0, u, v that is nearest to one; also of triangles that are lines or
/// points.
inline glm::dvec3 closestPoint(const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& point)
{
    const double uu = glm::dot(u, u);
    const double uv = glm::dot(u, v);
    const double vv = glm::dot(v, v);
    const double up = glm::dot(u, point);
    const double vp = glm::dot(v, point);
    const double gram = uu * vv - uv * uv;
    if (gram > 0) {
        const double second = (vv * up - uv * vp) / gram;
        const double third = (uu * vp - uv * up) / gram;
        if (second >= 0 && third >= 0 && second + third <= 1)
            return second * u + third * v;
    }
    // on its edges, then
    const auto onEdge = [&](const glm::dvec3& from, const glm::dvec3& along) {
        const double squared = glm::dot(along, along);
        const double share =
            squared > 0 ? std::clamp(glm::dot(point - from, along) / squared, 0.0, 1.0) : 0;
        return from + share * along;
    };
    glm::dvec3 nearest = onEdge(glm::dvec3(0), u);
    for (const glm::dvec3& other : {onEdge(glm::dvec3(0), v), onEdge(u, v - u)})
        if (glm::dot(other - point, other - point) < glm::dot(nearest - point, nearest - point))
            nearest = other;
    return nearest;
}

} // namespace isofront::voxels

#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <numbers>

namespace isofront::extractor {

/// A change of the mesh may turn a triangle by up to this cosine, about 78 degrees.
inline constexpr double kLeastCosine = 0.2;
/// No change makes a triangle of a lesser quality than this. Low, because border vertices stay as
/// close together as they are, and triangles at a coarse mesh's border get long.
inline constexpr double kLeastShape = 0.01;

/// The square of the distance of a point from a triangle.
double
squaredDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

/// The normal and the sides of a triangle, for comparisons without a root.
struct TriangleShape {
    TriangleShape(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
        : normal(glm::cross(b - a, c - a)), squaredNormal(glm::dot(normal, normal)),
          squaredSides(glm::dot(b - a, b - a) + glm::dot(c - b, c - b) + glm::dot(a - c, a - c))
    {
    }

    /// Whether the triangle faces within kLeastCosine of where another does; never if it has no
    /// area.
    [[nodiscard]] bool facesLike(const TriangleShape& other) const
    {
        const double cosine = glm::dot(normal, other.normal);
        return cosine > 0 &&
               cosine * cosine > kLeastCosine * kLeastCosine * squaredNormal * other.squaredNormal;
    }
    /// Whether the quality is at least so much: 4 sqrt(3) area over the sum of the squared sides,
    /// which is 1 for an equilateral triangle and 0 for one without area.
    [[nodiscard]] bool isAtLeast(double quality) const
    {
        const double share = quality / (2 * std::numbers::sqrt3);
        return squaredNormal >= share * share * squaredSides * squaredSides;
    }
    [[nodiscard]] bool isWorseThan(const TriangleShape& other) const
    {
        return squaredNormal * other.squaredSides * other.squaredSides <
               other.squaredNormal * squaredSides * squaredSides;
    }

    /// Quality, as above, squared and over a constant: for comparisons.
    [[nodiscard]] double squaredQuality() const
    {
        return squaredNormal / (squaredSides * squaredSides);
    }

    glm::dvec3 normal; ///< twice the area long
    double squaredNormal;
    double squaredSides;
};

} // namespace isofront::extractor

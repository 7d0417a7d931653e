#pragma once

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace isofront::core {

/// An affine map `p -> linear * p + translation`, in double.
struct Affine {
    glm::dmat3 linear{1.0};
    glm::dvec3 translation{0.0};

    [[nodiscard]] glm::dvec3 point(const glm::dvec3& p) const { return linear * p + translation; }
    [[nodiscard]] glm::dvec3 direction(const glm::dvec3& d) const { return linear * d; }
    /// The matrix that takes gradients, and so normals up to their length, along. Invertible only.
    [[nodiscard]] glm::dmat3 normalMatrix() const { return glm::transpose(glm::inverse(linear)); }
    [[nodiscard]] Affine inverse() const
    {
        const glm::dmat3 inverted = glm::inverse(linear);
        return {inverted, -(inverted * translation)};
    }
    /// True where the map mirrors space, so that triangles must be wound the other way.
    [[nodiscard]] bool mirrors() const { return glm::determinant(linear) < 0; }
    /// The most by which the map lengthens a vector, or a little more: exact where the columns are
    /// orthogonal (any spacing and any rotation), otherwise an upper bound.
    [[nodiscard]] double stretch() const
    {
        const glm::dmat3 gram = glm::transpose(linear) * linear;
        double most = 0;
        for (std::size_t row = 0; row < 3; ++row)
            most = std::max(
                most, std::abs(gram[row].x) + std::abs(gram[row].y) + std::abs(gram[row].z));
        return std::sqrt(most);
    }
};

} // namespace isofront::core

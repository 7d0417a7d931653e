#pragma once

#include "LatticeModel.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace isofront::voxels {

/// How a triangle is coloured: by the colours of its corners and by its texture.
class TrianglePaint {
public:
    TrianglePaint(const LatticeModel& model, std::uint32_t index, const LatticeTriangle& triangle)
        : _u(side(triangle, 1)), _v(side(triangle, 2)), _uu(glm::dot(_u, _u)),
          _uv(glm::dot(_u, _v)), _vv(glm::dot(_v, _v)), _gram(_uu * _vv - _uv * _uv)
    {
        const TriangleModel& triangles = model.model;
        if (!model.colours.empty())
            for (std::size_t corner = 0; corner < 3; ++corner)
                _colours[corner] = model.colours[triangles.triangles[index][corner]];
        if (triangles.textureOf.empty() || triangles.textureOf[index] == kNoTexture)
            return;
        _texture = &model.textures[triangles.textureOf[index]];
        for (std::size_t corner = 0; corner < 3; ++corner)
            _places[corner] = glm::dvec2(triangles.textureCorners[index][corner]);
        const glm::dvec2 s = _places[1] - _places[0];
        const glm::dvec2 t = _places[2] - _places[0];
        const double ratio = _gram > 0 ? std::abs(s.x * t.y - s.y * t.x) / std::sqrt(_gram) : 0;
        _pixelsPerArea = std::isfinite(ratio) ? ratio * _texture->pixels() : 0;
    }

    /// The colour of a piece; linear, weighted by opacity.
    /// @param offset  of its centroid from the first corner [voxels]
    [[nodiscard]] std::array<float, 4> at(const glm::dvec3& offset, double area) const
    {
        // barycentric coordinates of the centroid: colours are linear in a triangle
        const double du = glm::dot(offset, _u);
        const double dv = glm::dot(offset, _v);
        const double second = _gram > 0 ? std::clamp((_vv * du - _uv * dv) / _gram, 0.0, 1.0) : 0;
        const double third =
            _gram > 0 ? std::clamp((_uu * dv - _uv * du) / _gram, 0.0, 1.0 - second) : 0;
        const auto b = static_cast<float>(second);
        const auto c = static_cast<float>(third);
        const float a = 1 - b - c;
        std::array<float, 4> colour{};
        for (std::size_t i = 0; i < 4; ++i)
            colour[i] = a * _colours[0][i] + b * _colours[1][i] + c * _colours[2][i];
        if (_texture == nullptr)
            return colour;
        const glm::dvec2 place =
            (1 - second - third) * _places[0] + second * _places[1] + third * _places[2];
        const std::array<float, 4> pixel = _texture->at(place, area * _pixelsPerArea);
        for (std::size_t i = 0; i < 4; ++i)
            colour[i] *= pixel[i];
        return colour;
    }

private:
    /// From the first corner to another [voxels].
    static glm::dvec3 side(const LatticeTriangle& triangle, std::size_t to)
    {
        const auto along = [&](std::size_t axis) {
            return static_cast<double>(triangle[to][axis] - triangle[0][axis]) /
                   static_cast<double>(kSteps);
        };
        return {along(0), along(1), along(2)};
    }

    glm::dvec3 _u;
    glm::dvec3 _v;
    double _uu;
    double _uv;
    double _vv;
    double _gram;
    std::array<std::array<float, 4>, 3> _colours{{{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}}};
    const MipMap* _texture = nullptr;
    std::array<glm::dvec2, 3> _places{};
    double _pixelsPerArea = 0; ///< of the texture, in a voxel's face
};

} // namespace isofront::voxels

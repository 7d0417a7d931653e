#pragma once

#include "isofront/extractor/VolumeMesh.h"

#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace isofront::extractor {

inline constexpr std::uint16_t kNoVertex = std::numeric_limits<std::uint16_t>::max();

/// Keeps a crossing away from both ends of its lattice edge: closer, the snap would make triangles
/// without area where samples equal the isovalue.
inline constexpr double kCrossingClamp = 1.0 / 64.0;
inline double clampedCrossing(double t)
{
    return std::clamp(t, kCrossingClamp, 1.0 - kCrossingClamp);
}

/// A mesh vertex while its cell is being made.
struct RoughVertex {
    hierarchy::GridPoint position{};
    double radius = 0; ///< filter radius there, already scaled [field]
    double t = 0;      ///< where on its lattice edge, from the inside
    double height = 0; ///< how far it has been put above the surface [cell units]
    /// Samples of its lattice edge: inside, outside. The same twice for a lattice point.
    std::array<std::uint16_t, 2> ends{};
    FeatureMask feature = 0; ///< of the lattice edge or point that it lies on
    bool cap = false;
    bool wall = false; ///< a lattice point of a cap on the domain's wall

    /// Whether a neighbouring cell has this vertex, too.
    [[nodiscard]] bool isBorder() const { return feature != 0; }
    /// Whether it must stay. Around any other vertex the triangles close up: all hexahedra at its
    /// lattice edge are the cell's own, and only triangles between caps are ever left out.
    [[nodiscard]] bool isLocked() const { return isBorder() || cap; }
};

/// The mesh of a cell while it is being made. Part of the worker's scratch.
struct RoughMesh {
    std::vector<RoughVertex> vertices;
    std::vector<std::uint16_t> indices; ///< three a triangle

    /// Drops the vertices that no triangle uses, and puts the others in the order of first use.
    void compact();

private:
    std::vector<std::uint16_t> _renamed;
    std::vector<RoughVertex> _kept;
};

/// Points in field space and what the field says there, as structure of arrays. Part of the
/// worker's scratch: all columns are of one length, which never shrinks.
struct PointColumns {
    std::vector<double> x, y, z, radius, gx, gy, gz;
    std::vector<float> value;

    /// Makes room for so many points; what the columns hold is lost.
    void reserve(std::size_t count)
    {
        if (count <= x.size())
            return;
        for (auto* column : {&x, &y, &z, &radius, &gx, &gy, &gz})
            column->resize(count);
        value.resize(count);
    }
    void setPoint(std::size_t i, const glm::dvec3& p)
    {
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
    }
    [[nodiscard]] glm::dvec3 point(std::size_t i) const { return {x[i], y[i], z[i]}; }
    [[nodiscard]] glm::dvec3 gradient(std::size_t i) const { return {gx[i], gy[i], gz[i]}; }

    /// The first `count` points; with their radii, or unfiltered.
    [[nodiscard]] fields::SampleBatch batch(std::size_t count, bool filtered) const
    {
        const auto first = [count](const auto& column) { return std::span(column).first(count); };
        return {first(x), first(y), first(z), filtered ? first(radius) : std::span<const double>()};
    }
    [[nodiscard]] fields::GradientSpans gradients(std::size_t count)
    {
        return {std::span(gx).first(count), std::span(gy).first(count), std::span(gz).first(count)};
    }
    [[nodiscard]] std::span<float> values(std::size_t count)
    {
        return std::span(value).first(count);
    }
};

} // namespace isofront::extractor

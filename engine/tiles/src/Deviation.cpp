#include "Deviation.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace isofront::tiles {

namespace {

/// Crossings are kept 1/64 of an edge from its ends, and so from a wall.
constexpr double kWallShare = 1.0 / 32;

bool isAtWall(const core::Box& box, const glm::dvec3& point, double reach)
{
    const glm::dvec3 distance = glm::min(glm::abs(point - box.low), glm::abs(point - box.high));
    return std::min({distance.x, distance.y, distance.z}) <= reach;
}

} // namespace

double largestDeviation(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    double isovalue,
    const surface::TriangleMesh& mesh,
    std::span<const std::uint32_t> triangles,
    double step)
{
    const core::Affine fieldFromWorld = domain.worldFromField.inverse();
    const std::optional<core::Box> data = field.dataBox();
    std::array<std::vector<double>, 3> at;
    for (const std::uint32_t triangle : triangles) {
        const auto corner = [&](std::size_t k) {
            return mesh.positions[mesh.indices[3 * std::size_t{triangle} + k]];
        };
        const glm::dvec3 middle = fieldFromWorld.point((corner(0) + corner(1) + corner(2)) / 3.0);
        if (isAtWall(domain.fieldBox(), middle, kWallShare * step) ||
            (data && isAtWall(*data, middle, kWallShare * step)))
            continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
            at[axis].push_back(middle[axis]);
    }
    const std::size_t count = at[0].size();
    std::vector<float> values(count);
    std::vector<double> slopes(3 * count);
    const auto slopesAlong = [&](std::size_t axis) {
        return std::span(slopes).subspan(axis * count, count);
    };
    field.sampleWithGradient(
        {.x = at[0], .y = at[1], .z = at[2]},
        values,
        {slopesAlong(0), slopesAlong(1), slopesAlong(2)});

    const double most = step * domain.worldFromField.stretch();
    const glm::dmat3 worldSlope = domain.worldFromField.normalMatrix();
    double largest = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double slope = glm::length(
            worldSlope * glm::dvec3(slopes[i], slopes[count + i], slopes[2 * count + i]));
        const double off = std::abs(double{values[i]} - isovalue);
        // false for what isn't a number, too
        const bool isNear = off == 0 || off < most * slope;
        largest = std::max(largest, !isNear ? most : off == 0 ? 0.0 : off / slope);
    }
    return largest;
}

} // namespace isofront::tiles

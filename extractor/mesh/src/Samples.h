#pragma once

#include "CellGeometry.h"
#include "isofront/extractor/CellExtractor.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace isofront::extractor {

/// The field at the sample points of one cell. Lives in the worker's scratch and is reused.
struct Samples {
    const VolumeMesh* mesh = nullptr;                     ///< whose vertices are sampled
    std::array<std::array<std::int64_t, 3>, 4> corners{}; ///< of the cell [lattice units]
    std::vector<double> radius;      ///< filter radius, scaled by the filter strength [field]
    std::vector<float> value;        ///< cleaned field values
    std::vector<double> boxDistance; ///< to the border of the data, positive inside; may be empty
    std::vector<std::uint8_t> inside;
    std::uint32_t sanitised = 0;

    /// A lattice edge by its two samples: from the first to the second [sample units].
    [[nodiscard]] glm::dvec3 edge(const std::array<std::uint16_t, 2>& ends) const
    {
        return point(ends[1]) - point(ends[0]);
    }
    /// The point at a share of it [sample units].
    [[nodiscard]] glm::dvec3 along(const std::array<std::uint16_t, 2>& ends, double t) const
    {
        return point(ends[0]) + t * edge(ends);
    }
    /// The filter radius there. Only if there are radii.
    [[nodiscard]] double radiusAlong(const std::array<std::uint16_t, 2>& ends, double t) const
    {
        return radius[ends[0]] + t * (radius[ends[1]] - radius[ends[0]]);
    }
    /// A sample point in sample units, of which the lattice unit holds 12 n^3: exact.
    [[nodiscard]] glm::dvec3 point(std::uint16_t i) const
    {
        const auto units = exactPoint(mesh->weights[i]);
        return {
            static_cast<double>(units[0]),
            static_cast<double>(units[1]),
            static_cast<double>(units[2])};
    }
    /// The cell's corners as kernels take them.
    [[nodiscard]] std::array<std::array<double, 3>, 4> realCorners() const
    {
        std::array<std::array<double, 3>, 4> real{};
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis)
                real[k][axis] = static_cast<double>(corners[k][axis]);
        return real;
    }
    /// What a lattice edge, or a point given twice, is known by: the sum of its samples.
    [[nodiscard]] std::array<std::int64_t, 3> key(const std::array<std::uint16_t, 2>& ends) const
    {
        std::array<std::uint32_t, 4> sum = mesh->weights[ends[0]];
        for (std::size_t k = 0; k < 4; ++k)
            sum[k] += mesh->weights[ends[1]][k];
        return exactPoint(sum);
    }

    /// Samples the field at the points of a cell, cleans the values and decides which are inside.
    /// @param dataBox  of the field, if any of the points may be outside of it
    void take(
        const fields::Field& field,
        const hierarchy::Tetrahedron& cell,
        const CellGeometry& geometry,
        const hierarchy::Domain& domain,
        const std::optional<core::Box>& dataBox,
        const ExtractionSettings& settings);

private:
    [[nodiscard]] std::array<std::int64_t, 3>
    exactPoint(const std::array<std::uint32_t, 4>& weights) const
    {
        std::array<std::int64_t, 3> sum{};
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis)
                sum[axis] += std::int64_t{weights[k]} * corners[k][axis];
        return sum;
    }

    /// A block of sample points [field]: so many as stay in the nearest cache.
    static constexpr std::size_t kBlock = 1024;
    struct Columns {
        std::array<double, kBlock> x, y, z;
    };

    void placeRadii(
        const CellGeometry& geometry,
        const ExtractionSettings& settings,
        std::size_t begin,
        std::size_t count);

    Columns _points;
};

/// Makes values finite, in place: NaN becomes the lowest value, which is outside for every isovalue
/// above -FLT_MAX / 4; what exceeds FLT_MAX / 4 is clamped, so that no difference overflows.
/// @return how many values were changed
std::uint32_t sanitise(std::span<float> values);

} // namespace isofront::extractor

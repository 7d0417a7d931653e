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
    /// Positions in sample units, of which the lattice unit holds 12 n^3: exact integers in double.
    std::vector<double> px, py, pz;
    std::vector<double> x, y, z;     ///< the same points [field]
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
    [[nodiscard]] glm::dvec3 point(std::uint16_t i) const { return {px[i], py[i], pz[i]}; }

    /// Sets positions and radii of a cell's points.
    void place(
        const hierarchy::Tetrahedron& cell,
        const CellGeometry& geometry,
        const hierarchy::Domain& domain,
        const VolumeMesh& mesh,
        const ExtractionSettings& settings);

    /// Samples the field at them, cleans the values and decides which are inside.
    /// @param dataBox  of the field, if any of the points may be outside of it
    void take(
        const fields::Field& field,
        const std::optional<core::Box>& dataBox,
        const ExtractionSettings& settings);
};

/// Makes values finite, in place: NaN becomes the lowest value, which is outside for every isovalue
/// above -FLT_MAX / 4; what exceeds FLT_MAX / 4 is clamped, so that no difference overflows.
/// @return how many values were changed
std::uint32_t sanitise(std::span<float> values);

} // namespace isofront::extractor

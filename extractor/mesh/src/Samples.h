#pragma once

#include "CellGeometry.h"
#include "isofront/extractor/CellExtractor.h"

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

    /// Sets positions and radii of a cell's points.
    void place(
        const hierarchy::Tetrahedron& cell,
        const CellGeometry& geometry,
        const hierarchy::Domain& domain,
        const VolumeMesh& mesh,
        const ExtractionSettings& settings);

    /// Samples the field at them, cleans the values and decides which are inside.
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

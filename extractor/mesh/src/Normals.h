#pragma once

#include "RoughMesh.h"
#include "Samples.h"
#include "isofront/extractor/CellExtractor.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::extractor {

/// Outward unit normals of all vertices, from the field's gradient at the snapped positions and the
/// vertices' own radii: nothing of the cell enters, so both copies of a border vertex get the same
/// bits. On a cap at the border of the data, the normal is that of the nearest side.
///
/// Where the gradient vanishes or isn't finite, a border vertex gets the direction of its lattice
/// edge from the inside out, and any other the mean of its triangles' normals, weighted by area.
///
/// @param samples  that the vertices were found by
/// @param normals  receives one a vertex
void vertexNormals(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings,
    const Samples& samples,
    const RoughMesh& rough,
    PointColumns& points,
    std::vector<glm::dvec3>& normals);

/// The same into a cell's mesh, as they are stored.
/// @param codes  scratch
/// @param mesh   vertices of `rough`, already placed; receives the normals
void setNormals(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings,
    const Samples& samples,
    const RoughMesh& rough,
    PointColumns& points,
    std::vector<std::uint32_t>& codes,
    CellMesh& mesh);

/// The unit vector against a gradient; zero where the gradient vanishes or isn't finite.
glm::dvec3 outward(const glm::dvec3& gradient);

/// The field's words at all vertices.
void setAttributes(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& rough,
    PointColumns& points,
    CellMesh& mesh);

/// The gradient at each point by four samples at alternate corners of a cube about it, at the
/// point's own radius and with the field's step: two thirds of the cost of six samples, and an
/// error of first order in the step.
/// @param points  the first `count` are used; receives the gradients
void fourSampleGradients(
    const fields::Field& field, PointColumns& points, std::size_t count, bool filtered);

} // namespace isofront::extractor

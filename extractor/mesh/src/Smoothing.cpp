#include "Smoothing.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::extractor {

namespace {

/// Taubin's factors: of the pass that smooths, and of the one that takes the shrinking back.
constexpr double kForth = 0.5;
constexpr double kBack = -0.53;

void moveBy(double factor, const RoughMesh& mesh, VertexMoves& moves, SmoothingScratch& scratch)
{
    const std::size_t count = moves.size();
    scratch.sum.assign(count, glm::dvec3(0.0));
    scratch.neighbours.assign(count, 0);
    // triangles close up around a free vertex, so each neighbour comes after it in just one of them
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint16_t vertex = mesh.indices[i + k];
            scratch.sum[vertex] += moves[mesh.indices[i + (k + 1) % 3]];
            ++scratch.neighbours[vertex];
        }
    for (std::size_t i = 0; i < count; ++i)
        if (moves.isFree(i))
            moves[i] += factor * (scratch.sum[i] / double(scratch.neighbours[i]) - moves[i]);
}

} // namespace

void smooth(const RoughMesh& mesh, int iterations, VertexMoves& moves, SmoothingScratch& scratch)
{
    for (int i = 0; i < iterations; ++i) {
        moveBy(kForth, mesh, moves, scratch);
        moveBy(kBack, mesh, moves, scratch);
    }
}

void reproject(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& mesh,
    const CellFrame& frame,
    double axisStep,
    VertexMoves& moves,
    PointColumns& points)
{
    const double unit = std::ldexp(domain.gridUnit(), frame.exponent); // [field]
    const glm::dvec3 corner = domain.fieldFromGrid(frame.corner);
    const std::size_t count = moves.size();
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        points.setPoint(i, corner + unit * moves[i]);
        points.radius[i] = mesh.vertices[i].radius;
    }
    field.sampleWithGradient(
        points.batch(count, settings.filterStrength > 0),
        points.values(count),
        points.gradients(count));
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 gradient = points.gradient(i);
        const double residual = double(points.value[i]) - settings.isovalue;
        const double slope = glm::length(gradient);
        const double distance = -residual / slope;
        if (!moves.isFree(i) || !(slope > 0) || !std::isfinite(slope) || !std::isfinite(distance))
            continue;
        const double limited = std::clamp(distance, -0.5 * axisStep, 0.5 * axisStep);
        moves[i] += limited / unit * (gradient / slope);
    }
}

} // namespace isofront::extractor

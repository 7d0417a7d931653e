#include "ErrorEstimate.h"

#include "Samples.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::extractor {

void estimateError(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& rough,
    PointColumns& points,
    CellMesh& mesh)
{
    constexpr std::size_t kMost = 128;
    const std::size_t triangles = rough.indices.size() / 3;
    const std::size_t stride = (triangles + kMost - 1) / kMost;
    points.reserve(kMost);
    std::size_t count = 0;
    for (std::size_t t = 0; t < triangles; t += stride) {
        glm::dvec3 centre(0.0);
        bool cap = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const RoughVertex& vertex = rough.vertices[rough.indices[3 * t + k]];
            centre += domain.fieldFromGrid(vertex.position) / 3.0;
            cap = cap && vertex.cap;
        }
        if (!cap)
            points.setPoint(count++, centre);
    }
    if (count == 0)
        return;
    field.sampleWithGradient(
        points.batch(count, false), points.values(count), points.gradients(count));
    sanitise(points.values(count));
    double sum = 0;
    double most = 0;
    const double cellSize =
        std::ldexp(domain.gridUnit(), mesh.exponent + 14) / settings.latticeSize;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 gradient(points.gx[i], points.gy[i], points.gz[i]);
        const double slope = std::sqrt(glm::dot(gradient, gradient));
        const double residual = std::abs(double(points.value[i]) - settings.isovalue);
        // a Newton step beyond a lattice edge says only that the surface is about that far
        double error = slope > 0 ? residual / slope : cellSize;
        error = std::isfinite(error) ? std::min(error, cellSize) : cellSize;
        sum += error * error;
        most = std::max(most, error);
    }
    mesh.stats.errorRms = static_cast<float>(std::sqrt(sum / static_cast<double>(count)));
    mesh.stats.errorMax = static_cast<float>(most);
}

} // namespace isofront::extractor

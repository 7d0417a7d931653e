#include "VertexBalance.h"

#include "Normals.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace isofront::extractor {

namespace {

/// Mean squared length of the mesh's edges at a border vertex, by the area of a face of the
/// tetrahedron, or the squared length of its edge, over 4 n^2. Measured on spheres; it is within 6
/// % the same for all shapes of cells and lattice sizes.
constexpr double kByFaceArea = 1.45;
constexpr double kByEdgeLength = 0.76;

/// That length for the vertices of each feature of a cell [lattice units], 0 for the interior.
std::array<double, 16>
squaredLengths(const hierarchy::Tetrahedron& cell, const CellGeometry& geometry, int latticeSize)
{
    std::array<double, 16> result{};
    const double segments = 4.0 * latticeSize * latticeSize;
    for (unsigned feature = 1; feature < 15; ++feature) {
        // in the order that all cells around the feature share
        std::array<glm::dvec3, 3> corner{};
        std::size_t count = 0;
        for (const std::size_t k : geometry.sorted)
            if ((feature >> k & 1U) == 0)
                corner[count++] = {
                    double(cell.corner[k].x), double(cell.corner[k].y), double(cell.corner[k].z)};
        if (count == 1)
            continue; // no lattice edge lies in a corner
        const glm::dvec3 side = corner[1] - corner[0];
        result[feature] = count == 2
                              ? kByEdgeLength * glm::dot(side, side) / segments
                              : kByFaceArea * 0.5 *
                                    glm::length(glm::cross(side, corner[2] - corner[0])) / segments;
    }
    return result;
}

/// Two unit vectors at right angles to a unit vector and to each other.
std::array<glm::dvec3, 2> tangents(const glm::dvec3& normal)
{
    const glm::dvec3 size = glm::abs(normal);
    const glm::dvec3 axis = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                            : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                 : glm::dvec3(0, 0, 1);
    const glm::dvec3 first = glm::normalize(glm::cross(normal, axis));
    return {first, glm::cross(normal, first)};
}

} // namespace

void balanceBorders(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const hierarchy::Tetrahedron& cell,
    const CellGeometry& geometry,
    const VolumeMesh& volumeMesh,
    const Samples& samples,
    RoughMesh& mesh,
    PointColumns& points,
    BalanceScratch& scratch)
{
    scratch.chosen.clear();
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (mesh.vertices[i].isBorder() && !mesh.vertices[i].cap)
            scratch.chosen.push_back(static_cast<std::uint16_t>(i));
    const std::size_t count = scratch.chosen.size();
    const bool filtered = settings.filterStrength > 0;
    const double sampleUnit = domain.latticeUnit() / volumeMesh.denominator();    // [field]
    const double cellUnit = std::ldexp(domain.gridUnit(), geometry.cellExponent); // [field]
    const auto squaredLength = squaredLengths(cell, geometry, settings.latticeSize);
    points.reserve(4 * count);

    for (std::size_t i = 0; i < count; ++i) {
        const RoughVertex& vertex = mesh.vertices[scratch.chosen[i]];
        points.setPoint(i, domain.fieldFromGrid(vertex.position));
        points.radius[i] = vertex.radius;
    }
    field.gradient(points.batch(count, filtered), points.gradients(count));
    scratch.normal.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        scratch.normal[i] = outward(points.gradient(i));

    const auto edgeOf = [&](const RoughVertex& vertex) { return samples.edge(vertex.ends); };
    for (std::size_t i = 0; i < count; ++i) {
        const RoughVertex& vertex = mesh.vertices[scratch.chosen[i]];
        const glm::dvec3 p = domain.fieldFromGrid(vertex.position);
        const double reach = 0.5 * sampleUnit * glm::length(edgeOf(vertex));
        const auto tangent = tangents(scratch.normal[i]);
        for (std::size_t k = 0; k < 4; ++k) {
            points.setPoint(4 * i + k, p + (k % 2 == 0 ? reach : -reach) * tangent[k / 2]);
            points.radius[4 * i + k] = vertex.radius;
        }
    }
    field.gradient(points.batch(4 * count, filtered), points.gradients(4 * count));

    for (std::size_t i = 0; i < count; ++i) {
        RoughVertex& vertex = mesh.vertices[scratch.chosen[i]];
        const glm::dvec3& normal = scratch.normal[i];
        const glm::dvec3 edge = edgeOf(vertex);
        const double length = sampleUnit * glm::length(edge);
        const auto tangent = tangents(normal);
        double turn = 0; // of the normal, along both tangents, over one lattice edge
        bool known = normal != glm::dvec3(0.0);
        for (std::size_t k = 0; k < 2; ++k) {
            const glm::dvec3 ahead = outward(points.gradient(4 * i + 2 * k));
            const glm::dvec3 behind = outward(points.gradient(4 * i + 2 * k + 1));
            known = known && ahead != glm::dvec3(0.0) && behind != glm::dvec3(0.0);
            turn += glm::dot(ahead - behind, tangent[k]);
        }
        if (!known)
            continue;
        const double squared =
            squaredLength[vertex.feature] * domain.latticeUnit() * domain.latticeUnit();
        // where the surface turns faster than the mesh can follow, curvature means nothing
        const double most = 1 / std::sqrt(squared);
        const double curvature = std::clamp(0.5 * turn / length, -most, most);
        const double height = curvature * squared / 8;
        const double along = glm::dot(edge, normal) * sampleUnit / length;
        // an edge that the surface grazes gets there only by a long way: go a part of it
        const double slide = height * along / std::max(along * along, 0.1) / length;
        const double before = vertex.t;
        vertex.t = clampedCrossing(before + std::clamp(slide, -0.25, 0.25));
        vertex.height = (vertex.t - before) * along * length / cellUnit;
        vertex.position = geometry.snapped(
            samples.along(vertex.ends, vertex.t), vertex.feature, volumeMesh.denominator());
        if (filtered)
            vertex.radius = samples.radiusAlong(vertex.ends, vertex.t);
    }
}

void balanceInside(
    const RoughMesh& mesh,
    const std::vector<glm::dvec3>& normals,
    double axisStep,
    VertexMoves& moves,
    BalanceScratch& scratch)
{
    const std::size_t count = moves.size();
    scratch.height.resize(count);
    scratch.target.assign(count, 0.0);
    scratch.diagonal.assign(count, 0.0);
    for (std::size_t i = 0; i < count; ++i)
        scratch.height[i] = moves.isFree(i) ? 0.0 : mesh.vertices[i].height;

    // On a triangle the surface is lower than its corners' plane by half the sum over its sides of
    // l_i l_j k_ij: l are barycentric coordinates and k is how much the normal turns along a side,
    // times its length. Projected to the corners' hat functions, that is the right-hand side.
    const auto forEachTriangle = [&](auto&& function) {
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const std::array<std::uint16_t, 3> v{
                mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
            const double area =
                0.5 * glm::length(glm::cross(moves[v[1]] - moves[v[0]], moves[v[2]] - moves[v[0]]));
            function(v, area);
        }
    };
    forEachTriangle([&](const std::array<std::uint16_t, 3>& v, double area) {
        std::array<double, 3> turn{}; // along the side opposite to a corner
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint16_t a = v[(k + 1) % 3];
            const std::uint16_t b = v[(k + 2) % 3];
            if (!mesh.vertices[a].cap && !mesh.vertices[b].cap)
                turn[k] = glm::dot(normals[b] - normals[a], moves[b] - moves[a]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            scratch.target[v[k]] +=
                area / 120 * (2 * turn[(k + 1) % 3] + 2 * turn[(k + 2) % 3] + turn[k]);
            scratch.diagonal[v[k]] += area / 6;
        }
    });
    // the matrix is that of hat functions' products, which Jacobi's method divides the error of by
    // more than 1.6 in a step
    constexpr int kSteps = 10;
    constexpr double kRelaxation = 0.8;
    for (int step = 0; step < kSteps; ++step) {
        scratch.rest = scratch.target;
        forEachTriangle([&](const std::array<std::uint16_t, 3>& v, double area) {
            const double sum = scratch.height[v[0]] + scratch.height[v[1]] + scratch.height[v[2]];
            for (const std::uint16_t k : v)
                scratch.rest[k] -= area / 12 * (sum + scratch.height[k]);
        });
        for (std::size_t i = 0; i < count; ++i)
            if (moves.isFree(i) && scratch.diagonal[i] > 0)
                scratch.height[i] += kRelaxation * scratch.rest[i] / scratch.diagonal[i];
    }
    for (std::size_t i = 0; i < count; ++i)
        if (moves.isFree(i))
            moves[i] +=
                std::clamp(scratch.height[i], -0.25 * axisStep, 0.25 * axisStep) * normals[i];
}

} // namespace isofront::extractor

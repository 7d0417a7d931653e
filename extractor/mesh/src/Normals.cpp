// Based on: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
// of detail and applications", section 3.2. Differs: analytic gradients where a field has them, and
// four samples are told to be of first order, not an equal alternative.

#include "Normals.h"

#include "NormalKernel.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isofront::extractor {

namespace {

void placeVertices(const hierarchy::Domain& domain, const RoughMesh& rough, PointColumns& points)
{
    const std::size_t count = rough.vertices.size();
    points.reserve(count);
    const double unit = domain.gridUnit();
    for (std::size_t i = 0; i < count; ++i) {
        points.setPoint(i, domain.origin + unit * glm::dvec3(rough.vertices[i].position));
        points.radius[i] = rough.vertices[i].radius;
    }
}

/// The side of the data's box that is nearest to a point faces outward there.
glm::dvec3 sideNormal(const core::Box& box, const glm::dvec3& p)
{
    const glm::dvec3 below = p - box.low;
    const glm::dvec3 above = box.high - p;
    glm::dvec3 normal(0.0);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double distance : {below[axis], above[axis]})
            if (distance < least) {
                least = distance;
                normal = glm::dvec3(0.0);
                normal[axis] = distance == below[axis] ? -1.0 : 1.0;
            }
    return normal;
}

/// The mean normal of the triangles around a vertex, weighted by their areas; zero if they cancel.
glm::dvec3 faceNormal(const RoughMesh& rough, std::size_t vertex)
{
    const auto& indices = rough.indices;
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < indices.size(); i += 3) {
        if (indices[i] != vertex && indices[i + 1] != vertex && indices[i + 2] != vertex)
            continue;
        const hierarchy::GridPoint a = rough.vertices[indices[i]].position;
        const glm::dvec3 ab(rough.vertices[indices[i + 1]].position - a);
        const glm::dvec3 ac(rough.vertices[indices[i + 2]].position - a);
        sum += glm::cross(ab, ac);
    }
    return outward(-sum);
}

bool isOnCap(const RoughVertex& vertex, const ExtractionSettings& settings)
{
    return vertex.wall || (vertex.cap && settings.closed);
}

/// The normal on a cap, and where the field's gradient says nothing.
glm::dvec3 specialNormal(
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings,
    const Samples& samples,
    const RoughMesh& rough,
    std::size_t i,
    const glm::dvec3& point)
{
    const RoughVertex& vertex = rough.vertices[i];
    if (vertex.wall) {
        // outward from all walls that meet here, whichever of them is being capped
        const glm::dvec3 p = samples.point(vertex.ends[0]);
        const double far = double(hierarchy::kLatticeEdge) * samples.mesh->denominator();
        glm::dvec3 sum(0.0);
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[axis] = p[axis] == 0 ? -1.0 : p[axis] == far ? 1.0 : 0.0;
        return glm::normalize(sum);
    }
    glm::dvec3 normal(0.0); // as long as nothing is known
    if (vertex.cap && settings.closed)
        normal = sideNormal(*dataBox, point);
    else if (!vertex.isBorder())
        normal = faceNormal(rough, i);
    return normal == glm::dvec3(0.0) ? glm::normalize(samples.edge(vertex.ends)) : normal;
}

/// The field's gradients at points that have been placed.
void takeGradients(
    const fields::Field& field,
    const ExtractionSettings& settings,
    std::size_t count,
    PointColumns& points)
{
    const bool filtered = settings.filterStrength > 0;
    switch (settings.normals) {
    case NormalSource::analytic:
        field.gradient(points.batch(count, filtered), points.gradients(count));
        break;
    case NormalSource::sixSamples: // what a field does that has nothing better
        field.Field::gradient(points.batch(count, filtered), points.gradients(count));
        break;
    case NormalSource::fourSamples:
        fourSampleGradients(field, points, count, filtered);
        break;
    }
}

} // namespace

glm::dvec3 outward(const glm::dvec3& gradient)
{
    // scaled first: the square of a small gradient must not vanish, nor that of a large one
    // overflow
    const double largest =
        std::max({std::abs(gradient.x), std::abs(gradient.y), std::abs(gradient.z)});
    const double sum = gradient.x + gradient.y + gradient.z; // NaN passes through, unlike above
    if (!(largest > 0) || !std::isfinite(largest) || std::isnan(sum))
        return glm::dvec3(0.0);
    return glm::normalize(-gradient / largest);
}

void fourSampleGradients(
    const fields::Field& field, PointColumns& points, std::size_t count, bool filtered)
{
    static constexpr std::array<std::array<double, 3>, 4> kCorners{
        {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
    // a block of points at a time, so that what is sampled stays in cache
    constexpr std::size_t kBlock = 256;
    std::array<double, 4 * kBlock> x;
    std::array<double, 4 * kBlock> y;
    std::array<double, 4 * kBlock> z;
    std::array<double, 4 * kBlock> radius;
    std::array<float, 4 * kBlock> value;
    std::array<double, kBlock> step;
    for (std::size_t begin = 0; begin < count; begin += kBlock) {
        const std::size_t block = std::min(kBlock, count - begin);
        for (std::size_t i = 0; i < block; ++i) {
            const double r = filtered ? points.radius[begin + i] : 0.0;
            step[i] = field.differenceStep(r);
            for (std::size_t k = 0; k < 4; ++k) {
                x[4 * i + k] = points.x[begin + i] + kCorners[k][0] * step[i];
                y[4 * i + k] = points.y[begin + i] + kCorners[k][1] * step[i];
                z[4 * i + k] = points.z[begin + i] + kCorners[k][2] * step[i];
                radius[4 * i + k] = r;
            }
        }
        const std::size_t samples = 4 * block;
        field.sample(
            {std::span(x).first(samples),
             std::span(y).first(samples),
             std::span(z).first(samples),
             std::span(radius).first(samples)},
            std::span(value).first(samples));
        for (std::size_t i = 0; i < block; ++i) {
            glm::dvec3 sum(0.0);
            for (std::size_t k = 0; k < 4; ++k)
                sum += double(value[4 * i + k]) *
                       glm::dvec3(kCorners[k][0], kCorners[k][1], kCorners[k][2]);
            const glm::dvec3 gradient = sum / (4 * step[i]);
            points.gx[begin + i] = gradient.x;
            points.gy[begin + i] = gradient.y;
            points.gz[begin + i] = gradient.z;
        }
    }
}

void vertexNormals(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings,
    const Samples& samples,
    const RoughMesh& rough,
    PointColumns& points,
    std::vector<glm::dvec3>& normals)
{
    placeVertices(domain, rough, points);
    takeGradients(field, settings, rough.vertices.size(), points);
    normals.resize(rough.vertices.size());
    for (std::size_t i = 0; i < normals.size(); ++i) {
        normals[i] = outward(points.gradient(i));
        if (normals[i] == glm::dvec3(0.0) || isOnCap(rough.vertices[i], settings))
            normals[i] = specialNormal(dataBox, settings, samples, rough, i, points.point(i));
    }
}

void setNormals(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const std::optional<core::Box>& dataBox,
    const ExtractionSettings& settings,
    const Samples& samples,
    const RoughMesh& rough,
    PointColumns& points,
    std::vector<std::uint32_t>& codes,
    CellMesh& mesh)
{
    const std::size_t count = rough.vertices.size();
    placeVertices(domain, rough, points);
    takeGradients(field, settings, count, points);
    codes.resize(count);
    encodeNormals({points.gx.data(), points.gy.data(), points.gz.data()}, count, codes.data());
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t code = codes[i];
        if (code == kNoNormalCode || isOnCap(rough.vertices[i], settings))
            mesh.vertices[i].normal =
                octahedral(specialNormal(dataBox, settings, samples, rough, i, points.point(i)));
        else
            mesh.vertices[i].normal = {
                static_cast<std::int16_t>(code & 0xFFFFU), static_cast<std::int16_t>(code >> 16U)};
    }
}

void setAttributes(
    const fields::Field& field,
    const hierarchy::Domain& domain,
    const ExtractionSettings& settings,
    const RoughMesh& rough,
    PointColumns& points,
    CellMesh& mesh)
{
    placeVertices(domain, rough, points);
    mesh.attributes.resize(rough.vertices.size());
    field.attributes(
        points.batch(rough.vertices.size(), settings.filterStrength > 0), mesh.attributes);
}

} // namespace isofront::extractor

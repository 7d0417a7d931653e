#include "Contour.h"

#include "isofront/extractor/MarchingCubesTable.h"

#include <isofront/core/Assert.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace isofront::extractor {

Contour::Contour(
    const CellGeometry& geometry,
    const VolumeMesh& volumeMesh,
    const ExtractionSettings& settings,
    const Samples& samples,
    ContourScratch& scratch,
    RoughMesh& mesh)
    : _geometry(geometry), _volumeMesh(volumeMesh), _settings(settings), _samples(samples),
      _scratch(scratch), _mesh(mesh), _leavesData(!samples.boxDistance.empty())
{
    _mesh.vertices.clear();
    _mesh.indices.clear();
    _scratch.vertexOfEdge.assign(volumeMesh.edges.size(), kNoVertex);
}

void Contour::run(const hierarchy::Tetrahedron& cell, bool closeWalls)
{
    march();
    if (closeWalls)
        capWalls(cell);
    // `march` makes vertices as it needs them; only dropped caps and walls disturb their order
    if (closeWalls || _leavesData)
        _mesh.compact();
}

void Contour::march()
{
    const MarchingCubesTable& table = MarchingCubesTable::instance();
    const std::uint8_t* inside = _samples.inside.data();
    // the second and third corner change places in a mirrored cell
    const std::size_t second = _geometry.mirrored ? 2 : 1;
    for (const Hexahedron& hexahedron : _volumeMesh.hexahedra) {
        unsigned configuration = 0;
        for (unsigned m = 0; m < 8; ++m)
            configuration |= static_cast<unsigned>(inside[hexahedron.vertex[m]]) << m;
        if (configuration == 0 || configuration == 255)
            continue;
        const MarchingCubesTable::Case& entry = table[static_cast<std::uint8_t>(configuration)];
        for (std::size_t i = 0; i < entry.triangles; ++i) {
            const std::uint16_t a = crossingOf(hexahedron.edge[entry.edge[i][0]]);
            const std::uint16_t b = crossingOf(hexahedron.edge[entry.edge[i][second]]);
            const std::uint16_t c = crossingOf(hexahedron.edge[entry.edge[i][3 - second]]);
            emit(a, b, c);
        }
    }
}

/// Closes the surface on those faces of the cell that lie on the domain's walls.
void Contour::capWalls(const hierarchy::Tetrahedron& cell)
{
    _scratch.vertexOfPoint.assign(_volumeMesh.vertexCount(), kNoVertex);
    for (std::size_t apex = 0; apex < 4; ++apex)
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const std::uint32_t wall : {0U, hierarchy::kLatticeEdge}) {
                bool onWall = true;
                for (std::size_t k = 0; k < 4; ++k)
                    onWall = onWall && (k == apex || cell.corner[k][axis] == wall);
                if (!onWall)
                    continue;
                for (const BoundaryQuad& quad : _volumeMesh.boundary[apex])
                    capQuad(quad);
            }
}

/// Marching squares on one side of a hexahedron, with the rule that the table has for sides: an
/// ambiguous one separates its inside corners.
void Contour::capQuad(const BoundaryQuad& quad)
{
    const auto turned = [this](std::uint16_t a, std::uint16_t b, std::uint16_t c) {
        if (_geometry.mirrored)
            std::swap(b, c);
        emit(a, b, c);
    };
    std::array<bool, 4> in{};
    int count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        in[i] = _samples.inside[quad.vertex[i]] != 0;
        count += in[i] ? 1 : 0;
    }
    if (count == 0)
        return;
    if (count == 2 && in[0] == in[2]) {
        for (std::size_t i = 0; i < 4; ++i)
            if (in[i])
                turned(
                    crossingOf(quad.edge[(i + 3) % 4]),
                    wallPoint(quad.vertex[i]),
                    crossingOf(quad.edge[i]));
        return;
    }
    std::array<std::uint16_t, 6> polygon{};
    std::size_t sides = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (in[i])
            polygon[sides++] = wallPoint(quad.vertex[i]);
        if (in[i] != in[(i + 1) % 4])
            polygon[sides++] = crossingOf(quad.edge[i]);
    }
    for (std::size_t i = 2; i < sides; ++i)
        turned(polygon[0], polygon[i - 1], polygon[i]);
}

std::uint16_t Contour::crossingOf(std::uint16_t edge)
{
    const std::uint16_t known = _scratch.vertexOfEdge[edge];
    return known != kNoVertex ? known : makeCrossing(edge);
}

/// The vertex where the surface cuts an edge of the lattice; the two ends are on different sides.
std::uint16_t Contour::makeCrossing(std::uint16_t edge)
{
    // from the inside end to the outside end: the same for every cell that has this edge
    const auto& ends = _volumeMesh.edges[edge];
    const std::size_t isSecondIn = 1U - _samples.inside[ends[0]];
    const std::uint16_t in = ends[isSecondIn];
    const std::uint16_t out = ends[1 - isSecondIn];
    const double fieldIn = double(_samples.value[in]) - _settings.isovalue;
    const double fieldOut = double(_samples.value[out]) - _settings.isovalue;
    double t = fieldOut < 0 ? fieldIn / (fieldIn - fieldOut) : 2.0;
    bool cap = false;
    if (_leavesData && _samples.boxDistance[out] < 0) {
        // solid ends at the border of the data or at the surface, whichever comes first
        const double boxIn = _samples.boxDistance[in];
        const double boxT = boxIn / (boxIn - _samples.boxDistance[out]);
        cap = boxT < t;
        t = std::min(t, boxT);
    }
    t = clampedCrossing(t);

    const glm::dvec3 a = samplePoint(in);
    const glm::dvec3 b = samplePoint(out);
    _scratch.vertexOfEdge[edge] = nextVertex();
    RoughVertex& vertex = _mesh.vertices.emplace_back();
    vertex.feature = _volumeMesh.edgeFeature[edge];
    vertex.position = _geometry.snapped(a + t * (b - a), vertex.feature, _volumeMesh.denominator());
    if (!_samples.radius.empty())
        vertex.radius = _samples.radiusAlong({in, out}, t);
    vertex.outward = b - a;
    vertex.ends = {in, out};
    vertex.t = t;
    for (std::size_t axis = 0; axis < 3; ++axis)
        vertex.key[axis] = static_cast<std::int64_t>(a[axis] + b[axis]);
    vertex.cap = cap;
    return _scratch.vertexOfEdge[edge];
}

/// A lattice point as a vertex of a cap on a wall.
std::uint16_t Contour::wallPoint(std::uint16_t point)
{
    std::uint16_t& known = _scratch.vertexOfPoint[point];
    if (known != kNoVertex)
        return known;
    known = nextVertex();
    RoughVertex& vertex = _mesh.vertices.emplace_back();
    const glm::dvec3 p = samplePoint(point);
    vertex.feature = _volumeMesh.vertexFeature[point];
    vertex.position = _geometry.snapped(p, vertex.feature, _volumeMesh.denominator());
    // outward from all walls that meet here, whichever of them is being capped
    const double far = double(hierarchy::kLatticeEdge) * _volumeMesh.denominator();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        vertex.outward[axis] = p[axis] == 0 ? -1.0 : p[axis] == far ? 1.0 : 0.0;
        vertex.key[axis] = 2 * static_cast<std::int64_t>(p[axis]);
    }
    vertex.cap = true;
    vertex.wall = true;
    return known;
}

std::uint16_t Contour::nextVertex() const
{
    ISOFRONT_ASSERT(_mesh.vertices.size() < kNoVertex, "16-bit indices suffice up to n = 16");
    return static_cast<std::uint16_t>(_mesh.vertices.size());
}

/// A triangle, as it is wound in the mesh.
void Contour::emit(std::uint16_t a, std::uint16_t b, std::uint16_t c)
{
    const auto& v = _mesh.vertices;
    if (!_settings.closed && v[a].cap && v[b].cap && v[c].cap)
        return;
    _mesh.indices.push_back(a);
    _mesh.indices.push_back(b);
    _mesh.indices.push_back(c);
}

/// The sample point in sample units.
glm::dvec3 Contour::samplePoint(std::uint16_t v) const
{
    return {_samples.px[v], _samples.py[v], _samples.pz[v]};
}

} // namespace isofront::extractor

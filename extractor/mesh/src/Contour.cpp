#include "Contour.h"

#include "isofront/extractor/MarchingCubesTable.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace isofront::extractor {

namespace {

/// The vertex where the surface cuts an edge of the lattice, numbered if it is new.
/// @param next  how many vertices there are
std::uint16_t crossingOf(
    std::uint16_t edge, std::uint16_t* vertexOfEdge, std::uint32_t* origins, std::uint32_t& next)
{
    // without a branch: whether an edge is new can't be foretold
    const std::uint16_t known = vertexOfEdge[edge];
    const bool isNew = known == kNoVertex;
    const auto number = isNew ? static_cast<std::uint16_t>(next) : known;
    vertexOfEdge[edge] = number;
    origins[next] = edge;
    next += isNew ? 1U : 0U;
    return number;
}

} // namespace

/// How the surface runs through a hexahedron, ready for use: its edges in the order in which the
/// triangles first use them, and the triangles by their places in that order.
struct Contour::Cut {
    std::array<std::uint8_t, 12> edge{};
    std::array<std::uint8_t, kMostCorners> corner{};
    std::uint8_t edges = 0;
    std::uint8_t corners = 0; ///< of all triangles
};

/// The same for each configuration, as triangles are wound in cells that are mirrored or not.
class Contour::Cuts {
public:
    static const Cuts& of(bool mirrored)
    {
        static const std::array<Cuts, 2> both{Cuts(false), Cuts(true)};
        return both[mirrored ? 1 : 0];
    }
    const Cut& operator[](std::uint8_t configuration) const { return _cuts[configuration]; }

private:
    explicit Cuts(bool mirrored)
    {
        // the second and third corner change places in a mirrored cell
        const std::array<std::size_t, 3> order{0, mirrored ? 2U : 1U, mirrored ? 1U : 2U};
        for (std::size_t configuration = 0; configuration < _cuts.size(); ++configuration) {
            const MarchingCubesTable::Case& entry =
                MarchingCubesTable::instance()[static_cast<std::uint8_t>(configuration)];
            Cut& cut = _cuts[configuration];
            cut.corners = static_cast<std::uint8_t>(3 * entry.triangles);
            for (std::size_t i = 0; i < cut.corners; ++i) {
                const std::uint8_t edge = entry.edge[i / 3][order[i % 3]];
                const std::uint8_t* const end = cut.edge.data() + cut.edges;
                const std::uint8_t* const known =
                    std::find<const std::uint8_t*>(cut.edge.data(), end, edge);
                cut.corner[i] = static_cast<std::uint8_t>(known - cut.edge.data());
                if (known == end)
                    cut.edge[cut.edges++] = edge;
            }
        }
    }

    std::array<Cut, 256> _cuts{};
};

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
    _scratch.originCount = 0;
    if (_scratch.vertexOfEdge.size() != volumeMesh.edges.size()) {
        _scratch.vertexOfEdge.assign(volumeMesh.edges.size(), kNoVertex);
        _scratch.vertexOfPoint.assign(volumeMesh.vertexCount(), kNoVertex);
        // one more, which is written to before it is known whether it is needed
        _scratch.origins.resize(volumeMesh.edges.size() + volumeMesh.vertexCount() + 1);
    }
}

void Contour::run(const hierarchy::Tetrahedron& cell, bool closeWalls)
{
    march();
    if (closeWalls)
        capWalls(cell);
    placeVertices();
    // vertices stand in the order of their first use; only dropped caps and walls disturb it
    if (_leavesData && !_settings.closed)
        dropCaps();
    if (closeWalls || _leavesData)
        _mesh.compact();
}

/// The triangles of all hexahedra, whose vertices get their numbers and nothing else.
void Contour::march()
{
    const Cuts& cuts = Cuts::of(_geometry.mirrored);
    const std::size_t perBlock = _volumeMesh.hexahedra.size() / _volumeMesh.block.size();
    _scratch.cut.resize(perBlock);
    std::uint16_t* const cut = _scratch.cut.data();
    for (std::size_t block = 0; block < _volumeMesh.block.size(); ++block) {
        const std::uint8_t* const configurations = configurationsOf(block);
        const Hexahedron* const hexahedra = _volumeMesh.hexahedra.data() + block * perBlock;
        // those that the surface cuts, picked without branches that nobody could foretell
        std::size_t count = 0;
        for (std::size_t i = 0; i < perBlock; ++i) {
            const unsigned configuration = configurations[hexahedra[i].place];
            cut[count] = static_cast<std::uint16_t>(i);
            count += ((configuration + 1) & 0xFEU) != 0 ? 1U : 0U;
        }

        const std::size_t before = _mesh.indices.size();
        _mesh.indices.resize(before + kMostCorners * count);
        std::uint16_t* const indices = _mesh.indices.data() + before;
        std::uint16_t* const vertexOfEdge = _scratch.vertexOfEdge.data();
        std::uint32_t* const origins = _scratch.origins.data();
        std::uint32_t next = _scratch.originCount;
        std::size_t made = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Hexahedron& hexahedron = hexahedra[cut[i]];
            const Cut& way = cuts[configurations[hexahedron.place]];
            std::array<std::uint16_t, 12> vertex;
            for (std::size_t k = 0; k < way.edges; ++k)
                vertex[k] = extractor::crossingOf(
                    hexahedron.edge[way.edge[k]], vertexOfEdge, origins, next);
            for (std::size_t k = 0; k < kMostCorners; ++k) // all of them: that is faster
                indices[made + k] = vertex[way.corner[k]];
            made += way.corners;
        }
        _mesh.indices.resize(before + made);
        _scratch.originCount = next;
    }
}

/// Which corners are inside, of all hexahedra of a block, by their places.
const std::uint8_t* Contour::configurationsOf(std::size_t block)
{
    const auto stride = static_cast<std::size_t>(_volumeMesh.latticeSize()) + 1;
    const std::size_t up = stride * stride;
    const std::array<std::size_t, 8> corner{
        0, 1, stride, stride + 1, up, up + 1, up + stride, up + stride + 1};
    // The last places along each axis, where no hexahedron is, get something too, and there are a
    // few more to fill whole registers.
    const std::size_t places = _volumeMesh.block[block].size();
    const std::size_t padded = (places + 63) / 64 * 64;
    _scratch.inside.resize(padded + corner[7]);
    _scratch.configurations.resize(padded);
    const std::uint16_t* const vertices = _volumeMesh.block[block].data();
    const std::uint8_t* const given = _samples.inside.data();
    std::uint8_t* const inside = _scratch.inside.data();
    std::uint8_t* const configurations = _scratch.configurations.data();
    for (std::size_t i = 0; i < places; ++i)
        inside[i] = given[vertices[i]];
    for (std::size_t i = 0; i < padded; ++i) {
        unsigned bits = 0;
        for (std::size_t m = 0; m < 8; ++m)
            bits |= unsigned{inside[i + corner[m]]} << m;
        configurations[i] = static_cast<std::uint8_t>(bits);
    }
    return configurations;
}

/// Closes the surface on those faces of the cell that lie on the domain's walls.
void Contour::capWalls(const hierarchy::Tetrahedron& cell)
{
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
        _mesh.indices.insert(_mesh.indices.end(), {a, b, c});
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

/// The vertex where the surface cuts an edge of the lattice.
std::uint16_t Contour::crossingOf(std::uint16_t edge)
{
    return extractor::crossingOf(
        edge, _scratch.vertexOfEdge.data(), _scratch.origins.data(), _scratch.originCount);
}

/// A lattice point as a vertex of a cap on a wall.
std::uint16_t Contour::wallPoint(std::uint16_t point)
{
    std::uint16_t& known = _scratch.vertexOfPoint[point];
    if (known == kNoVertex) {
        known = static_cast<std::uint16_t>(_scratch.originCount);
        _scratch.origins[_scratch.originCount++] = ContourScratch::kFirstPoint + point;
    }
    return known;
}

/// Makes the vertices that have been numbered, block after block, and forgets the numbers.
void Contour::placeVertices()
{
    std::array<double, 16> unitsPerSample{};
    for (std::size_t feature = 0; feature < unitsPerSample.size(); ++feature)
        unitsPerSample[feature] =
            _geometry.unitsPerLatticeUnit[feature] / _volumeMesh.denominator();
    const auto corners = _samples.realCorners();
    CrossingBlock& block = _scratch.crossings;
    ISOFRONT_ASSERT(_scratch.originCount < kNoVertex, "16-bit indices suffice up to n = 16");
    _mesh.vertices.resize(_scratch.originCount);
    for (std::size_t first = 0; first < _mesh.vertices.size(); first += CrossingBlock::kSize) {
        const std::size_t count = std::min(CrossingBlock::kSize, _mesh.vertices.size() - first);
        RoughVertex* const vertices = _mesh.vertices.data() + first;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t origin = _scratch.origins[first + i];
            RoughVertex& vertex = vertices[i];
            vertex = {};
            if (origin >= ContourScratch::kFirstPoint) {
                const auto point = static_cast<std::uint16_t>(origin - ContourScratch::kFirstPoint);
                _scratch.vertexOfPoint[point] = kNoVertex;
                vertex.ends = {point, point};
                vertex.feature = _volumeMesh.vertexFeature[point];
                vertex.cap = vertex.wall = true;
            } else {
                _scratch.vertexOfEdge[origin] = kNoVertex;
                // from the inside end to the outside end: the same for every cell with this edge
                const auto& ends = _volumeMesh.edges[origin];
                const std::size_t isSecondIn = 1U - _samples.inside[ends[0]];
                vertex.ends = {ends[isSecondIn], ends[1 - isSecondIn]};
                vertex.feature = _volumeMesh.edgeFeature[origin];
            }
            const auto fill = [&](CrossingBlock::End& end, std::uint16_t sample) {
                end.weights[i] = _volumeMesh.weights[sample];
                end.value[i] = _samples.value[sample];
            };
            fill(block.inside, vertex.ends[0]);
            fill(block.outside, vertex.ends[1]);
            block.unitsPerSample[i] = unitsPerSample[vertex.feature];
        }
        placeShares(block, count, _settings.isovalue);
        if (_leavesData)
            placeAtBorderOfData(first, count);
        placeCrossings(block, count, corners);
        for (std::size_t i = 0; i < count; ++i) {
            RoughVertex& vertex = vertices[i];
            for (std::size_t axis = 0; axis < 3; ++axis)
                vertex.position[axis] = static_cast<std::int64_t>(block.position[axis][i])
                                        << _geometry.snapExponent[vertex.feature];
            if (vertex.wall)
                continue;
            vertex.t = block.t[i];
            if (!_samples.radius.empty())
                vertex.radius = _samples.radiusAlong(vertex.ends, vertex.t);
        }
    }
}

/// Solid ends at the border of the data or at the surface, whichever comes first.
void Contour::placeAtBorderOfData(std::size_t first, std::size_t count)
{
    CrossingBlock& block = _scratch.crossings;
    for (std::size_t i = 0; i < count; ++i) {
        RoughVertex& vertex = _mesh.vertices[first + i];
        const double boxOut = _samples.boxDistance[vertex.ends[1]];
        if (vertex.wall || !(boxOut < 0))
            continue;
        const double in = double(block.inside.value[i]) - _settings.isovalue;
        const double out = double(block.outside.value[i]) - _settings.isovalue;
        const double t = out < 0 ? in / (in - out) : 2.0;
        const double boxIn = _samples.boxDistance[vertex.ends[0]];
        const double boxT = boxIn / (boxIn - boxOut);
        vertex.cap = boxT < t;
        block.t[i] = clampedCrossing(std::min(t, boxT));
    }
}

/// The surface ends where there is nothing but caps.
void Contour::dropCaps()
{
    const auto isCap = [&](std::uint16_t i) { return _mesh.vertices[i].cap; };
    std::vector<std::uint16_t>& indices = _mesh.indices;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < indices.size(); i += 3) {
        if (isCap(indices[i]) && isCap(indices[i + 1]) && isCap(indices[i + 2]))
            continue;
        std::copy_n(
            indices.begin() + static_cast<std::ptrdiff_t>(i),
            3,
            indices.begin() + static_cast<std::ptrdiff_t>(kept));
        kept += 3;
    }
    indices.resize(kept);
}

} // namespace isofront::extractor

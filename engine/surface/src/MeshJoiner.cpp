#include "MeshJoiner.h"

#include "VertexKernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace isofront::surface {

namespace {

constexpr std::uint32_t kNoNumber = std::numeric_limits<std::uint32_t>::max();

/// True for a feature that more than two cells may share: an edge or a corner of the tetrahedron.
bool isAroundEdge(extractor::FeatureMask feature)
{
    return std::popcount(feature) > 1;
}

} // namespace

BorderNumbers::BorderNumbers(int latticeSize, int finestLevel)
{
    // A key is the sum of two sample points, each a sum of corners with weights that add up to
    // 12 n^3; corners of cells of level L are multiples of 2^(30 - L / 3) lattice units.
    const auto n = static_cast<std::uint64_t>(latticeSize);
    _shift = static_cast<unsigned>(hierarchy::kLatticeBits - 1 - finestLevel / 3);
    const std::uint64_t largest = 24 * n * n * n
                                  << (static_cast<unsigned>(hierarchy::kLatticeBits) - _shift);
    _bits = static_cast<unsigned>(std::bit_width(largest));
    _isShort = 3 * _bits < 64;
}

std::uint32_t BorderNumbers::numberOf(const extractor::BorderVertex& border, std::uint32_t next)
{
    const auto look = [&](auto& numbers, const auto& key) {
        const auto [known, isNew] = numbers.tryEmplace(key, next);
        if (isNew)
            return next;
        const std::uint32_t number = *known;
        if (!isAroundEdge(border.feature))
            numbers.erase(key); // both cells of the face have been here
        return number;
    };
    if (!_isShort)
        return look(_long, border.key);
    return look(_short, shortKey(border.key));
}

void BorderNumbers::prepareFor(const extractor::BorderVertex& border) const
{
    if (_isShort)
        _short.prefetch(shortKey(border.key));
    else
        _long.prefetch(border.key);
}

std::uint64_t BorderNumbers::shortKey(const std::array<std::int64_t, 3>& key) const
{
    std::uint64_t packed = 0;
    for (const std::int64_t coordinate : key)
        packed = (packed << _bits) | (static_cast<std::uint64_t>(coordinate) >> _shift);
    return packed;
}

MeshJoiner::MeshJoiner(
    const hierarchy::Domain& domain, int latticeSize, int finestLevel, bool hasAttributes)
    : _domain(domain), _latticeSize(latticeSize),
      _normalMatrix(domain.worldFromField.normalMatrix()),
      _mirrors(domain.worldFromField.mirrors()), _hasAttributes(hasAttributes),
      _borders(latticeSize, finestLevel)
{
}

bool MeshJoiner::number(JoinedCell& cell)
{
    const std::size_t count = cell.mesh.vertices.size();
    if (std::size_t{_vertices} + count >= kNoNumber)
        return false;
    cell.firstNew = _vertices;
    cell.borderNumber.clear();
    for (const extractor::BorderVertex& border : cell.trace.borders)
        _borders.prepareFor(border);
    for (const extractor::BorderVertex& border : cell.trace.borders) {
        const std::uint32_t number = _borders.numberOf(border, _vertices);
        _vertices += number == _vertices ? 1U : 0U;
        cell.borderNumber.push_back(number);
    }
    cell.firstInterior = _vertices;
    _vertices += static_cast<std::uint32_t>(count - cell.trace.borders.size());
    cell.firstIndex = _indices;
    _indices += cell.mesh.indices.size();
    return true;
}

void MeshJoiner::reserve(TriangleMesh& mesh, std::size_t cells, std::size_t most) const
{
    // A plane through a cell makes at most 11 n^2 triangles, and half as many vertices.
    const auto n = static_cast<std::size_t>(_latticeSize);
    const std::size_t triangles = std::min(cells * 11 * n * n, most);
    mesh.positions.reserve(triangles / 2);
    mesh.normals.reserve(triangles / 2);
    if (_hasAttributes)
        mesh.attributes.reserve(triangles / 2);
    mesh.indices.reserve(3 * triangles);
}

bool MeshJoiner::fits(const TriangleMesh& mesh) const
{
    return _vertices <= mesh.positions.capacity() && _vertices <= mesh.normals.capacity() &&
           (!_hasAttributes || _vertices <= mesh.attributes.capacity()) &&
           _indices <= mesh.indices.capacity();
}

void MeshJoiner::setSizes(TriangleMesh& mesh) const
{
    mesh.positions.resize(_vertices);
    mesh.normals.resize(_vertices);
    if (_hasAttributes)
        mesh.attributes.resize(_vertices);
    mesh.indices.resize(_indices);
}

void MeshJoiner::write(const JoinedCell& cell, TriangleMesh& mesh, core::Box& bounds) const
{
    const extractor::CellMesh& part = cell.mesh;
    thread_local std::vector<std::uint32_t> global; // reused from cell to cell
    global.assign(part.vertices.size(), kNoNumber);
    for (std::size_t i = 0; i < cell.borderNumber.size(); ++i)
        global[cell.trace.borders[i].vertex] = cell.borderNumber[i];

    // The vertices that are new stand in two rows, one after the other: borders, in the order of
    // the cell's list of them, and all others.
    thread_local std::vector<std::uint16_t> made;
    made.clear();
    for (std::size_t i = 0; i < cell.borderNumber.size(); ++i)
        if (cell.borderNumber[i] >= cell.firstNew)
            made.push_back(cell.trace.borders[i].vertex);
    std::uint32_t interior = cell.firstInterior;
    for (std::size_t i = 0; i < global.size(); ++i)
        if (global[i] == kNoNumber) {
            global[i] = interior++;
            made.push_back(static_cast<std::uint16_t>(i));
        }
    thread_local VertexBlock block;
    glm::dvec3* const positions = mesh.positions.data();
    glm::vec3* const normals = mesh.normals.data();
    std::uint32_t* const attributes = mesh.attributes.data();
    const glm::dvec3 corner(hierarchy::gridFromLattice(part.low));
    const double unit = std::ldexp(1.0, part.exponent);
    for (std::size_t begin = 0; begin < made.size(); begin += VertexBlock::kSize) {
        const std::size_t count = std::min(VertexBlock::kSize, made.size() - begin);
        const std::size_t first = cell.firstNew + begin;
        for (std::size_t i = 0; i < count; ++i) {
            const extractor::CellVertex& vertex = part.vertices[made[begin + i]];
            for (std::size_t axis = 0; axis < 3; ++axis)
                block.grid[axis][i] = corner[axis] + unit * vertex.position[axis]; // exact
            block.normal[i] = static_cast<std::uint16_t>(vertex.normal[0]) |
                              std::uint32_t{static_cast<std::uint16_t>(vertex.normal[1])} << 16U;
            if (_hasAttributes)
                attributes[first + i] = part.attributes[made[begin + i]];
        }
        placeInWorld(block, count, _domain, _normalMatrix, positions + first, normals + first);
        for (std::size_t i = 0; i < count; ++i)
            bounds.include(positions[first + i]);
    }

    const std::size_t second = _mirrors ? 2 : 1;
    std::uint32_t* out = mesh.indices.data() + cell.firstIndex;
    for (std::size_t i = 0; i < part.indices.size(); i += 3, out += 3) {
        out[0] = global[part.indices[i]];
        out[1] = global[part.indices[i + second]];
        out[2] = global[part.indices[i + 3 - second]];
    }
}

} // namespace isofront::surface

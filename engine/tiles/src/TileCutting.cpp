#include "TileCutting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace isofront::tiles {

namespace {

/// A triangle in a tile: its number, and in the lowest bit whether it is rim.
struct Piece {
    std::uint64_t key;
    std::uint64_t triangle;
    auto operator<=>(const Piece&) const = default;
};

/// The cube that a coordinate lies in, of so many.
std::uint32_t cubeOf(double coordinate, double count)
{
    return static_cast<std::uint32_t>(std::clamp(std::floor(coordinate), 0.0, count - 1));
}

glm::u32vec3 cubeOf(const glm::dvec3& point, double count)
{
    return {cubeOf(point.x, count), cubeOf(point.y, count), cubeOf(point.z, count)};
}

/// Takes the mesh's positions to edges of tiles from the domain's low corner.
class TileSpace {
public:
    TileSpace(const hierarchy::Domain& domain, int depth)
        : _fieldFromWorld(domain.worldFromField.inverse()), _origin(domain.origin),
          _scale(std::ldexp(1 / domain.edge, depth)), _count(std::ldexp(1.0, depth))
    {
    }
    [[nodiscard]] glm::dvec3 point(const glm::dvec3& world) const
    {
        return (_fieldFromWorld.point(world) - _origin) * _scale;
    }
    [[nodiscard]] double count() const { return _count; }

private:
    core::Affine _fieldFromWorld;
    glm::dvec3 _origin;
    double _scale;
    double _count;
};

} // namespace

std::vector<TilePart> cutIntoTiles(
    const surface::TriangleMesh& mesh, const hierarchy::Domain& domain, int depth, double margin)
{
    const TileSpace space(domain, depth);
    const auto cornersOf = [&](std::size_t triangle) {
        std::array<glm::dvec3, 3> corners;
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = space.point(mesh.positions[mesh.indices[3 * triangle + k]]);
        return corners;
    };

    std::vector<Piece> pieces;
    const std::size_t count = mesh.indices.size() / 3;
    pieces.reserve(count + count / 8);
    for (std::size_t triangle = 0; triangle < count; ++triangle) {
        const auto [a, b, c] = cornersOf(triangle);
        const glm::dvec3 rim(margin);
        const glm::u32vec3 home = cubeOf((a + b + c) / 3.0, space.count());
        const glm::u32vec3 low = cubeOf(glm::min(glm::min(a, b), c) - rim, space.count());
        const glm::u32vec3 high = cubeOf(glm::max(glm::max(a, b), c) + rim, space.count());
        for (std::uint32_t x = low.x; x <= high.x; ++x)
            for (std::uint32_t y = low.y; y <= high.y; ++y)
                for (std::uint32_t z = low.z; z <= high.z; ++z) {
                    const TileId tile{depth, {x, y, z}};
                    pieces.push_back({tile.key(), 2 * triangle + (tile.at == home ? 0U : 1U)});
                }
    }
    std::ranges::sort(pieces);

    std::vector<TilePart> parts;
    for (const Piece& piece : pieces) {
        if (parts.empty() || parts.back().tile.key() != piece.key) {
            parts.emplace_back();
            parts.back().tile = TileId::ofKey(depth, piece.key);
        }
        TilePart& part = parts.back();
        const std::size_t triangle = piece.triangle / 2;
        (piece.triangle % 2 == 0 ? part.home : part.rim)
            .push_back(static_cast<std::uint32_t>(triangle));
        // in edges of the children
        auto [a, b, c] = cornersOf(triangle);
        for (glm::dvec3* corner : {&a, &b, &c})
            *corner = 2.0 * (*corner - glm::dvec3(part.tile.at));
        const glm::u32vec3 low = cubeOf(glm::min(glm::min(a, b), c), 2);
        const glm::u32vec3 high = cubeOf(glm::max(glm::max(a, b), c), 2);
        for (std::uint32_t x = low.x; x <= high.x; ++x)
            for (std::uint32_t y = low.y; y <= high.y; ++y)
                for (std::uint32_t z = low.z; z <= high.z; ++z)
                    part.octants =
                        static_cast<std::uint8_t>(part.octants | 1U << (x | y << 1U | z << 2U));
    }
    return parts;
}

surface::TriangleMesh
tileMesh(const surface::TriangleMesh& mesh, const TilePart& part, core::Box& bounds)
{
    surface::TriangleMesh tile;
    std::vector<std::uint32_t> vertices;
    vertices.reserve(3 * (part.home.size() + part.rim.size()));
    for (const auto* triangles : {&part.home, &part.rim})
        for (const std::uint32_t triangle : *triangles)
            for (std::size_t k = 0; k < 3; ++k)
                vertices.push_back(mesh.indices[3 * std::size_t{triangle} + k]);
    tile.indices.assign(vertices.begin(), vertices.end());
    std::ranges::sort(vertices);
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (std::uint32_t& index : tile.indices)
        index = static_cast<std::uint32_t>(
            std::ranges::lower_bound(vertices, index) - vertices.begin());

    tile.positions.reserve(vertices.size());
    tile.normals.reserve(vertices.size());
    for (const std::uint32_t vertex : vertices) {
        const glm::dvec3& position = mesh.positions[vertex];
        const glm::vec3& normal = mesh.normals[vertex];
        bounds.include(position);
        tile.positions.emplace_back(position.x, position.z, -position.y);
        tile.bounds.include(tile.positions.back());
        tile.normals.emplace_back(normal.x, normal.z, -normal.y);
    }
    return tile;
}

} // namespace isofront::tiles

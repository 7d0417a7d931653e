#include "GridMesh.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>

namespace isofront::test {

namespace {

using hierarchy::GridPoint;

std::int64_t snapped(double fraction)
{
    const double steps = std::ldexp(fraction, hierarchy::kGridBits - kExponent);
    return std::int64_t{std::llround(steps)} << kExponent;
}

GridPoint snapped(const glm::dvec3& fraction)
{
    return {snapped(fraction.x), snapped(fraction.y), snapped(fraction.z)};
}

struct Block {
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

surface::ShownCell
makeCell(const GridMesh& mesh, const Block& block, const surface::CellId& id, std::mt19937& random)
{
    GridPoint low = mesh.points[block.triangles.front()[0]];
    GridPoint high = low;
    for (const auto& triangle : block.triangles) {
        for (const std::uint32_t corner : triangle) {
            low = glm::min(low, mesh.points[corner]);
            high = glm::max(high, mesh.points[corner]);
        }
    }
    // Any corner below the vertices will do, as long as it is a multiple of the unit.
    std::uniform_int_distribution<std::int64_t> steps(0, 1000);
    for (std::size_t axis = 0; axis < 3; ++axis)
        low[axis] = std::max<std::int64_t>(0, low[axis] - (steps(random) << kExponent));
    const GridPoint extent = high - low;
    const std::int64_t most = std::max({extent.x, extent.y, extent.z});
    int least = kExponent;
    while (least > 1 && (most >> (least - 1)) <= 32768)
        --least;
    auto cellMesh = std::make_shared<extractor::CellMesh>();
    cellMesh->exponent =
        static_cast<std::uint8_t>(std::uniform_int_distribution<int>(least, kExponent)(random));
    const auto lattice = [](std::int64_t grid) {
        return static_cast<std::uint32_t>(grid >> hierarchy::kGridBitsPerLatticeUnit);
    };
    cellMesh->low = {lattice(low.x), lattice(low.y), lattice(low.z)};

    std::map<std::uint32_t, std::uint16_t> numbers;
    for (const auto& triangle : block.triangles) {
        for (const std::uint32_t corner : triangle) {
            const auto [entry, isNew] =
                numbers.emplace(corner, static_cast<std::uint16_t>(numbers.size()));
            if (isNew) {
                const GridPoint local =
                    (mesh.points[corner] - low) >> std::int64_t{cellMesh->exponent};
                cellMesh->vertices.push_back(
                    {.position =
                         {static_cast<std::uint16_t>(local.x),
                          static_cast<std::uint16_t>(local.y),
                          static_cast<std::uint16_t>(local.z)},
                     .normal = extractor::octahedral(mesh.normals[corner])});
            }
            cellMesh->indices.push_back(entry->second);
        }
    }
    return {id, cellMesh};
}

} // namespace

GridMesh sphere(const glm::dvec3& centre, double radius, int n)
{
    GridMesh mesh;
    std::map<std::array<std::int64_t, 3>, std::uint32_t> known;
    const auto vertex = [&](const glm::dvec3& onCube) {
        const glm::dvec3 normal = glm::normalize(onCube);
        const GridPoint point = snapped(centre + radius * normal);
        const auto [entry, isNew] = known.emplace(
            std::array{point.x, point.y, point.z}, static_cast<std::uint32_t>(mesh.points.size()));
        if (isNew) {
            mesh.points.push_back(point);
            mesh.normals.push_back(normal);
        }
        return entry->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const auto corner = [&](int i, int j) {
                glm::dvec3 p(0.0);
                p[axis] = side;
                p[(axis + 1) % 3] = side * (2.0 * i / n - 1.0);
                p[(axis + 2) % 3] = 2.0 * j / n - 1.0;
                return vertex(p);
            };
            for (int i = 0; i < n; ++i) {
                for (int j = 0; j < n; ++j) {
                    const std::uint32_t a = corner(i, j);
                    const std::uint32_t b = corner(i + 1, j);
                    const std::uint32_t c = corner(i + 1, j + 1);
                    const std::uint32_t d = corner(i, j + 1);
                    mesh.triangles.push_back({a, b, c});
                    mesh.triangles.push_back({a, c, d});
                }
            }
        }
    }
    return mesh;
}

GridMesh sheet(int n, const std::function<double(double, double)>& height)
{
    GridMesh mesh;
    const double step = 1.0 / n;
    for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
            const double x = i * step;
            const double y = j * step;
            mesh.points.push_back(snapped(glm::dvec3(x, y, height(x, y))));
            const double dx = height(x + 0.5 * step, y) - height(x - 0.5 * step, y);
            const double dy = height(x, y + 0.5 * step) - height(x, y - 0.5 * step);
            mesh.normals.push_back(glm::normalize(glm::dvec3(-dx, -dy, step)));
        }
    }
    const auto row = static_cast<std::uint32_t>(n) + 1;
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i;
            mesh.triangles.push_back({a, a + 1, a + row + 1});
            mesh.triangles.push_back({a, a + row + 1, a + row});
        }
    }
    return mesh;
}

std::vector<surface::ShownCell>
cut(const GridMesh& mesh, int blocks, std::uint32_t seed, std::uint8_t firstIndex)
{
    std::mt19937 random(seed);
    std::map<std::array<std::int64_t, 3>, Block> partition;
    const std::int64_t size = (std::int64_t{1} << hierarchy::kGridBits) / blocks + 1;
    for (const auto& triangle : mesh.triangles) {
        const GridPoint middle =
            (mesh.points[triangle[0]] + mesh.points[triangle[1]] + mesh.points[triangle[2]]) /
            std::int64_t{3};
        partition[{middle.x / size, middle.y / size, middle.z / size}].triangles.push_back(
            triangle);
    }
    std::vector<surface::ShownCell> cells;
    for (const auto& [place, block] : partition) {
        const surface::CellId id{
            {static_cast<std::uint32_t>(place[0]),
             static_cast<std::uint32_t>(place[1]),
             static_cast<std::uint32_t>(place[2])},
            firstIndex};
        cells.push_back(makeCell(mesh, block, id, random));
    }
    return cells;
}

surface::Delta showing(std::vector<surface::ShownCell> cells, std::uint64_t version)
{
    surface::Delta delta;
    delta.version = version;
    delta.added = std::move(cells);
    return delta;
}

} // namespace isofront::test

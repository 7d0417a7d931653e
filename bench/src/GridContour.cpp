#include "isofront/bench/GridContour.h"

#include <isofront/extractor/MarchingCubesTable.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

namespace isofront::bench {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

} // namespace

GridSamples sampledGrid(const fields::Field& field, const hierarchy::Domain& domain, int cells)
{
    GridSamples grid;
    grid.origin = domain.origin;
    grid.spacing = domain.edge / cells;
    grid.count = {cells + 1, cells + 1, cells + 1};
    const fields::SampleGrid points{
        grid.origin, grid.spacing, glm::i64vec3(0), glm::i64vec3(cells + 1), 0};
    grid.values.resize(points.size());
    field.sampleGrid(points, grid.values);
    return grid;
}

surface::TriangleMesh marchingCubes(
    const GridSamples& grid,
    double isovalue,
    const hierarchy::Domain& domain,
    const fields::Field* field)
{
    surface::TriangleMesh mesh;
    const auto& table = extractor::MarchingCubesTable::instance();
    const auto [nx, ny, nz] = grid.count;
    const auto rowLength = static_cast<std::size_t>(nx);
    const std::size_t sliceLength = rowLength * static_cast<std::size_t>(ny);
    // the vertex on each edge that leaves a point upwards: x and y in this slice and the next, z
    std::array<std::array<std::vector<std::uint32_t>, 3>, 2> vertexOn;
    for (auto& slice : vertexOn)
        for (auto& axis : slice)
            axis.assign(sliceLength, kNone);

    const auto pointAt = [&](int x, int y, int z) {
        return grid.origin + grid.spacing * glm::dvec3(x, y, z);
    };
    const auto valueAt = [&](int x, int y, int z) {
        return double(grid.values
                          [static_cast<std::size_t>(x) + rowLength * static_cast<std::size_t>(y) +
                           sliceLength * static_cast<std::size_t>(z)]) -
               isovalue;
    };
    for (int z = 0; z + 1 < nz; ++z) {
        for (int y = 0; y + 1 < ny; ++y)
            for (int x = 0; x + 1 < nx; ++x) {
                unsigned configuration = 0;
                std::array<double, 8> value{};
                for (int m = 0; m < 8; ++m) {
                    value[std::size_t(m)] = valueAt(x + (m & 1), y + (m >> 1 & 1), z + (m >> 2));
                    configuration |= value[std::size_t(m)] >= 0 ? 1U << unsigned(m) : 0U;
                }
                if (configuration == 0 || configuration == 255)
                    continue;
                const auto vertexOf = [&](std::size_t edge) {
                    const int a = extractor::kHexahedronEdges[edge][0];
                    const int b = extractor::kHexahedronEdges[edge][1];
                    const auto axis =
                        static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(a ^ b)));
                    const std::size_t at = static_cast<std::size_t>(x + (a & 1)) +
                                           rowLength * static_cast<std::size_t>(y + (a >> 1 & 1));
                    std::uint32_t& slot = vertexOn[std::size_t(a >> 2)][axis][at];
                    if (slot == kNone) {
                        slot = static_cast<std::uint32_t>(mesh.positions.size());
                        const double va = value[std::size_t(a)];
                        const double vb = value[std::size_t(b)];
                        const glm::dvec3 p = pointAt(x + (a & 1), y + (a >> 1 & 1), z + (a >> 2));
                        const glm::dvec3 q = pointAt(x + (b & 1), y + (b >> 1 & 1), z + (b >> 2));
                        mesh.positions.push_back(
                            domain.worldFromField.point(p + va / (va - vb) * (q - p)));
                    }
                    return slot;
                };
                const auto& shape = table[static_cast<std::uint8_t>(configuration)];
                for (std::size_t t = 0; t < shape.triangles; ++t)
                    for (const std::uint8_t edge : shape.edge[t])
                        mesh.indices.push_back(vertexOf(edge));
            }
        std::swap(vertexOn[0], vertexOn[1]);
        for (auto& axis : vertexOn[1])
            std::ranges::fill(axis, kNone);
    }
    if (domain.worldFromField.mirrors())
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
    for (const glm::dvec3& position : mesh.positions)
        mesh.bounds.include(position);
    if (field != nullptr)
        setNormals(mesh, *field, domain);
    return mesh;
}

void setNormals(
    surface::TriangleMesh& mesh, const fields::Field& field, const hierarchy::Domain& domain)
{
    const std::size_t count = mesh.positions.size();
    const core::Affine fieldFromWorld = domain.worldFromField.inverse();
    const glm::dmat3 normalMatrix = domain.worldFromField.normalMatrix();
    std::vector<double> x(count), y(count), z(count), gx(count), gy(count), gz(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 p = fieldFromWorld.point(mesh.positions[i]);
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
    }
    field.gradient({x, y, z}, {gx, gy, gz});
    mesh.normals.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 down = normalMatrix * -glm::dvec3(gx[i], gy[i], gz[i]);
        const double length = glm::length(down);
        mesh.normals[i] = glm::vec3(length > 0 ? down / length : glm::dvec3(0, 0, 1));
    }
}

} // namespace isofront::bench

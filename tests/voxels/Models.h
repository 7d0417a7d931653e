#pragma once

#include <isofront/voxels/ChunkSink.h>
#include <isofront/voxels/TriangleModel.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <map>
#include <numbers>

namespace isofront::tests {

/// A sphere of triangles with hills on it, closed: `rows` rings of `2 rows` quadrangles.
inline voxels::TriangleModel
hillySphere(std::uint32_t rows, double radius, double height, glm::dvec3 centre = glm::dvec3(0))
{
    voxels::TriangleModel model;
    const std::uint32_t columns = 2 * rows;
    const auto place = [&](double theta, double phi) {
        const glm::dvec3 d(
            std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        const double hill = std::sin(5 * d.x + 1) * std::sin(6 * d.y + 2) * std::sin(7 * d.z + 3);
        return centre + (radius + height * hill) * d;
    };
    model.positions.push_back(place(0, 0));
    for (std::uint32_t i = 1; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j)
            model.positions.push_back(
                place(std::numbers::pi * i / rows, 2 * std::numbers::pi * j / columns));
    model.positions.push_back(place(std::numbers::pi, 0));
    const auto index = [&](std::uint32_t i, std::uint32_t j) {
        return i == 0      ? 0
               : i == rows ? 1 + (rows - 1) * columns
                           : 1 + (i - 1) * columns + j % columns;
    };
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            if (i > 0)
                model.triangles.push_back({index(i, j), index(i + 1, j), index(i, j + 1)});
            if (i + 1 < rows)
                model.triangles.push_back({index(i, j + 1), index(i + 1, j), index(i + 1, j + 1)});
        }
    return model;
}

/// Keeps what it is given.
class KeptChunks : public voxels::ChunkSink {
public:
    std::optional<core::Error> put(voxels::Chunk chunk) override
    {
        const voxels::ChunkKey key = chunk.key;
        order.push_back(key);
        chunks.emplace(key, std::move(chunk));
        return std::nullopt;
    }

    std::map<voxels::ChunkKey, voxels::Chunk> chunks;
    std::vector<voxels::ChunkKey> order;
};

} // namespace isofront::tests

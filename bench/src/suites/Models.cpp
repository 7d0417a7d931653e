#include "Models.h"

#include <isofront/exchange/ModelFile.h>

#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <system_error>

namespace isofront::bench {

using voxels::TriangleModel;

std::optional<TriangleModel> modelFile(const Context& context, const std::string& name)
{
    for (const std::filesystem::path& folder : context.dataFolders) {
        const auto file = folder / ".." / "meshes" / name;
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored))
            continue;
        if (auto read = exchange::readModel(file))
            return std::move(*read);
    }
    return std::nullopt;
}

TriangleModel hills(std::uint32_t rows)
{
    TriangleModel model;
    const std::uint32_t columns = 2 * rows;
    for (std::uint32_t i = 0; i <= rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const double theta = std::numbers::pi * i / rows;
            const double phi = 2 * std::numbers::pi * j / columns;
            const glm::dvec3 d(
                std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
            const double hill = std::sin(9 * d.x) * std::sin(11 * d.y) * std::sin(8 * d.z + 1);
            model.positions.push_back((1 + 0.15 * hill) * d);
        }
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < columns; ++j) {
            const std::uint32_t a = i * columns + j;
            const std::uint32_t b = i * columns + (j + 1) % columns;
            model.triangles.push_back({a, a + columns, b});
            model.triangles.push_back({b, a + columns, b + columns});
        }
    return model;
}

TriangleModel city(int blocks, double height)
{
    TriangleModel model;
    const auto quad = [&](const std::array<glm::dvec3, 4>& corners) {
        const auto first = static_cast<std::uint32_t>(model.positions.size());
        for (const glm::dvec3& corner : corners)
            model.positions.push_back(corner);
        model.triangles.push_back({first, first + 1, first + 2});
        model.triangles.push_back({first, first + 2, first + 3});
    };
    quad({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
    const double pitch = 1.0 / blocks;
    for (int j = 0; j < blocks; ++j)
        for (int i = 0; i < blocks; ++i) {
            const double top = pitch * height * (1 + (7 * i + 5 * j + 3 * i * j) % 5);
            const glm::dvec3 a((i + 0.2) * pitch, (j + 0.2) * pitch, 0);
            const glm::dvec3 b((i + 0.8) * pitch, (j + 0.8) * pitch, top);
            quad({{{a.x, a.y, 0}, {b.x, a.y, 0}, {b.x, a.y, b.z}, {a.x, a.y, b.z}}});
            quad({{{b.x, a.y, 0}, {b.x, b.y, 0}, {b.x, b.y, b.z}, {b.x, a.y, b.z}}});
            quad({{{b.x, b.y, 0}, {a.x, b.y, 0}, {a.x, b.y, b.z}, {b.x, b.y, b.z}}});
            quad({{{a.x, b.y, 0}, {a.x, a.y, 0}, {a.x, a.y, b.z}, {a.x, b.y, b.z}}});
            quad({{{a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z}}});
        }
    return model;
}

TriangleModel modelOf(const surface::TriangleMesh& mesh)
{
    TriangleModel model;
    model.positions.assign(mesh.positions.begin(), mesh.positions.end());
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
        model.triangles.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
    return model;
}

core::Box boundsOf(const TriangleModel& model)
{
    core::Box box;
    for (const glm::dvec3& position : model.positions)
        box.include(position);
    return box;
}

double areaOf(const TriangleModel& model)
{
    double area = 0;
    for (const auto& t : model.triangles) {
        const glm::dvec3& a = model.positions[t[0]];
        area += 0.5 * glm::length(glm::cross(model.positions[t[1]] - a, model.positions[t[2]] - a));
    }
    return area;
}

std::function<void(double)> tenthsOf(const Context& context, std::string what)
{
    context.say(what);
    return [say = context.say, what = std::move(what), next = 0.1](double done) mutable {
        if (done < next)
            return;
        next = std::floor(10 * done) / 10 + 0.1;
        say(what + ", " + std::to_string(static_cast<int>(100 * done)) + " %");
    };
}

core::Result<std::shared_ptr<voxels::ChunkStore>> inMemory(
    const Context& context,
    const std::string& name,
    const TriangleModel& model,
    std::uint32_t resolution)
{
    const Cancellation cancellation(context);
    std::shared_ptr<voxels::ChunkStore> store = voxels::memoryStore();
    const auto made = voxels::voxelize(
        model,
        {.resolution = resolution},
        *store,
        *context.jobs,
        cancellation.flag(),
        tenthsOf(context, name + " becomes voxels, at " + std::to_string(resolution)));
    if (!made)
        return tl::unexpected(made.error());
    voxels::StoredModel stored;
    stored.name = name;
    stored.lattice = made->lattice;
    stored.voxels = made->voxels;
    stored.allVoxels = made->allVoxels;
    stored.chunks = made->chunks;
    stored.coloured = model.isColoured();
    if (const auto error = store->finish(stored))
        return tl::unexpected(*error);
    return store;
}

std::uint64_t bytesOf(const voxels::ChunkStore& store)
{
    std::uint64_t bytes = 0;
    if (const auto entries = store.directory())
        for (const voxels::ChunkEntry& entry : *entries)
            bytes += entry.bytes;
    return bytes;
}

} // namespace isofront::bench

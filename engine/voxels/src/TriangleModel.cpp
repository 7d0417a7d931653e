#include "LatticeExtent.h"

#include <isofront/voxels/TriangleModel.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <numeric>

namespace isofront::voxels {

namespace {

/// For each position, the first one that equals it.
std::vector<std::uint32_t> welded(const std::vector<glm::dvec3>& positions)
{
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto before = [&](std::uint32_t i, std::uint32_t j) {
        const glm::dvec3& a = positions[i];
        const glm::dvec3& b = positions[j];
        if (a.x != b.x)
            return a.x < b.x;
        if (a.y != b.y)
            return a.y < b.y;
        return a.z != b.z ? a.z < b.z : i < j;
    };
    // those that are no numbers have no order, and no triangle
    const auto end = std::partition(
        order.begin(), order.end(), [&](std::uint32_t i) { return isFinite(positions[i]); });
    std::sort(order.begin(), end, before);
    std::vector<std::uint32_t> first(positions.size());
    for (auto i = order.begin(); i != order.end(); ++i)
        first[*i] = i != order.begin() && i < end && positions[*(i - 1)] == positions[*i]
                        ? first[*(i - 1)]
                        : *i;
    return first;
}

void countEdges(
    const TriangleModel& model,
    const std::vector<std::uint32_t>& usable,
    const std::vector<std::uint32_t>& weld,
    ModelReport& report)
{
    // lower end, higher end, and in the lowest bit which way it runs
    struct Edge {
        std::uint64_t ends;
        bool forward;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * usable.size());
    for (const std::uint32_t index : usable) {
        std::array<std::uint64_t, 3> corners{};
        for (std::size_t corner = 0; corner < 3; ++corner)
            corners[corner] = weld[model.triangles[index][corner]];
        // one that has shrunk to a line, or a point, leaves its neighbours side by side
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            continue;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint64_t a = corners[corner];
            const std::uint64_t b = corners[(corner + 1) % 3];
            edges.push_back({std::min(a, b) << 32U | std::max(a, b), a < b});
        }
    }
    std::ranges::sort(edges, {}, &Edge::ends);
    for (auto i = edges.begin(); i != edges.end();) {
        const auto begin = i;
        int forward = 0;
        for (; i != edges.end() && i->ends == begin->ends; ++i)
            forward += i->forward ? 1 : 0;
        const auto count = i - begin;
        report.openEdges += count == 1 ? 1U : 0U;
        report.nonManifoldEdges += count > 2 ? 1U : 0U;
        report.turnedEdges += count == 2 && forward != 1 ? 1U : 0U;
    }
}

} // namespace

ModelReport inspect(const TriangleModel& model)
{
    ModelReport report;
    report.triangles = model.triangles.size();
    std::vector<std::uint32_t> usable;
    usable.reserve(model.triangles.size());
    for (std::size_t index = 0; index < model.triangles.size(); ++index) {
        const auto& corners = model.triangles[index];
        if (std::ranges::any_of(corners, [&](auto i) { return i >= model.positions.size(); })) {
            ++report.outOfRange;
            continue;
        }
        const glm::dvec3& a = model.positions[corners[0]];
        const glm::dvec3& b = model.positions[corners[1]];
        const glm::dvec3& c = model.positions[corners[2]];
        if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
            ++report.notFinite;
            continue;
        }
        const glm::dvec3 area = glm::cross(b - a, c - a);
        report.degenerate += area == glm::dvec3(0) ? 1U : 0U;
        for (const glm::dvec3& corner : {a, b, c})
            report.bounds.include(corner);
        usable.push_back(static_cast<std::uint32_t>(index));
    }
    countEdges(model, usable, welded(model.positions), report);
    return report;
}

std::vector<std::string> ModelReport::notes() const
{
    std::vector<std::string> notes;
    const auto note = [&](std::uint64_t count, const char* what) {
        if (count > 0)
            notes.push_back(std::to_string(count) + " " + what);
    };
    note(outOfRange, "triangles name positions that are not there, and are left out");
    note(notFinite, "triangles have corners that are not finite numbers, and are left out");
    note(degenerate, "triangles have no area");
    note(
        openEdges,
        "edges belong to one triangle only: the model is open, and shows both sides "
        "where one can look in");
    note(nonManifoldEdges, "edges belong to more than two triangles");
    note(
        turnedEdges,
        "edges lie between triangles that don't agree on what is outside: normals "
        "there may cancel out");
    return notes;
}

} // namespace isofront::voxels

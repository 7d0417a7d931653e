#include "LatticeExtent.h"

#include <isofront/voxels/TriangleModel.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace isofront::voxels {

namespace {

/// Of a position that is not finite: it equals none, and has no triangle.
constexpr std::uint32_t kNone = 0xffffffffU;
/// Edges that are looked at together: larger models are gone through several times [128 MB].
constexpr std::size_t kMostEdges = std::size_t{1} << 24U;

std::uint64_t hashOf(const glm::dvec3& position)
{
    std::uint64_t hash = 0;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        // zeros of either sign are equal
        hash ^= std::bit_cast<std::uint64_t>(position[axis] + 0.0);
        hash *= 0x9e3779b97f4a7c15U;
        hash ^= hash >> 32U;
    }
    hash *= 0xd6e8feb86659fd93U;
    return hash ^ hash >> 32U;
}

/// For each position, the first one that equals it.
std::vector<std::uint32_t> welded(const std::vector<glm::dvec3>& positions)
{
    std::vector<std::uint32_t> first(positions.size());
    std::vector<std::uint32_t> table(std::bit_ceil(positions.size() + positions.size() / 2), kNone);
    const std::uint64_t mask = table.size() - 1;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        first[i] = kNone;
        if (!isFinite(positions[i]))
            continue;
        std::uint64_t slot = hashOf(positions[i]) & mask;
        while (table[slot] != kNone && positions[table[slot]] != positions[i])
            slot = (slot + 1) & mask;
        if (table[slot] == kNone)
            table[slot] = i;
        first[i] = table[slot];
    }
    return first;
}

/// Calls `body(lower, higher, forward)` for each edge of each usable triangle, with its ends among
/// those of equal positions.
template <typename Body>
void forEachEdge(
    const TriangleModel& model, const std::vector<std::uint32_t>& weld, const Body& body)
{
    for (const std::array<std::uint32_t, 3>& triangle : model.triangles) {
        std::array<std::uint32_t, 3> corners{};
        bool isUsable = true;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            corners[corner] = triangle[corner] < weld.size() ? weld[triangle[corner]] : kNone;
            isUsable = isUsable && corners[corner] != kNone;
        }
        // one that has shrunk to a line, or a point, leaves its neighbours side by side
        if (!isUsable || corners[0] == corners[1] || corners[1] == corners[2] ||
            corners[2] == corners[0])
            continue;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t a = corners[corner];
            const std::uint32_t b = corners[(corner + 1) % 3];
            body(std::min(a, b), std::max(a, b), a < b);
        }
    }
}

/// Counts edges by how many triangles they have. Goes through them by their lower ends, of so many
/// positions at a time that their edges don't take much memory.
void countEdges(
    const TriangleModel& model, const std::vector<std::uint32_t>& weld, ModelReport& report)
{
    // how many edges begin at a position; then where they end, among those looked at
    std::vector<std::uint32_t> ends(weld.size());
    forEachEdge(model, weld, [&](auto lower, auto, auto) { ++ends[lower]; });
    std::vector<std::uint64_t> edges; // higher end, and in the lowest bit which way it runs
    for (std::size_t begin = 0; begin < ends.size();) {
        std::size_t end = begin;
        std::size_t sum = 0;
        while (end < ends.size() && (end == begin || sum + ends[end] <= kMostEdges)) {
            sum += ends[end];
            ends[end] = static_cast<std::uint32_t>(sum - ends[end]);
            ++end;
        }
        edges.resize(sum);
        forEachEdge(model, weld, [&](auto lower, auto higher, bool forward) {
            if (lower >= begin && lower < end)
                edges[ends[lower]++] = std::uint64_t{higher} << 1U | (forward ? 1U : 0U);
        });
        auto edge = edges.begin();
        for (std::size_t lower = begin; lower < end; ++lower) {
            const auto last = edges.begin() + static_cast<std::ptrdiff_t>(ends[lower]);
            std::sort(edge, last);
            while (edge != last) {
                const std::uint64_t higher = *edge >> 1U;
                std::size_t count = 0;
                std::size_t forward = 0;
                for (; edge != last && *edge >> 1U == higher; ++edge) {
                    ++count;
                    forward += *edge & 1U;
                }
                report.openEdges += count == 1 ? 1U : 0U;
                report.nonManifoldEdges += count > 2 ? 1U : 0U;
                report.turnedEdges += count == 2 && forward != 1 ? 1U : 0U;
            }
        }
        begin = end;
    }
}

} // namespace

ModelReport inspect(const TriangleModel& model)
{
    ModelReport report;
    report.triangles = model.triangles.size();
    for (const std::array<std::uint32_t, 3>& corners : model.triangles) {
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
    }
    countEdges(model, welded(model.positions), report);
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

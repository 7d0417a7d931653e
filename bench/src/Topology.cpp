#include "isofront/bench/Topology.h"

#include <isofront/core/Hash.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace isofront::bench {

namespace {

/// Sets that are joined until only whole components are left.
class Unions {
public:
    explicit Unions(std::size_t count) : _parent(count)
    {
        std::iota(_parent.begin(), _parent.end(), 0U);
    }
    std::uint32_t root(std::uint32_t i)
    {
        while (_parent[i] != i)
            i = _parent[i] = _parent[_parent[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { _parent[root(a)] = root(b); }

private:
    std::vector<std::uint32_t> _parent;
};

} // namespace

Topology topologyOf(const surface::TriangleMesh& mesh)
{
    Topology topology;
    const std::size_t triangles = mesh.indices.size() / 3;
    const std::size_t vertices = mesh.positions.size();
    Unions unions(vertices);
    std::vector<std::uint64_t> edges;
    edges.reserve(mesh.indices.size());
    std::vector<std::uint32_t> valence(vertices, 0);
    double quality = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        double lengths = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = mesh.indices[3 * t + i];
            const std::uint32_t b = mesh.indices[3 * t + (i + 1) % 3];
            edges.push_back((std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b));
            unions.join(a, b);
            ++valence[a];
            const glm::dvec3 side = mesh.positions[b] - mesh.positions[a];
            lengths += glm::dot(side, side);
        }
        const glm::dvec3& p = mesh.positions[mesh.indices[3 * t]];
        const double area = 0.5 * glm::length(glm::cross(
                                      mesh.positions[mesh.indices[3 * t + 1]] - p,
                                      mesh.positions[mesh.indices[3 * t + 2]] - p));
        const double shape = lengths > 0 ? 4 * std::sqrt(3.0) * area / lengths : 0;
        quality += shape;
        topology.slivers += shape < 0.2 ? 1U : 0U;
        topology.area += area;
    }
    std::ranges::sort(edges);
    std::vector<bool> isInside(vertices, true);
    std::size_t distinct = 0;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end] == edges[i])
            ++end;
        ++distinct;
        topology.nonManifold += end - i > 2 ? 1U : 0U;
        if (end - i == 1) {
            ++topology.openEdges;
            isInside[edges[i] >> 32U] = false;
            isInside[edges[i] & 0xffffffffU] = false;
        }
        i = end;
    }
    std::size_t used = 0;
    std::size_t inside = 0;
    std::size_t six = 0;
    std::size_t corners = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        if (valence[v] == 0)
            continue;
        ++used;
        if (!isInside[v])
            continue;
        ++inside;
        corners += valence[v];
        six += valence[v] == 6 ? 1U : 0U;
    }
    topology.euler =
        static_cast<long>(used) - static_cast<long>(distinct) + static_cast<long>(triangles);
    if (triangles > 0)
        topology.quality = quality / static_cast<double>(triangles);
    if (inside > 0) {
        topology.meanValence = static_cast<double>(corners) / static_cast<double>(inside);
        topology.sixShare = static_cast<double>(six) / static_cast<double>(inside);
    }
    constexpr std::uint32_t kNone = UINT32_MAX;
    std::vector<std::uint32_t> nameOf(vertices, kNone);
    topology.componentOf.reserve(triangles);
    for (std::size_t t = 0; t < triangles; ++t) {
        std::uint32_t& name = nameOf[unions.root(mesh.indices[3 * t])];
        if (name == kNone)
            name = static_cast<std::uint32_t>(topology.components++);
        topology.componentOf.push_back(name);
    }
    return topology;
}

std::uint64_t checksumOf(const surface::TriangleMesh& mesh)
{
    std::uint64_t hash = core::hashCombined(mesh.positions.size(), mesh.indices.size());
    for (const glm::dvec3& p : mesh.positions)
        for (const double value : {p.x, p.y, p.z})
            hash = core::hashCombined(hash, std::bit_cast<std::uint64_t>(value));
    for (const std::uint32_t index : mesh.indices)
        hash = core::hashCombined(hash, index);
    return hash;
}

} // namespace isofront::bench

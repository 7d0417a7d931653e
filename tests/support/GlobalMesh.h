#pragma once

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Front.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace isofront::tests {

/// The mesh of a whole front, joined at the lattice edges that cells share, and what is wrong with
/// it. Written apart from the product's own assembly, so that each checks the other.
class GlobalMesh {
public:
    void
    add(const hierarchy::Domain& domain,
        const extractor::CellMesh& mesh,
        const extractor::CellTrace& trace)
    {
        std::vector<std::uint32_t> global(mesh.vertices.size(), UINT32_MAX);
        for (const extractor::BorderVertex& border : trace.borders) {
            const extractor::CellVertex& vertex = mesh.vertices[border.vertex];
            const Copy copy{mesh.gridPosition(vertex), vertex.normal, vertex.flags};
            const auto [found, isNew] =
                _border.try_emplace(border.key, static_cast<std::uint32_t>(positions.size()));
            if (isNew) {
                positions.push_back(domain.fieldFromGrid(copy.position));
                _copies.emplace(found->second, copy);
            } else {
                ++sharedCopies;
                if (!(_copies.at(found->second) == copy))
                    ++differingCopies;
            }
            global[border.vertex] = found->second;
        }
        for (std::size_t i = 0; i < global.size(); ++i)
            if (global[i] == UINT32_MAX) {
                global[i] = static_cast<std::uint32_t>(positions.size());
                positions.push_back(domain.fieldFromGrid(mesh.gridPosition(mesh.vertices[i])));
            }
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            triangles.push_back(
                {global[mesh.indices[i]],
                 global[mesh.indices[i + 1]],
                 global[mesh.indices[i + 2]]});
    }

    struct Defects {
        std::size_t open = 0;        ///< edges of one triangle
        std::size_t nonManifold = 0; ///< edges of more than two
        std::size_t misoriented = 0; ///< edges that two triangles run along in the same direction
        std::size_t degenerate = 0;  ///< triangles of no area
    };

    [[nodiscard]] Defects defects() const
    {
        Defects result;
        for (const auto& [edge, uses] : edgeUses()) {
            const int total = uses[0] + uses[1];
            result.open += total == 1 ? 1U : 0U;
            result.nonManifold += total > 2 ? 1U : 0U;
            result.misoriented += total == 2 && uses[0] != 1 ? 1U : 0U;
        }
        for (const auto& t : triangles) {
            const glm::dvec3 normal =
                glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
            result.degenerate += glm::length(normal) == 0 ? 1U : 0U;
        }
        return result;
    }

    /// Edges of one triangle, as pairs of positions.
    [[nodiscard]] std::vector<std::array<glm::dvec3, 2>> openEdges() const
    {
        std::vector<std::array<glm::dvec3, 2>> result;
        for (const auto& [edge, uses] : edgeUses())
            if (uses[0] + uses[1] == 1)
                result.push_back({positions[edge.first], positions[edge.second]});
        return result;
    }

    [[nodiscard]] long eulerNumber() const
    {
        std::vector<bool> used(positions.size(), false);
        for (const auto& t : triangles)
            for (const std::uint32_t v : t)
                used[v] = true;
        return std::ranges::count(used, true) - static_cast<long>(edgeUses().size()) +
               static_cast<long>(triangles.size());
    }

    /// Signed: positive if triangles run counter-clockwise seen from outside.
    [[nodiscard]] double volume() const
    {
        double sum = 0;
        for (const auto& t : triangles)
            sum += glm::dot(
                       positions[t[0]] - positions[triangles[0][0]],
                       glm::cross(
                           positions[t[1]] - positions[triangles[0][0]],
                           positions[t[2]] - positions[triangles[0][0]])) /
                   6;
        return sum;
    }

    std::vector<glm::dvec3> positions; ///< [field]
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::size_t sharedCopies = 0;
    std::size_t differingCopies = 0; ///< border vertices whose bits differ between two cells

private:
    struct Copy {
        hierarchy::GridPoint position;
        std::array<std::int16_t, 2> normal;
        std::uint16_t flags;
        bool operator==(const Copy&) const = default;
    };
    struct KeyHash {
        std::size_t operator()(const std::array<std::int64_t, 3>& key) const
        {
            std::uint64_t hash = 0;
            for (const std::int64_t word : key)
                hash = core::hashCombined(hash, static_cast<std::uint64_t>(word));
            return hash;
        }
    };
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    struct EdgeHash {
        std::size_t operator()(const Edge& edge) const
        {
            return core::mixed((std::uint64_t{edge.first} << 32U) | edge.second);
        }
    };

    [[nodiscard]] std::unordered_map<Edge, std::array<int, 2>, EdgeHash> edgeUses() const
    {
        std::unordered_map<Edge, std::array<int, 2>, EdgeHash> uses;
        for (const auto& t : triangles)
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = t[i];
                const std::uint32_t b = t[(i + 1) % 3];
                ++uses[{std::min(a, b), std::max(a, b)}][a < b ? 0 : 1];
            }
        return uses;
    }

    std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t, KeyHash> _border;
    std::unordered_map<std::uint32_t, Copy> _copies;
};

/// Extracts every cell of a front.
inline GlobalMesh
extractFront(const hierarchy::Front& front, const extractor::CellExtractor& extractor)
{
    GlobalMesh mesh;
    front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
        extractor::CellTrace trace;
        const auto part = extractor.extract(cell, &trace);
        mesh.add(extractor.domain(), *part, trace);
    });
    return mesh;
}

} // namespace isofront::tests

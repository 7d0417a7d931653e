#pragma once

#include <isofront/hierarchy/Front.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::tests {

/// Triangular faces that don't occur in exactly two cells, or in one where they lie on the border
/// of the domain; by brute force over all cells.
inline std::size_t nonConformingFaces(const hierarchy::Front& front)
{
    using Face = std::array<hierarchy::LatticePoint, 3>;
    std::vector<Face> faces;
    front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
        for (std::size_t skipped = 0; skipped < 4; ++skipped) {
            Face face;
            for (std::size_t i = 0, k = 0; i < 4; ++i)
                if (i != skipped)
                    face[k++] = cell.corner[i];
            std::sort(face.begin(), face.end());
            faces.push_back(face);
        }
    });
    std::sort(faces.begin(), faces.end());
    std::size_t bad = 0;
    for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
        const Face& face = faces[first];
        while (last < faces.size() && faces[last] == face)
            ++last;
        const std::size_t uses = last - first;
        bool onBorder = false;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const std::uint32_t wall : {0U, hierarchy::kLatticeEdge})
                onBorder = onBorder || (face[0][axis] == wall && face[1][axis] == wall &&
                                        face[2][axis] == wall);
        if (uses != (onBorder ? 1U : 2U))
            ++bad;
    }
    return bad;
}

/// True if the cells' volumes add up to the domain's, exactly: a cell of level L has 2^-L / 6 of
/// it, so cells are counted by level, and pairs are carried to the level above.
inline bool tilesTheDomain(const hierarchy::Front& front)
{
    std::array<std::size_t, hierarchy::kMaxLevel + 1> cells{};
    front.forEachCell([&](const hierarchy::CellId&, const hierarchy::Tetrahedron& cell) {
        ++cells[static_cast<std::size_t>(cell.level)];
    });
    std::size_t carried = 0;
    for (std::size_t level = cells.size(); level-- > 0;) {
        if (carried % 2 != 0)
            return false;
        carried = carried / 2 + cells[level];
    }
    return carried == 6;
}

inline std::vector<hierarchy::LatticePoint> splittable(const hierarchy::Front& front)
{
    std::vector<hierarchy::LatticePoint> result;
    front.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
        if (!front.isSplit(centre) && hierarchy::Diamond(centre).level < hierarchy::kMaxLevel)
            result.push_back(centre);
    });
    std::sort(result.begin(), result.end());
    return result;
}

inline std::vector<hierarchy::LatticePoint> mergeable(const hierarchy::Front& front)
{
    std::vector<hierarchy::LatticePoint> result;
    front.forEachDiamond([&](const hierarchy::LatticePoint& centre) {
        if (front.isMergeable(centre))
            result.push_back(centre);
    });
    std::sort(result.begin(), result.end());
    return result;
}

} // namespace isofront::tests

#pragma once

#include <array>
#include <cstdint>

namespace isofront::extractor {

/// Corner m = a + 2 b + 4 c of a hexahedron is inside exactly if bit m of its configuration is set.
inline constexpr std::array<std::array<std::uint8_t, 2>, 12> kHexahedronEdges{
    {{0, 1},
     {2, 3},
     {4, 5},
     {6, 7},
     {0, 2},
     {1, 3},
     {4, 6},
     {5, 7},
     {0, 4},
     {1, 5},
     {2, 6},
     {3, 7}}};

/// The corners of each side, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kHexahedronFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

/// The edge between two corners of a hexahedron that share one.
std::uint8_t hexahedronEdge(std::uint8_t cornerA, std::uint8_t cornerB);

/// How the surface runs through a hexahedron, for each of the 256 ways its corners can be inside or
/// outside.
///
/// What is guaranteed: a side's line depends on the signs at that side's corners only, and an
/// ambiguous side separates its inside corners, so neighbours agree. No triangle has an edge that
/// lies in a side and is not such a line, so no two hexahedra can make the same edge twice.
/// Swapping inside and outside is not a symmetry.
///
/// The table is generated: lines on the sides are joined to loops, and each loop is cut into
/// triangles by the triangulation with the fewest diagonals within a side; that is none, always.
class MarchingCubesTable {
public:
    struct Case {
        std::uint8_t triangles = 0;                        ///< at most 5
        std::array<std::array<std::uint8_t, 3>, 5> edge{}; ///< counter-clockwise from outside
    };

    MarchingCubesTable();
    /// The one table, made at first use. Thread: any.
    static const MarchingCubesTable& instance();

    [[nodiscard]] const Case& operator[](std::uint8_t configuration) const
    {
        return _cases[configuration];
    }

private:
    std::array<Case, 256> _cases{};
};

} // namespace isofront::extractor

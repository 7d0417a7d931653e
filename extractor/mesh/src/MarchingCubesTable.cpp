#include "isofront/extractor/MarchingCubesTable.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

namespace isofront::extractor {

namespace {

using Loop = std::vector<std::uint8_t>; ///< edges of the hexahedron, in order

bool isInside(unsigned configuration, std::uint8_t corner)
{
    return (configuration >> corner & 1U) != 0;
}

bool shareSide(std::uint8_t edgeA, std::uint8_t edgeB)
{
    const auto onSide = [](std::uint8_t edge, const std::array<std::uint8_t, 4>& side) {
        return std::ranges::count(side, kHexahedronEdges[edge][0]) != 0 &&
               std::ranges::count(side, kHexahedronEdges[edge][1]) != 0;
    };
    return std::ranges::any_of(kHexahedronFaces, [&](const auto& side) {
        return onSide(edgeA, side) && onSide(edgeB, side);
    });
}

/// The closed polygons in which the surface cuts the hexahedron's edges, facing outside.
std::vector<Loop> loopsOf(unsigned configuration)
{
    constexpr std::uint8_t kNone = 255;
    std::array<std::uint8_t, 12> next{};
    next.fill(kNone);
    for (const auto& side : kHexahedronFaces) {
        std::vector<std::uint8_t> leaving;  // where the cycle goes from inside to outside
        std::vector<std::uint8_t> entering; // and back
        for (std::uint8_t i = 0; i < 4; ++i) {
            const bool from = isInside(configuration, side[i]);
            const bool to = isInside(configuration, side[(i + 1U) % 4]);
            if (from && !to)
                leaving.push_back(i);
            if (!from && to)
                entering.push_back(i);
        }
        const auto edgeAt = [&](unsigned i) {
            return hexahedronEdge(side[i % 4], side[(i + 1) % 4]);
        };
        if (leaving.size() == 1)
            next[edgeAt(leaving[0])] = edgeAt(entering[0]);
        else // two: each inside corner is cut off by itself
            for (const std::uint8_t i : leaving)
                next[edgeAt(i)] = edgeAt(i + 3U);
    }

    std::vector<Loop> loops;
    std::array<bool, 12> seen{};
    for (std::uint8_t start = 0; start < 12; ++start) {
        if (next[start] == kNone || seen[start])
            continue;
        Loop loop;
        for (std::uint8_t edge = start; !seen[edge]; edge = next[edge]) {
            seen[edge] = true;
            loop.push_back(edge);
        }
        std::ranges::reverse(loop); // the links turn the inside to the left of the sides
        loops.push_back(loop);
    }
    return loops;
}

/// Cuts a loop into triangles with the fewest diagonals within a side.
void triangulate(const Loop& loop, MarchingCubesTable::Case& result)
{
    const std::size_t m = loop.size();
    const auto penalty = [&](std::size_t i, std::size_t j) {
        const bool isSide = j - i == 1 || j - i == m - 1;
        return !isSide && shareSide(loop[i], loop[j]) ? 1 : 0;
    };
    std::vector<std::vector<int>> cost(m, std::vector<int>(m, 0));
    std::vector<std::vector<std::size_t>> apex(m, std::vector<std::size_t>(m, 0));
    for (std::size_t span = 2; span < m; ++span)
        for (std::size_t i = 0; i + span < m; ++i) {
            const std::size_t j = i + span;
            cost[i][j] = std::numeric_limits<int>::max();
            for (std::size_t k = i + 1; k < j; ++k) {
                const int total = cost[i][k] + cost[k][j] + penalty(i, k) + penalty(k, j);
                if (total < cost[i][j]) {
                    cost[i][j] = total;
                    apex[i][j] = k;
                }
            }
        }
    ISOFRONT_ASSERT(cost[0][m - 1] == 0, "a loop needs a diagonal within a side");

    const std::function<void(std::size_t, std::size_t)> emit = [&](std::size_t i, std::size_t j) {
        if (j - i < 2)
            return;
        const std::size_t k = apex[i][j];
        emit(i, k);
        result.edge[result.triangles++] = {loop[i], loop[k], loop[j]};
        emit(k, j);
    };
    emit(0, m - 1);
}

} // namespace

std::uint8_t hexahedronEdge(std::uint8_t cornerA, std::uint8_t cornerB)
{
    for (std::uint8_t edge = 0; edge < 12; ++edge) {
        const auto& [a, b] = kHexahedronEdges[edge];
        if ((a == cornerA && b == cornerB) || (a == cornerB && b == cornerA))
            return edge;
    }
    ISOFRONT_ASSERT(false, "the corners share no edge");
    return 0;
}

MarchingCubesTable::MarchingCubesTable()
{
    for (unsigned configuration = 0; configuration < 256; ++configuration)
        for (const Loop& loop : loopsOf(configuration))
            triangulate(loop, _cases[configuration]);
}

const MarchingCubesTable& MarchingCubesTable::instance()
{
    static const MarchingCubesTable table;
    return table;
}

} // namespace isofront::extractor

#include "isofront/extractor/VolumeMesh.h"

#include "HilbertCurve.h"
#include "isofront/extractor/MarchingCubesTable.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Hash.h>

#include <algorithm>
#include <bit>
#include <string>
#include <unordered_map>

namespace isofront::extractor {

namespace {

using Weights = std::array<std::uint32_t, 4>;

struct WeightsHash {
    std::size_t operator()(const Weights& w) const
    {
        return core::hashCombined(
            (std::uint64_t{w[0]} << 32U) | w[1], (std::uint64_t{w[2]} << 32U) | w[3]);
    }
};

/// For the hexahedron at each corner: the tetrahedron's corners along its local axes. With its own
/// corner first each row is an even permutation, so that no hexahedron is mirrored.
constexpr std::array<std::array<std::size_t, 4>, 4> kAxes{
    {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}}};

/// Weights of point (a, b, c) of a corner's hexahedron, each coordinate in [0, n]: trilinear
/// interpolation of the corner, midpoints of edges, centres of faces and the centre of the cell.
Weights weightsAt(std::size_t corner, std::array<std::uint32_t, 3> at, std::uint32_t n)
{
    Weights weights{};
    for (unsigned m = 0; m < 8; ++m) {
        std::uint32_t factor = 1;
        for (unsigned axis = 0; axis < 3; ++axis)
            factor *= (m >> axis & 1U) != 0 ? at[axis] : n - at[axis];
        const auto parts = static_cast<std::uint32_t>(1 + std::popcount(m));
        for (unsigned i = 0; i < 4; ++i)
            if (i == 0 || (m >> (i - 1) & 1U) != 0)
                weights[kAxes[corner][i]] += factor * (12 / parts);
    }
    return weights;
}

FeatureMask featureOf(const Weights& weights)
{
    unsigned mask = 0;
    for (unsigned i = 0; i < 4; ++i)
        if (weights[i] == 0)
            mask |= 1U << i;
    return static_cast<FeatureMask>(mask);
}

} // namespace

bool VolumeMesh::isValidSize(int latticeSize)
{
    return latticeSize == 1 || latticeSize == 2 || latticeSize == 4 || latticeSize == 8 ||
           latticeSize == 16;
}

VolumeMesh::VolumeMesh(int latticeSize) : _n(latticeSize), _denominator(0)
{
    ISOFRONT_ASSERT(
        isValidSize(latticeSize),
        "the lattice size must be 1, 2, 4, 8 or 16, not " + std::to_string(latticeSize));
    const auto n = static_cast<std::uint32_t>(latticeSize);
    _denominator = 12 * n * n * n;

    std::unordered_map<Weights, std::uint16_t, WeightsHash> vertexOf;
    const auto vertexAt = [&](std::size_t corner, std::array<std::uint32_t, 3> at) {
        const Weights w = weightsAt(corner, at, n);
        const auto [found, isNew] = vertexOf.try_emplace(w, std::uint16_t(weights.size()));
        if (isNew) {
            weights.push_back(w);
            vertexFeature.push_back(featureOf(w));
        }
        return found->second;
    };
    std::unordered_map<std::uint32_t, std::uint16_t> edgeOf;
    const auto edgeBetween = [&](std::uint16_t a, std::uint16_t b) {
        const std::uint32_t key = (std::uint32_t{std::min(a, b)} << 16U) | std::max(a, b);
        const auto [found, isNew] = edgeOf.try_emplace(key, std::uint16_t(edges.size()));
        if (isNew) {
            edges.push_back({std::min(a, b), std::max(a, b)});
            edgeFeature.push_back(static_cast<FeatureMask>(vertexFeature[a] & vertexFeature[b]));
        }
        return found->second;
    };

    const auto order = static_cast<unsigned>(std::countr_zero(n));
    for (std::size_t corner = 0; corner < 4; ++corner)
        for (std::uint32_t step = 0; step < n * n * n; ++step) {
            const auto cell = hilbertCell(step, order);
            Hexahedron hexahedron;
            hexahedron.place =
                static_cast<std::uint16_t>(cell[0] + (n + 1) * (cell[1] + (n + 1) * cell[2]));
            for (unsigned m = 0; m < 8; ++m)
                hexahedron.vertex[m] = vertexAt(
                    corner, {cell[0] + (m & 1U), cell[1] + (m >> 1U & 1U), cell[2] + (m >> 2U)});
            for (std::size_t e = 0; e < 12; ++e)
                hexahedron.edge[e] = edgeBetween(
                    hexahedron.vertex[kHexahedronEdges[e][0]],
                    hexahedron.vertex[kHexahedronEdges[e][1]]);
            hexahedra.push_back(hexahedron);

            for (const auto& side : kHexahedronFaces) {
                unsigned shared = 0xF;
                for (const std::uint8_t m : side)
                    shared &= vertexFeature[hexahedron.vertex[m]];
                if (shared == 0)
                    continue;
                BoundaryQuad quad;
                for (std::size_t i = 0; i < 4; ++i) {
                    quad.vertex[i] = hexahedron.vertex[side[i]];
                    quad.edge[i] = hexahedron.edge[hexahedronEdge(side[i], side[(i + 1) % 4])];
                }
                boundary[static_cast<std::size_t>(std::countr_zero(shared))].push_back(quad);
            }
        }

    for (std::size_t corner = 0; corner < 4; ++corner) {
        for (const Weights& w : weights)
            weightColumns[corner].push_back(w[corner]);
        for (std::uint32_t c = 0; c <= n; ++c)
            for (std::uint32_t b = 0; b <= n; ++b)
                for (std::uint32_t a = 0; a <= n; ++a)
                    block[corner].push_back(vertexAt(corner, {a, b, c}));
    }
}

const VolumeMesh& VolumeMesh::ofSize(int latticeSize)
{
    switch (latticeSize) {
    case 1: {
        static const VolumeMesh mesh(1);
        return mesh;
    }
    case 2: {
        static const VolumeMesh mesh(2);
        return mesh;
    }
    case 4: {
        static const VolumeMesh mesh(4);
        return mesh;
    }
    case 8: {
        static const VolumeMesh mesh(8);
        return mesh;
    }
    default: {
        ISOFRONT_ASSERT(latticeSize == 16, "the lattice size must be 1, 2, 4, 8 or 16");
        static const VolumeMesh mesh(16);
        return mesh;
    }
    }
}

} // namespace isofront::extractor

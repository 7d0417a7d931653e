#include "CrossingKernel.h"
#include "NormalKernel.h"
#include "Normals.h"
#include "RoughMesh.h"
#include "fields/FieldChecks.h"
#include "support/Random.h"

#include <isofront/extractor/CellMesh.h>
#include <isofront/extractor/VolumeMesh.h>
#include <isofront/hierarchy/LatticePoint.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <vector>

namespace isofront::extractor {
namespace {

double component(std::mt19937_64& generator)
{
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    switch (tests::below(generator, 12)) {
    case 0:
        return 0.0;
    case 1:
        return -0.0;
    case 2:
        return tests::below(generator, 2) == 0 ? 1.0 : -1.0;
    case 3:
        return tests::uniform(generator, -1e-310, 1e-310);
    case 4:
        return tests::uniform(generator, -1e300, 1e300);
    case 5:
        return tests::below(generator, 2) == 0 ? kInfinity : -kInfinity;
    case 6:
        return std::numeric_limits<double>::quiet_NaN();
    default:
        return tests::uniform(generator, -2, 2);
    }
}

TEST(NormalKernel, encodesAsOneByOneOnEveryInstructionSet)
{
    auto generator = tests::random(1);
    const std::size_t count = 5003; // no multiple of any register
    std::array<std::vector<double>, 3> gradients;
    for (auto& column : gradients)
        std::ranges::generate_n(
            std::back_inserter(column), count, [&] { return component(generator); });
    fields::test::onEveryInstructionSet([&](const std::string& name) {
        std::vector<std::uint32_t> codes(count);
        encodeNormals(
            {gradients[0].data(), gradients[1].data(), gradients[2].data()}, count, codes.data());
        std::size_t unknown = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec3 normal = outward({gradients[0][i], gradients[1][i], gradients[2][i]});
            if (normal == glm::dvec3(0.0)) {
                ASSERT_EQ(codes[i], kNoNormalCode) << name << ", gradient " << i;
                ++unknown;
                continue;
            }
            const auto twin = octahedral(normal);
            ASSERT_EQ(static_cast<std::int16_t>(codes[i] & 0xFFFFU), twin[0]) << name << ' ' << i;
            ASSERT_EQ(static_cast<std::int16_t>(codes[i] >> 16U), twin[1]) << name << ' ' << i;
        }
        EXPECT_GT(unknown, count / 10);
        EXPECT_LT(unknown, count / 2);
    });
}

TEST(CrossingKernel, placesAsOneByOneOnEveryInstructionSet)
{
    const VolumeMesh& mesh = VolumeMesh::ofSize(16);
    auto generator = tests::random(2);
    const auto given = std::make_unique<CrossingBlock>();
    std::array<std::array<double, 3>, 4> corners{};
    for (auto& corner : corners)
        for (double& coordinate : corner)
            coordinate = static_cast<double>(tests::below(generator, hierarchy::kLatticeEdge));
    const double isovalue = 0.25;
    std::array<std::array<std::uint16_t, 2>, CrossingBlock::kSize> ends{};
    for (std::size_t i = 0; i < CrossingBlock::kSize; ++i) {
        ends[i] = mesh.edges[tests::below(generator, mesh.edges.size())];
        given->inside.weights[i] = mesh.weights[ends[i][0]];
        given->outside.weights[i] = mesh.weights[ends[i][1]];
        const double scale = std::ldexp(1.0, static_cast<int>(tests::below(generator, 40)) - 20);
        given->inside.value[i] = static_cast<float>(isovalue + tests::uniform(generator, 0, scale));
        // some end where there is no data, and are inside by their value
        given->outside.value[i] =
            static_cast<float>(isovalue - tests::uniform(generator, i % 8 == 0 ? -1 : 0, 1));
        given->unitsPerSample[i] =
            std::ldexp(1.0, static_cast<int>(tests::below(generator, 14))) / mesh.denominator();
    }
    fields::test::onEveryInstructionSet([&](const std::string& name) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{7}, CrossingBlock::kSize}) {
            const auto block = std::make_unique<CrossingBlock>(*given);
            placeShares(*block, count, isovalue);
            placeCrossings(*block, count, corners);
            for (std::size_t i = 0; i < count; ++i) {
                const double in = double(given->inside.value[i]) - isovalue;
                const double out = double(given->outside.value[i]) - isovalue;
                const double t = clampedCrossing(out < 0 ? in / (in - out) : 2.0);
                ASSERT_EQ(block->t[i], t) << name << ", crossing " << i;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    std::array<double, 2> end{};
                    for (std::size_t e = 0; e < 2; ++e)
                        for (std::size_t k = 0; k < 4; ++k)
                            end[e] += mesh.weights[ends[i][e]][k] * corners[k][axis];
                    const double p = (end[0] + t * (end[1] - end[0])) * given->unitsPerSample[i];
                    ASSERT_EQ(block->position[axis][i], std::floor(p) + (p - std::floor(p) >= 0.5))
                        << name << ", crossing " << i;
                }
            }
        }
    });
}

/// A grid's corner is that of its hexahedron: what finds configurations goes by it.
TEST(VolumeMesh, hasTheVerticesOfItsBlocksWhereHexahedraSay)
{
    for (const int n : {1, 2, 4, 8, 16}) {
        const VolumeMesh& mesh = VolumeMesh::ofSize(n);
        const auto stride = static_cast<std::size_t>(n) + 1;
        const std::size_t perBlock = mesh.hexahedra.size() / 4;
        for (std::size_t i = 0; i < mesh.hexahedra.size(); ++i)
            for (std::size_t m = 0; m < 8; ++m) {
                const std::size_t at = mesh.hexahedra[i].place + (m & 1U) +
                                       stride * ((m >> 1U & 1U) + stride * (m >> 2U));
                ASSERT_EQ(mesh.block[i / perBlock].at(at), mesh.hexahedra[i].vertex[m]);
            }
    }
}

} // namespace
} // namespace isofront::extractor

#include "VertexKernel.h"

#include "fields/FieldChecks.h"
#include "support/Random.h"

#include <isofront/extractor/CellMesh.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

namespace isofront::surface {
namespace {

TEST(VertexKernel, movesAsOneByOneOnEveryInstructionSet)
{
    hierarchy::Domain domain;
    domain.origin = {-17.3, 1e4, 0.1};
    domain.edge = 256;
    domain.worldFromField.linear = glm::dmat3(-2, 0.1, 0, 0.7, 0.3, 3, 0.2, 1.5, 0.9);
    domain.worldFromField.translation = {100, -50, 7.7};
    const glm::dmat3 normalMatrix = domain.worldFromField.normalMatrix();
    auto generator = tests::random(3);
    VertexBlock block;
    std::array<hierarchy::GridPoint, VertexBlock::kSize> grid{};
    std::array<std::array<std::int16_t, 2>, VertexBlock::kSize> codes{};
    for (std::size_t i = 0; i < VertexBlock::kSize; ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            grid[i][axis] = static_cast<std::int64_t>(
                tests::below(generator, (std::size_t{1} << hierarchy::kGridBits) + 1));
            block.grid[axis][i] = static_cast<double>(grid[i][axis]);
        }
        for (std::int16_t& code : codes[i]) // corners and creases of the octahedron among them
            code = static_cast<std::int16_t>(
                i % 4 == 0 ? 32767 * (static_cast<int>(tests::below(generator, 3)) - 1)
                           : static_cast<int>(tests::below(generator, 65535)) - 32767);
        block.normal[i] = static_cast<std::uint16_t>(codes[i][0]) |
                          std::uint32_t{static_cast<std::uint16_t>(codes[i][1])} << 16U;
    }
    fields::test::onEveryInstructionSet([&](const std::string& name) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{13}, VertexBlock::kSize}) {
            std::array<glm::dvec3, VertexBlock::kSize> positions{};
            std::array<glm::vec3, VertexBlock::kSize> normals{};
            placeInWorld(block, count, domain, normalMatrix, positions.data(), normals.data());
            for (std::size_t i = 0; i < count; ++i) {
                ASSERT_EQ(positions[i], domain.worldFromGrid(grid[i])) << name << ", vertex " << i;
                const glm::vec3 normal(
                    glm::normalize(normalMatrix * extractor::fromOctahedral(codes[i])));
                ASSERT_EQ(normals[i], normal) << name << ", vertex " << i;
            }
            if (count < VertexBlock::kSize) {
                ASSERT_EQ(positions[count], glm::dvec3(0.0)) << "written beyond the end";
                ASSERT_EQ(normals[count], glm::vec3(0.0F)) << "written beyond the end";
            }
        }
    });
}

} // namespace
} // namespace isofront::surface

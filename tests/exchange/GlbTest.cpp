#include "MeshFormats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isofront::exchange::test {

TEST(Glb, translatesByWhatAFloatHoldsAndStaysNearTheCentre)
{
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_real_distribution<double> exponent(-20, 30);
    for (int i = 0; i < 100'000; ++i) {
        const glm::dvec3 centre =
            std::exp2(exponent(random)) * glm::dvec3(unit(random), unit(random), unit(random));
        const double extent = std::exp2(exponent(random));
        const core::Box bounds{centre - glm::dvec3(extent / 2), centre + glm::dvec3(extent / 2)};
        const glm::dvec3 translation = glbTranslation(bounds);
        ASSERT_EQ(glm::dvec3(glm::vec3(translation)), translation);
        const double furthest =
            std::max({std::abs(centre.x), std::abs(centre.y), std::abs(centre.z)});
        const double allowed = std::max(extent / 16, std::ldexp(furthest, -23)) * 1.0001;
        for (std::size_t axis = 0; axis < 3; ++axis)
            ASSERT_LE(std::abs(translation[axis] - centre[axis]), allowed)
                << "centre " << centre[axis] << ", extent " << extent;
    }
}

TEST(Glb, translatesAPointWithoutExtent)
{
    EXPECT_EQ(glbTranslation({glm::dvec3(0), glm::dvec3(0)}), glm::dvec3(0));
    EXPECT_EQ(glbTranslation({glm::dvec3(3), glm::dvec3(3)}), glm::dvec3(3));
}

TEST(Glb, countsTheBytesOfItsBinaryPart)
{
    EXPECT_EQ(glbBinaryBytes(3, 1, true), 72U + 8U) << "three short indices, filled up to a word";
    EXPECT_EQ(glbBinaryBytes(3, 1, false), 36U + 8U);
    EXPECT_EQ(glbBinaryBytes(65535, 2, false), 65535U * 12 + 12) << "the last with short indices";
    EXPECT_EQ(glbBinaryBytes(65536, 2, false), 65536U * 12 + 24);
    EXPECT_EQ(glbBinaryBytes(1U << 31U, 1ULL << 32U, true), (24ULL << 31U) + (12ULL << 32U))
        << "past 32 bits";
}

} // namespace isofront::exchange::test

#include "Culling.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace isofront::render {
namespace {

glm::dvec3 randomPoint(std::mt19937& random, double low, double high)
{
    std::uniform_real_distribution<double> range(low, high);
    const double x = range(random);
    const double y = range(random);
    return {x, y, range(random)};
}

StoredCell cellBetween(const hierarchy::GridPoint& low, const hierarchy::GridPoint& high)
{
    StoredCell cell;
    cell.low = low;
    cell.high = high;
    cell.indexCount = 3;
    return cell;
}

/// Whether a world point projects into the picture, by the textbook.
bool isInPicture(const hierarchy::View& view, const glm::dvec3& world)
{
    const glm::dvec3 forward = glm::normalize(view.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, view.up));
    const glm::dvec3 up = glm::cross(right, forward);
    const glm::dvec3 d = world - view.eye;
    const double depth = glm::dot(d, forward);
    const double scale = std::tan(0.5 * view.verticalFieldOfView) * depth;
    return depth > 0 && std::abs(glm::dot(d, up)) < scale &&
           std::abs(glm::dot(d, right)) < scale * view.width / view.height;
}

TEST(Culling, neverDropsACellWithAPointInThePicture)
{
    std::mt19937 random(3);
    hierarchy::Domain domain{.origin = {-3, 5, 70}, .edge = 40};
    domain.worldFromField.linear = glm::dmat3(2, 0.3, 0, -0.2, 1.5, 0.1, 0, 0.4, -0.7);
    std::size_t seen = 0;
    std::size_t culled = 0;
    for (int round = 0; round < 40; ++round) {
        hierarchy::View view;
        view.eye = domain.worldFromField.point(randomPoint(random, -20, 90));
        view.forward = randomPoint(random, -1, 1);
        view.verticalFieldOfView = 0.2 + 0.05 * round;
        std::vector<StoredCell> cells;
        std::vector<bool> needed;
        for (int i = 0; i < 500; ++i) {
            const auto corner = hierarchy::GridPoint(randomPoint(random, 0, 6e13));
            const auto size = hierarchy::GridPoint(randomPoint(random, 0, 9e12));
            cells.push_back(cellBetween(corner, corner + size));
            bool inPicture = false;
            for (int sample = 0; sample < 20; ++sample) {
                const glm::dvec3 t = randomPoint(random, 0, 1);
                const auto inside = corner + hierarchy::GridPoint(glm::dvec3(size) * t);
                inPicture = inPicture || isInPicture(view, domain.worldFromGrid(inside));
            }
            needed.push_back(inPicture);
        }
        std::vector<std::uint32_t> order;
        visibleInto(cells, gridView(domain, view), order);
        std::vector<bool> kept(cells.size(), false);
        for (const std::uint32_t index : order)
            kept[index] = true;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            ASSERT_TRUE(kept[i] || !needed[i]);
            seen += needed[i] ? 1U : 0U;
            culled += kept[i] ? 0U : 1U;
        }
    }
    EXPECT_GT(seen, 500U);
    EXPECT_GT(culled, 5'000U);
}

TEST(Culling, putsTheNearestFirstAndLeavesOutWhatHasNoTriangles)
{
    const hierarchy::Domain domain{.edge = 1024};
    std::vector<StoredCell> cells;
    for (const std::int64_t distance : {900, 100, 500, 300}) {
        const hierarchy::GridPoint at(
            std::int64_t{500} << 36,
            (distance + 50) * (std::int64_t{1} << 36),
            std::int64_t{500} << 36);
        cells.push_back(cellBetween(at, at + std::int64_t{1000}));
    }
    cells[2].indexCount = 0;
    hierarchy::View view;
    view.eye = {500, 50, 500};
    std::vector<std::uint32_t> order{7, 7, 7};
    visibleInto(cells, gridView(domain, view), order);
    EXPECT_EQ(order, (std::vector<std::uint32_t>{1, 3, 0}));
}

} // namespace
} // namespace isofront::render

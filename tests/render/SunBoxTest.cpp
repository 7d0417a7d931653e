#include "SunBox.h"

#include "FrameData.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace isofront::render {
namespace {

constexpr int kTexels = 1024;

TEST(SunBox, isLeftOutByNightInTheStudioAndOnRequest)
{
    const hierarchy::Domain domain{.edge = 4096};
    EXPECT_TRUE(sunBox(domain, {}, {}, kTexels).casts);
    Scene night;
    night.sunDirection = {1, 0, -0.1};
    EXPECT_FALSE(sunBox(domain, {}, night, kTexels).casts);
    EXPECT_FALSE(sunBox(domain, {}, {.look = Look::studio}, kTexels).casts);
    EXPECT_FALSE(sunBox(domain, {}, {.shadowDistance = 0}, kTexels).casts);
}

TEST(SunBox, movesInWholeTexelsOfTheWorld)
{
    const hierarchy::Domain domain{.origin = {-100, 50, 7}, .edge = 4096};
    Scene scene;
    scene.shadowDistance = 500;
    hierarchy::View view;
    for (int step = 0; step < 50; ++step) {
        view.eye = {100 + 3.7 * step, 200 - 1.3 * step, 90 + 0.1 * step};
        const SunBox box = sunBox(domain, view, scene, kTexels);
        const double texel = 2.0 * box.halfWidth / kTexels;
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const double eye = glm::dot(box.axes[axis], view.eye - domain.origin);
            const double steps = (eye + box.centre[axis]) / texel;
            ASSERT_NEAR(steps, std::round(steps), 1e-6);
        }
        const double ahead = glm::dot(box.axes[0], glm::normalize(view.forward)) * 250;
        ASSERT_NEAR(box.centre[0], ahead, texel);
    }
}

TEST(SunBox, staysInItsPlaceWhenTheEyeMoves)
{
    const hierarchy::Domain domain{.edge = 4096};
    hierarchy::View before;
    before.eye = {1000, 1000, 500};
    hierarchy::View after = before;
    after.eye = {1040, 1100, 480};
    const SunBox box = sunBox(domain, before, {}, kTexels);
    const SunBox moved = box.seenFrom(domain, domain.gridFromWorld(after.eye));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(
            glm::dot(box.axes[axis], before.eye) + box.centre[axis],
            glm::dot(box.axes[axis], after.eye) + moved.centre[axis],
            1e-6);
    }
    EXPECT_TRUE(moved.isNear(sunBox(domain, after, {}, kTexels)));
    after.eye.x += 3000;
    EXPECT_FALSE(box.seenFrom(domain, domain.gridFromWorld(after.eye))
                     .isNear(sunBox(domain, after, {}, kTexels)));
}

} // namespace
} // namespace isofront::render

#include "Atmosphere.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isofront::render {
namespace {

TEST(Atmosphere, reddensAndDimsTheSunTowardsTheHorizon)
{
    double last = 0;
    for (const double sine : {0.03, 0.1, 0.3, 0.6, 1.0}) {
        const Daylight day = daylight(sine, 1.0);
        EXPECT_GT(day.sunLight.x, last) << "brighter the higher";
        last = day.sunLight.x;
        EXPECT_GT(day.sunLight.x, day.sunLight.y);
        EXPECT_GT(day.sunLight.y, day.sunLight.z);
    }
    const double lowRatio = daylight(0.05, 1.0).sunLight.z / daylight(0.05, 1.0).sunLight.x;
    const double highRatio = daylight(0.9, 1.0).sunLight.z / daylight(0.9, 1.0).sunLight.x;
    EXPECT_LT(lowRatio, 0.5 * highRatio);
}

TEST(Atmosphere, makesTheSkyBlueByDayAndDarkAtNight)
{
    const Daylight noon = daylight(0.8, 0.5);
    EXPECT_GT(noon.skyLight.z, 1.5 * noon.skyLight.x);
    const Daylight night = daylight(-0.5, 0.5);
    EXPECT_EQ(night.sunLight, glm::dvec3(0.0));
    EXPECT_LT(night.skyLight.z, 0.05 * noon.skyLight.z);
    EXPECT_GT(night.skyLight.z, 0.0);
}

TEST(Atmosphere, staysFiniteForAnySunAndHaze)
{
    for (double sine = -1.0; sine <= 1.0; sine += 0.01) {
        for (const double haze : {0.0, 1.0, 1000.0}) {
            const Daylight day = daylight(sine, haze);
            for (const glm::dvec3& light : {day.sunLight, day.skyLight, day.groundLight}) {
                ASSERT_TRUE(std::isfinite(light.x + light.y + light.z)) << sine << " " << haze;
                ASSERT_GE(light.x, 0.0);
            }
        }
    }
}

} // namespace
} // namespace isofront::render

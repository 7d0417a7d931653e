#include "../FieldChecks.h"
#include "support/Random.h"

#include <isofront/fields/Combine.h>
#include <isofront/fields/Graph.h>
#include <isofront/fields/Shapes.h>
#include <isofront/fields/Terrain.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace isofront::fields::graph {
namespace {

using namespace test;

/// On a grid noise is mixed in another order: what differs is rounding, and what graphs make of it.
/// @param amplitude  of the noise, where it is more than what is sampled tells
void expectTheSameOnAGrid(
    const Field& field, const SampleGrid& grid, const std::string& what, double amplitude = 1)
{
    const std::vector<float> points = valuesOf(field, pointsOf(grid).batch());
    double most = amplitude;
    for (const float value : points)
        most = std::max(most, std::abs(double(value)));
    EXPECT_LT(worstDifference(gridOf(field, grid), points), 1e-5 * most) << what;
}

struct Shared {
    const char* name;
    Node node;
};

/// One of each that shares work over a grid, and of those that can't.
std::vector<Shared> sharedNoises()
{
    const OctaveSettings sum{.wavelength = 31, .octaves = 6, .amplitude = 3, .seed = 1};
    OctaveSettings ridged = sum;
    ridged.fractal = FractalKind::ridged;
    OctaveSettings billow = sum;
    billow.fractal = FractalKind::billow;
    billow.kind = NoiseKind::value;
    OctaveSettings cells = sum;
    cells.kind = NoiseKind::cellular;
    OctaveSettings strata = sum;
    strata.stretch = 7;
    OctaveSettings flat = sum;
    flat.plane = true;
    const std::vector<OctaveSettings> layers{
        {.wavelength = 17, .octaves = 4, .amplitude = 4, .seed = 8},
        {.kind = NoiseKind::value, .wavelength = 9, .octaves = 2, .amplitude = 2, .seed = 9},
        {.kind = NoiseKind::simplex, .wavelength = 7, .octaves = 2, .amplitude = 1, .seed = 10}};
    const Node z = position(Axis::z);
    const Node plain = noise(sum);
    return {
        {"sum", plain},
        {"ridged", noise(ridged)},
        {"billow", noise(billow)},
        {"cells", noise(cells)},
        {"strata", noise(strata)},
        {"plane", noise(flat) - z},
        {"placed", placed(plain, 3.3, -7.1, 1000.25, 1.7)},
        {"placedTwice", placed(placed(noise(flat) + plain, 1e3, 2, 3, 0.37), -20, 5, 9, 2.9)},
        {"warped", warp(plain, noise(flat), 0.5 * noise(ridged), 2.0, 1.2)},
        {"detail", detail(0.8 * (noise(flat) - z), layers, 0.75, 1)},
        {"detailBySteps", detail(noise(flat) - z, layers, smoothStep(plain, -0.5, 0.5))},
        // Noise that is asked for in some groups of a row only, and in others a slice later.
        {"leftOut", min(max(noise(flat), z * 0.3), smoothStep(noise(sum), 0, 1) * noise(strata))},
        {"planeLeftOut", smoothStep(plain, 0.2, 0.9) * noise(flat) * 9.0 - z},
        {"tunnels", tunnels(noise(flat) - z, {.wavelength = 23, .radius = 4, .depth = 20})},
        {"source", source(sphere(glm::dvec3(0), 20)) + plain}};
}

TEST(GraphGrid, givesWhatSinglePointsGive)
{
    for (const Shared& shared : sharedNoises()) {
        const std::shared_ptr<const Field> field = graphField(shared.node, {.seed = 3});
        for (const double radius : {0.0, 0.8}) {
            for (const double spacing : {0.13, 0.77, 11.0})
                expectTheSameOnAGrid(
                    *field,
                    {.origin = {0.3, -5.1, 7.7},
                     .spacing = spacing,
                     .first = {-150, 3, -4},
                     .count = {291, tests::trials(19), tests::trials(9)},
                     .radius = radius},
                    shared.name + std::to_string(spacing));
            expectTheSameOnAGrid(
                *field,
                {.origin = {1e7, -1e7, 3e6}, .spacing = 0.5, .count = {67, 5, 5}, .radius = radius},
                shared.name + std::string(" far"));
        }
    }
}

TEST(GraphGrid, givesWhatSinglePointsGiveOfEveryTerrain)
{
    for (const TerrainPreset& preset : terrainPresets()) {
        const std::shared_ptr<const Field> field = terrain(preset, 7, 1.0);
        const double ground = surfaceHeight(*field, preset.box, preset.start.x, preset.start.y);
        for (const double spacing : {0.4, 9.0, 120.0})
            expectTheSameOnAGrid(
                *field,
                {.origin = {preset.start.x, preset.start.y, ground},
                 .spacing = spacing,
                 .first = {-33, -9, -6},
                 .count = {66, 18, 12},
                 .radius = 0.5 * spacing},
                preset.name + std::to_string(spacing),
                200);
    }
}

TEST(GraphGrid, givesWhatSinglePointsGiveOfSolidsMadeOfSolids)
{
    const std::shared_ptr<const Field> ground =
        graphField(noise({.wavelength = 31, .octaves = 4, .amplitude = 9}) - position(Axis::z));
    const std::shared_ptr<const Field> ball = sphere(glm::dvec3(20, 3, 0), 9);
    for (const std::shared_ptr<const Field>& field :
         {unionOf(ground, ball), intersectionOf(ground, ball), differenceOf(ground, ball)})
        expectTheSameOnAGrid(*field, {.first = {0, -5, -9}, .count = {50, 16, 18}}, "combined");
}

TEST(GraphGrid, givesTheSameBitsOnEveryInstructionSet)
{
    const SampleGrid grid{
        .origin = {0.3, -5, 7.7}, .spacing = 0.77, .first = {-20, 3, -9}, .count = {83, 17, 7}};
    for (const Shared& shared : sharedNoises()) {
        const std::shared_ptr<const Field> field = graphField(shared.node, {.seed = 3});
        const std::vector<float> values = gridOf(*field, grid);
        onEveryInstructionSet([&](const std::string& name) {
            EXPECT_EQ(differingBits(gridOf(*field, grid), values), 0U) << shared.name << name;
        });
    }
}

TEST(GraphGrid, takesGridsOfAnySize)
{
    const std::shared_ptr<const Field> field =
        graphField(noise({.wavelength = 5, .octaves = 3}) - position(Axis::z));
    for (const glm::i64vec3 count :
         {glm::i64vec3(0, 5, 5),
          glm::i64vec3(5, 0, 5),
          glm::i64vec3(5, 5, 0),
          glm::i64vec3(1, 1, 1),
          glm::i64vec3(1, 900, 1),
          glm::i64vec3(1, 2, 900),
          glm::i64vec3(700, 1, 1),
          glm::i64vec3(257, 17, 1)})
        expectTheSameOnAGrid(*field, {.spacing = 0.3, .count = count}, std::to_string(count.x));
    // Steps that doubles can't tell apart.
    expectTheSameOnAGrid(
        *field, {.origin = {1e12, 1e12, 1e12}, .spacing = 1e-10, .count = {50, 12, 2}}, "far");
}

} // namespace
} // namespace isofront::fields::graph

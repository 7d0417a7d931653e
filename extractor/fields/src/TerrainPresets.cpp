#include "isofront/fields/Terrain.h"

namespace isofront::fields {

namespace {

constexpr double kEdge = 16384.0; // [m]

core::Box centredCube()
{
    return {glm::dvec3(-0.5 * kEdge), glm::dvec3(0.5 * kEdge)};
}

TerrainPreset alpine()
{
    TerrainPreset preset;
    preset.name = "alpine";
    preset.description = "Eroded mountains over valley floors, with crags, arches and caves";
    preset.form = TerrainForm::mountains;
    preset.box = centredCube();
    preset.valuePerMetre = 0.7;
    preset.rounding = 8;
    preset.warp = {.wavelength = 2400, .octaves = 2, .amplitude = 420, .gain = 0.4};
    preset.mountains = {
        .ridges = {.wavelength = 5600, .octaves = 8, .amplitude = 1550, .gain = 0.48},
        .hills = {.wavelength = 1900, .octaves = 2, .amplitude = 110, .gain = 0.4},
        .gain = 4,
        .base = 620,
        .floor = 100};
    preset.cragLeast = 0.15;
    preset.crags = {
        {.wavelength = 430, .octaves = 4, .amplitude = 75, .gain = 0.5},
        {.wavelength = 700, .octaves = 2, .amplitude = 16, .gain = 0.5, .stretch = 9}};
    preset.tunnels = {
        {.wavelength = 680, .radius = 25, .radiusVariation = 0.8, .depth = 300},
        {.wavelength = 1150, .radius = 46, .radiusVariation = 0.6, .depth = 160}};
    preset.fine = {.wavelength = 27, .octaves = 6, .amplitude = 2.2, .gain = 0.5};
    preset.start = {2000, -2500};
    preset.lookAt = {-1000, 2000};
    preset.clearance = 300;
    return preset;
}

TerrainPreset canyon()
{
    TerrainPreset preset;
    preset.name = "canyon";
    preset.description = "A layered plateau cut by winding canyons, with ledges, arches and caves";
    preset.form = TerrainForm::canyon;
    preset.box = centredCube();
    preset.valuePerMetre = 0.5;
    preset.rounding = 6;
    preset.warp = {.wavelength = 2100, .octaves = 3, .amplitude = 380, .gain = 0.45};
    preset.mountains.hills = {.wavelength = 3800, .octaves = 5, .amplitude = 130, .gain = 0.42};
    preset.canyon = {
        .river = {.wavelength = 6400, .octaves = 3, .amplitude = 1, .gain = 0.35},
        .sideRiver = {.wavelength = 2300, .octaves = 3, .amplitude = 1, .gain = 0.4},
        .riverMetres = 4600,
        .sideMetres = 1700,
        .floor = -320,
        .depth = 1050,
        .innerBegin = 90,
        .innerEnd = 300,
        .innerShare = 0.5F,
        .outerBegin = 620,
        .outerEnd = 860,
        .sideBegin = 40,
        .sideEnd = 300,
        .sideShare = 0.62F};
    preset.cragLeast = 0.4;
    preset.crags = {
        {.wavelength = 330, .octaves = 3, .amplitude = 34, .gain = 0.5},
        {.wavelength = 1400, .octaves = 3, .amplitude = 26, .gain = 0.55, .stretch = 16}};
    preset.tunnels = {
        {.wavelength = 620, .radius = 20, .radiusVariation = 0.8, .depth = 200},
        {.wavelength = 1250, .radius = 46, .radiusVariation = 0.5, .depth = 130}};
    preset.fine = {.wavelength = 22, .octaves = 6, .amplitude = 1.3, .gain = 0.5, .stretch = 1.6};
    preset.start = {0, -6000};
    preset.lookAt = {0, 0};
    preset.clearance = 300;
    return preset;
}

TerrainPreset islands()
{
    TerrainPreset preset;
    preset.name = "islands";
    preset.description = "Islands that float at three heights, with hanging cliffs and caves";
    preset.form = TerrainForm::islands;
    preset.box = centredCube();
    preset.valuePerMetre = 0.7;
    preset.rounding = 8;
    preset.warp = {.wavelength = 1500, .octaves = 2, .amplitude = 200, .gain = 0.45};
    preset.mountains.hills = {.wavelength = 700, .octaves = 4, .amplitude = 45, .gain = 0.5};
    preset.islands = {
        {.shape = {.wavelength = 4200, .octaves = 4, .amplitude = 1, .gain = 0.45},
         .elevation = {.wavelength = 7000, .octaves = 2, .amplitude = 420},
         .altitude = -300,
         .threshold = 0.14,
         .top = 700,
         .bottom = 2300},
        {.shape = {.wavelength = 2900, .octaves = 4, .amplitude = 1, .gain = 0.45},
         .elevation = {.wavelength = 6000, .octaves = 2, .amplitude = 520},
         .altitude = 1100,
         .threshold = 0.24,
         .top = 500,
         .bottom = 1900},
        {.shape = {.wavelength = 2100, .octaves = 4, .amplitude = 1, .gain = 0.45},
         .elevation = {.wavelength = 5000, .octaves = 2, .amplitude = 520},
         .altitude = 2300,
         .threshold = 0.3,
         .top = 300,
         .bottom = 1500}};
    preset.cragLeast = 0.4;
    preset.crags = {
        {.wavelength = 310, .octaves = 4, .amplitude = 60, .gain = 0.5},
        {.wavelength = 600, .octaves = 2, .amplitude = 12, .gain = 0.5, .stretch = 8}};
    preset.tunnels = {
        {.wavelength = 520, .radius = 22, .radiusVariation = 0.8, .depth = 220},
        {.wavelength = 800, .radius = 40, .radiusVariation = 0.6, .depth = 140}};
    preset.fine = {.wavelength = 25, .octaves = 6, .amplitude = 1.9, .gain = 0.5};
    preset.start = {-2400, -6000};
    preset.lookAt = {0, 0};
    preset.clearance = 500;
    return preset;
}

} // namespace

const std::vector<TerrainPreset>& terrainPresets()
{
    static const std::vector<TerrainPreset> presets{alpine(), canyon(), islands()};
    return presets;
}

} // namespace isofront::fields

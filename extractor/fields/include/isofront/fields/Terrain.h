#pragma once

#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>

#include <glm/vec2.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isofront::fields {

/// What the land is, before crags, caves and detail.
enum class TerrainForm {
    mountains, ///< eroded ridges over valley floors
    canyon,    ///< a plateau cut by rivers
    islands,   ///< islands that float
};

/// Octaves of noise; lengths in metres.
struct TerrainOctaves {
    double wavelength = 1000; ///< of the first octave [m]
    int octaves = 0;
    double amplitude = 0;     ///< of the first octave [m], unless said otherwise
    double lacunarity = 2.03; ///< frequency of an octave over that of the one before
    double gain = 0.5;        ///< amplitude of an octave over that of the one before
    double stretch = 1;       ///< how much shorter the wavelength is along z: above 1 makes strata
};

struct RidgeSettings {
    TerrainOctaves ridges;
    TerrainOctaves hills; ///< on the valley floors
    double gain = 2;      ///< how soon ridges carry further ridges: higher is rougher
    double base = 0;      ///< mean height of the ridges [m]
    double floor = 0;     ///< of the valleys [m]
};

struct CanyonSettings {
    TerrainOctaves river; ///< amplitude without unit
    TerrainOctaves sideRiver;
    float riverMetres = 3000; ///< distance from a river over its noise's value [m]
    float sideMetres = 1200;  ///< the same for the side canyons [m]
    float floor = 0;          ///< [m]
    float depth = 800;        ///< from the rim to the floor [m]
    float innerBegin = 60;    ///< distance from the river where the lower wall begins [m]
    float innerEnd = 200;     ///< ... and ends
    float innerShare = 0.5F;  ///< of the depth, up to the terrace
    float outerBegin = 600;   ///< distance where the upper wall begins [m]
    float outerEnd = 760;     ///< ... and ends
    float sideBegin = 30;     ///< the same for the side canyons
    float sideEnd = 260;
    float sideShare = 0.6F; ///< of the depth that a side canyon cuts away at most
};

struct IslandLevel {
    TerrainOctaves shape;     ///< amplitude without unit
    TerrainOctaves elevation; ///< [m]
    double altitude = 0;      ///< [m]
    double threshold = 0.1;   ///< of the shape's noise: higher leaves less land
    double top = 300;         ///< height of the land over the shape's noise [m]
    double bottom = 900;      ///< depth of the rock over the shape's noise [m]
};

struct TunnelSettings {
    double wavelength = 700;      ///< how far a tunnel runs before it turns [m]
    double radius = 20;           ///< [m]
    double radiusVariation = 0.6; ///< of the radius, relative: tunnels widen to halls and end
    double depth = 300;           ///< deepest below the surface [m]
    double stretch = 1;           ///< above 1: flatter tunnels
};

/// A kind of terrain. Metres, z up; solid is where the value is at or above 0, and the value is
/// roughly the distance to the surface.
struct TerrainPreset {
    std::string name;
    std::string description;
    TerrainForm form = TerrainForm::mountains;
    core::Box box;            ///< the domain it is made for: a cube
    double valuePerMetre = 1; ///< of height: brings the gradient near 1 on slopes
    double rounding = 10;     ///< of joins between parts [m]
    TerrainOctaves warp;      ///< sideways displacement, differing with height [m]
    RidgeSettings mountains;
    CanyonSettings canyon;
    std::vector<IslandLevel> islands;
    double cragLeast = 0.3; ///< crags differ from region to region, from this share to all
    std::vector<TerrainOctaves> crags; ///< overhangs and strata, before the tunnels are cut
    std::vector<TunnelSettings> tunnels;
    TerrainOctaves fine;    ///< after the tunnels are cut
    glm::dvec2 start{0};    ///< where to begin a flight [m]
    glm::dvec2 lookAt{0};   ///< what to look at first [m]
    double clearance = 120; ///< of the flight above the ground [m]
};

const std::vector<TerrainPreset>& terrainPresets();

struct TerrainSettings {
    std::string preset = "alpine";
    std::uint64_t seed = 1;
    double filterStrength = 1; ///< kappa, see NoiseSettings
};

/// A preset by name; an unknown one is a usage error that lists those there are.
core::Result<TerrainPreset> terrainPreset(const std::string& name);

/// A terrain by the name of its preset.
core::Result<std::shared_ptr<const Field>> makeTerrain(const TerrainSettings& settings);

/// A terrain of one's own.
std::shared_ptr<const Field>
terrain(const TerrainPreset& preset, std::uint64_t seed, double filterStrength);

/// A terrain by the name of a preset that exists (asserted; without assertions null otherwise). For
/// names that a user gives, see makeTerrain.
std::shared_ptr<const Field> terrain(const TerrainSettings& settings);

/// The height of the highest solid point over (x, y), to 0.1 m; the box's floor if there is none.
/// What is thinner than `step` [m] may be missed.
double
surfaceHeight(const Field& field, const core::Box& box, double x, double y, double step = 4.0);

} // namespace isofront::fields

#pragma once

#include "Octaves.h"
#include "isofront/fields/Field.h"
#include "isofront/fields/Terrain.h"

#include <vector>

namespace isofront::fields {

/// Octaves of detail, and what is still to come.
struct DetailOctave {
    SpaceOctave noise;
    /// The most by which this octave and all later ones can move a value.
    float remaining;
};

/// Winding tunnels: where two sheets of noise, each zero on winding surfaces, are both zero.
struct TunnelProgram {
    SpaceOctave first;
    SpaceOctave second;
    SpaceOctave width;     ///< varies the radius from place to place
    float metresPerUnit;   ///< distance from a sheet over the noise's value
    float radius;          ///< [m]
    float radiusVariation; ///< of the radius, relative
    float depth;           ///< deepest below the surface [m]
    float closingCycles;   ///< filter frequency by which a tunnel closes
};

/// One level of floating islands.
struct IslandProgram {
    std::vector<PlaneOctave> shape;
    std::vector<PlaneOctave> elevation;
    float altitude;  ///< [m]
    float threshold; ///< of the shape's noise: above it there is land
    float top;       ///< height of the land above its rim over the shape's noise [m]
    float bottom;    ///< depth of the rock below the rim over the shape's noise [m]
};

/// A terrain with its octaves drawn: everything that the kernel needs.
struct TerrainProgram {
    TerrainForm form = TerrainForm::mountains;
    float valuePerMetre = 1;
    float rounding = 1; ///< width of the rounded joins [m]

    std::vector<SpaceOctave> warpX;
    std::vector<SpaceOctave> warpY;

    std::vector<PlaneOctave> ridges;
    std::vector<PlaneOctave> hills;
    float ridgeScale = 1; ///< noise to the range [-1, 1]
    float ridgeMean = 0;  ///< of the ridge's signal
    float ridgeGain = 1;
    float base = 0;  ///< [m]
    float floor = 0; ///< of the valleys [m]

    std::vector<PlaneOctave> river;
    std::vector<PlaneOctave> sideRiver;
    CanyonSettings canyon;

    std::vector<IslandProgram> islands;

    PlaneOctave cragMask{};
    float cragLeast = 0; ///< factor on the crags where the mask is lowest
    std::vector<DetailOctave> crags;
    std::vector<TunnelProgram> tunnels;
    std::vector<DetailOctave> fine;
};

void sampleTerrain(
    const TerrainProgram& program, const SampleBatch& batch, std::span<float> values);
void gradientTerrain(
    const TerrainProgram& program, const SampleBatch& batch, const GradientSpans& gradients);
core::Interval
boundTerrain(const TerrainProgram& program, const core::Box& box, const core::Interval& radius);

} // namespace isofront::fields

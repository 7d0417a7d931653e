// What the shaders know of a frame. Every member is a vector of four, so that the layouts of C++
// and of GLSL's std140 agree.
#ifndef ISOFRONT_SHARED_FRAME_H
#define ISOFRONT_SHARED_FRAME_H

#include "shared/types.h"

ISOFRONT_SHARED_BEGIN

// Samples of a pixel, at most.
const uint kMostSamples = 8u;

struct Frame {
    // Rows that take a difference of grid points to clip x, y and w [world / grid unit]. In the w
    // of the first: clip z, the distance of the near plane [world].
    vec4 clipX;
    vec4 clipY;
    vec4 clipW;
    // Columns that take a normal from field space to the world, up to its length.
    vec4 worldFromNormal[3];
    // The eye [grid units], low and high words.
    uvec4 eyeLow;
    uvec4 eyeHigh;
    // World-space ray through a pixel at (x, y) in [-1, 1], y down: forward + x right + y down. Its
    // component along the forward direction is 1. In the w of forward: radians a pixel.
    vec4 rayForward;
    vec4 rayRight;
    vec4 rayDown;
    // Width and height [px], and their inverses.
    vec4 picture;
    // The eye's position [m], modulo the period of the noise; in w its height above the base.
    vec4 eyePhase;
    // Unit, up from the ground; in w metres per world unit.
    vec4 up;
    // Unit, to the sun; in w the exposure.
    vec4 sunDirection;
    // Light of the sun that reaches the ground [irradiance].
    vec4 sunLight;
    // Light of the sky from above, and light that comes back from the ground [irradiance / pi].
    vec4 skyLight;
    vec4 groundLight;
    // Scattering of air and of haze [1 / m]; in w of the first the height over which they thin to
    // 1/e [m], of the second how much denser than the sky's they are between eye and ground.
    vec4 airScattering;
    vec4 hazeScattering;
    // Background colour, linear and not tone-mapped; in w 1 if it is to be used.
    vec4 backdrop;
    // Terrain: heights above the base [m]: where grass ends, where snow begins; thickness of the
    // rock's layers [m]; wavelength of the finest detail [m].
    vec4 heights;
    // Rows that take a difference of grid points, or a vector from the eye [world], to the shadow
    // map: x and y in [-1, 1], z in [0, 1] and growing towards the sun. In their w: what to add.
    vec4 shadowFromGrid[3];
    vec4 shadowFromWorld[3];
    // Texels along a side of the shadow map, width of a texel [world], 1 if there are shadows,
    // metres in a unit of its depth.
    vec4 shadowSize;
    // The former picture's shadow map, of the same axes and size: what to add in place of
    // shadowFromWorld's w; in w 1 if there is one.
    vec4 formerShadow;
    // Albedos, linear. Terrain: rock, a second rock, grass, scree, snow. Studio: surface, caps.
    vec4 colours[5];
    // In x the weight of the present picture; see shared/transition.h.
    vec4 transition;
    // How many samples a pixel has, and how far off its middle one may lie along x and y [px].
    vec4 sampling;
    // Where they lie, from the pixel's middle, in x and y [px].
    vec4 samples[kMostSamples];
    // Where meshes and voxels share a picture, space is cut into blocks, each of which one of them
    // has. Rows that take a difference of grid points to a place among the blocks [blocks]; in
    // their w: what to add.
    vec4 blockFromGrid[3];
    // How many blocks there are along each axis; in w how many bits tell the voxels of level 0 in
    // one along an axis.
    uvec4 blockCount;
};

// Where a drawn cell lies: low corner [lattice units]; in w its exponent, and above its 8 bits the
// pictures that it is part of.
struct DrawnCell {
    uvec4 lowAndExponent;
};
const uint kExponentMask = 0xffu;
const uint kCellPicturesShift = 8u;

ISOFRONT_SHARED_END

#ifdef __cplusplus
#include <cstddef>

static_assert(offsetof(isofront::shared::Frame, worldFromNormal) == 3 * 16);
static_assert(offsetof(isofront::shared::Frame, eyeLow) == 6 * 16);
static_assert(offsetof(isofront::shared::Frame, rayForward) == 8 * 16);
static_assert(offsetof(isofront::shared::Frame, eyePhase) == 12 * 16);
static_assert(offsetof(isofront::shared::Frame, sunDirection) == 14 * 16);
static_assert(offsetof(isofront::shared::Frame, airScattering) == 18 * 16);
static_assert(offsetof(isofront::shared::Frame, colours) == 30 * 16);
static_assert(offsetof(isofront::shared::Frame, transition) == 35 * 16);
static_assert(offsetof(isofront::shared::Frame, blockFromGrid) == 45 * 16);
static_assert(offsetof(isofront::shared::Frame, blockCount) == 48 * 16);
static_assert(sizeof(isofront::shared::Frame) == 49 * 16);
static_assert(sizeof(isofront::shared::DrawnCell) == 16);
#endif

#endif

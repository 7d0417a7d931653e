// What voxelPattern.comp.glsl is told, and finds.
#ifndef ISOFRONT_SHARED_PATTERN_H
#define ISOFRONT_SHARED_PATTERN_H

#include "shared/types.h"

ISOFRONT_SHARED_BEGIN

const uint kPatternOfGroups = 0u; // the nearest voxel of each group's pixels
const uint kPatternOfAll = 1u;    // of all groups; one group
const uint kPatternPixels = 2u;   // how many pixels show it

struct PatternStep {
    uint stage;
    uint width; // of the picture [px]
    uint height;
    uint groups; // of the first stage, and the last
};

struct Pattern {
    uvec2 nearest; // inverted bits of its depth, then its name; all bits set if there is none
    uint pixels;
    uint voxelPixels; // that show any voxel
};

ISOFRONT_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(isofront::shared::PatternStep) == 16);
static_assert(sizeof(isofront::shared::Pattern) == 16);
#endif

#endif

// How a picture changes into the next one: not by mixing colours, but pixel by pixel. Each pixel
// shows either the former picture or the present one, by a fixed pattern. As each of the two is
// closed in itself, no pixel can show a hole, or both.
#ifndef ISOFRONT_SHARED_TRANSITION_H
#define ISOFRONT_SHARED_TRANSITION_H

#include "shared/types.h"

ISOFRONT_SHARED_BEGIN

// What a thing is part of, as bits.
const uint kInFormer = 1u;
const uint kInPresent = 2u;
const uint kInBoth = 3u;
// Beside them: a part of it may lie in blocks that others have, so each place has to be looked up.
const uint kLooksUp = 4u;

// From which weight on the pixel at column x and row y shows the present picture: in (0, 1), each
// of 64 equally spaced numbers once in a square of 8 x 8 pixels, neighbours as different as can be.
// Source: B. E. Bayer, "An optimum method for two-level rendition of continuous-tone pictures"
// (1973).
ISOFRONT_SHARED_FUNCTION float ditherThreshold(uint x, uint y)
{
    uint across = x ^ y;
    uint rank = 0u;
    for (uint bit = 0u; bit < 3u; ++bit)
        rank = (rank << 2u) | (((across >> bit) & 1u) << 1u) | ((y >> bit) & 1u);
    return (float(rank) + 0.5f) / 64.0f;
}

// Which of the two pictures a pixel shows.
// @param weight  of the present one: at 0 none of it is there, at 1 nothing else
ISOFRONT_SHARED_FUNCTION uint pictureAt(uint x, uint y, float weight)
{
    return ditherThreshold(x, y) < weight ? kInPresent : kInFormer;
}

ISOFRONT_SHARED_END

#endif

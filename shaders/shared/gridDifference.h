// The border contract: how far a vertex lies from the eye, taken in integers of the world grid and
// then turned to float in one way. Both copies of a border vertex are the same grid point, so both
// get the same bits, however differently their cells name it.
#ifndef ISOFRONT_SHARED_GRID_DIFFERENCE_H
#define ISOFRONT_SHARED_GRID_DIFFERENCE_H

#include "shared/types.h"

ISOFRONT_SHARED_BEGIN

/// One coordinate of vertex - eye, to float [grid units]; the relative error is below 2^-23.
///
/// @param low       of the cell's low corner [lattice units], at most 2^31
/// @param position  of the vertex above it [2^exponent grid units], at most 2^15
/// @param exponent  from 1 to 32
/// @param eyeLow, eyeHigh  the eye [grid units], the words of a signed number within +-2^62
///
/// 64-bit numbers are two words with a carry, since GPUs need not have 64-bit integers.
ISOFRONT_SHARED_FUNCTION float
gridDifference(uint low, uint position, uint exponent, uint eyeLow, uint eyeHigh)
{
    // A lattice unit is 2^15 grid units.
    uint cornerLow = low << 15u;
    uint cornerHigh = low >> 17u;
    // A shift by 32 is undefined; the right shift is by 0 to 31.
    uint offsetLow = exponent > 31u ? 0u : position << (exponent & 31u);
    uint offsetHigh = position >> (32u - exponent);

    uint sumLow = cornerLow + offsetLow;
    uint sumHigh = cornerHigh + offsetHigh + (sumLow < cornerLow ? 1u : 0u);
    uint lowWord = sumLow - eyeLow;
    uint highWord = sumHigh - eyeHigh - (sumLow < eyeLow ? 1u : 0u);

    bool negative = highWord > 0x7fffffffu;
    if (negative) {
        lowWord = ~lowWord + 1u;
        highWord = ~highWord + (lowWord == 0u ? 1u : 0u);
    }
    // The product is exact, so it makes no difference whether a compiler fuses it with the sum.
    float magnitude = float(highWord) * 4294967296.0f + float(lowWord);
    return negative ? -magnitude : magnitude;
}

ISOFRONT_SHARED_END

#endif

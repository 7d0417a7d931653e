#pragma once

#include <isofront/core/Image.h>

namespace isofront::cli {

/// How much a picture changed though nobody moved. Averages over squares of 8 x 8 pixels are
/// compared, the coarser look of an eye that does not dwell on single ones: so a change counts by
/// its area and strength together, and moving pixels about within a square counts nothing.
struct Popping {
    double largest = 0; ///< change of a square, the largest of red, green and blue [0 to 255, sRGB]
    double mean = 0;    ///< of the squares' changes, the same [0 to 255]
};

/// Between two pictures of one size. What is left of squares at the border counts as one.
Popping poppingBetween(const core::Image& before, const core::Image& after);

} // namespace isofront::cli

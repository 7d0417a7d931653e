#pragma once

#include "TrilinearKernel.h"

#include <array>
#include <cstddef>

namespace isofront::volume::detail {

/// How much each level counts at the points of a block: what `levelWeights` says of each, in rows.
struct BlockWeights {
    int first = 0; ///< the finest level that counts somewhere
    int end = 1;   ///< one after the coarsest
    /// c of each level at each point, zero where it doesn't count; rows outside of first and end
    /// mean nothing.
    std::array<BlockOf<double>, 32> rows;
};

/// The weights at points by their radii. Runs on the best instruction set of the machine, with the
/// same bits on all of them, and as `levelWeights`.
/// @param radii  [voxels]; below zero and NaN count as zero
/// @param count  at most kBlock
/// @param top    the coarsest level, 0 to 31
void weighLevels(const double* radii, std::size_t count, int top, BlockWeights& out);

} // namespace isofront::volume::detail

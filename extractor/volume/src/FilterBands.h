#pragma once

#include <isofront/core/Box.h>

#include <array>
#include <cstddef>
#include <span>

namespace isofront::volume::detail {

// The filter of volumes. With the Gaussian levels g_0 (the data), g_1, ... g_top of a pyramid, the
// bands d_k = g_k - g_{k+1} and their frequencies f_k = 0.3 * 2^-k cycles a voxel, a volume
// filtered to radius r is
//
//     f(p, r) = sum_k w(f_k r) d_k(p) + g_top(p) = sum_k c_k(r) g_k(p),
//     c_0 = w_0,  c_k = w_k - w_{k-1},  c_top = 1 - w_{top-1}.
//
// The c_k are never negative and add up to 1, so a filtered value is a weighted mean of values of
// the levels; and as w falls from 1 to 0 within four octaves, few of them count at any radius.
//
// Source: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
// of detail and applications", section 3.3. Differs: w(x) = exp(-x^2) is stretched by 1/64 at
// both ends, so that it ends in exactly 1 and exactly 0.

/// Filter radius up to which a volume is as it is: w is 1 for all bands [voxels].
inline constexpr double kPlainRadius = 0.4183081927125445;

inline constexpr double kCyclesPerVoxel = 0.3; ///< f_0
/// How much of the exponential is cut off at each end, and by how much the rest is stretched.
inline constexpr double kCut = 1.0 / 64.0;
inline constexpr double kStretch = 1.0 / (1.0 - 2.0 * kCut);

/// Those of exp(-u) for 0 <= u <= 1/15, the highest power first: exact to the last bits.
inline constexpr std::array<double, 9> kExponentialSeries = {
    1.0 / 40320, -1.0 / 5040, 1.0 / 720, -1.0 / 120, 1.0 / 24, -1.0 / 6, 0.5, -1.0, 1.0};

/// The coarsest band that is damped at a finite radius, -1 if none is.
int coarsestDamped(double radius);

/// A radius from which on, of the levels up to `top`, only the last is left [voxels].
double topRadius(int top);

/// w at the frequency of a band, for any radius >= 0, infinity included: falls from 1 to 0.
double bandWeight(int band, double radius);

/// How much each level counts at one radius. For many at once see FilterKernel.h.
struct LevelWeights {
    static constexpr std::size_t kMost = 8;

    int first = 0; ///< the finest level that counts
    int count = 1; ///< how many do, at most 6
    /// c of the level first + i, each above zero, together 1 up to rounding.
    std::array<double, kMost> weight{1.0};
};

/// @param radius  [voxels]; below zero and NaN count as zero
/// @param top     the coarsest level, >= 0
LevelWeights levelWeights(double radius, int top);

/// The first level and the one after the last that count at some radius of an interval.
struct LevelSpan {
    int first = 0;
    int end = 1;
};
LevelSpan levelSpan(core::Interval radius, int top);

/// What holds every filtered value, as a float, of points where the levels of
/// levelSpan(radius, top) lie within `levels`, in that order: the greatest and least sum that
/// weights of radii in the interval can make of them.
core::Interval
filteredBounds(core::Interval radius, int top, std::span<const core::Interval> levels);

} // namespace isofront::volume::detail

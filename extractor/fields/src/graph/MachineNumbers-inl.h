// How a machine keeps numbers, places and radii of a block of points, for each instruction set.

#if defined(ISOFRONT_FIELDS_GRAPH_MACHINE_NUMBERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRAPH_MACHINE_NUMBERS_INL_H
#undef ISOFRONT_FIELDS_GRAPH_MACHINE_NUMBERS_INL_H
#else
#define ISOFRONT_FIELDS_GRAPH_MACHINE_NUMBERS_INL_H
#endif

#include "graph/Scratch.h"
#include "simd/Batch-inl.h"

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using namespace isofront::fields::HWY_NAMESPACE; // NOLINT(google-build-using-namespace)

using Mask = hn::Mask<FloatTag>;

/// Points that are worked upon together: so many that the steps between instructions cost little,
/// and no more groups of lanes than a word has bits.
inline constexpr std::size_t kBatch = kLanes * 64 < kBlock ? kLanes * 64 : kBlock;
static_assert(kBatch % kLanes == 0, "whole groups");

/// How many floats a number has.
template <typename N>
inline constexpr std::size_t kParts = 0;
template <>
inline constexpr std::size_t kParts<Value> = 1;
template <>
inline constexpr std::size_t kParts<Range> = 2;
template <>
inline constexpr std::size_t kParts<Slope> = 4;

HWY_INLINE Floats part(const float* block, std::size_t which, std::size_t lane)
{
    return hn::Load(FloatTag(), block + which * kBlock + lane);
}
HWY_INLINE void setPart(Floats value, float* block, std::size_t which, std::size_t lane)
{
    hn::Store(value, FloatTag(), block + which * kBlock + lane);
}

template <typename N>
N fromMemory(const float* block, std::size_t lane);
template <>
HWY_INLINE Value fromMemory<Value>(const float* block, std::size_t lane)
{
    return {part(block, 0, lane)};
}
template <>
HWY_INLINE Range fromMemory<Range>(const float* block, std::size_t lane)
{
    return {part(block, 0, lane), part(block, 1, lane)};
}
template <>
HWY_INLINE Slope fromMemory<Slope>(const float* block, std::size_t lane)
{
    return {part(block, 0, lane), part(block, 1, lane), part(block, 2, lane), part(block, 3, lane)};
}

HWY_INLINE void toMemory(const Value& n, float* block, std::size_t lane)
{
    setPart(n.v, block, 0, lane);
}
HWY_INLINE void toMemory(const Range& n, float* block, std::size_t lane)
{
    setPart(n.low, block, 0, lane);
    setPart(n.high, block, 1, lane);
}
HWY_INLINE void toMemory(const Slope& n, float* block, std::size_t lane)
{
    setPart(n.v, block, 0, lane);
    setPart(n.x, block, 1, lane);
    setPart(n.y, block, 2, lane);
    setPart(n.z, block, 3, lane);
}

template <typename N>
Coordinate<N> coordinateOf(const FrameBlock& frame, std::size_t axis, std::size_t lane);
template <>
HWY_INLINE Coordinate<Value>
coordinateOf<Value>(const FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    return {loaded(frame.at[axis] + lane)};
}
template <>
HWY_INLINE Coordinate<Range>
coordinateOf<Range>(const FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    return {loaded(frame.at[axis] + lane), hn::Load(FloatTag(), frame.change[axis] + lane)};
}
template <>
HWY_INLINE Coordinate<Slope>
coordinateOf<Slope>(const FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    const FloatTag f;
    return {
        loaded(frame.at[axis] + lane),
        hn::Load(f, frame.change[3 * axis] + lane),
        hn::Load(f, frame.change[3 * axis + 1] + lane),
        hn::Load(f, frame.change[3 * axis + 2] + lane)};
}

HWY_INLINE void
setCoordinate(const Coordinate<Value>& c, FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    stored(c.at, frame.at[axis] + lane);
}
HWY_INLINE void
setCoordinate(const Coordinate<Range>& c, FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    stored(c.at, frame.at[axis] + lane);
    hn::Store(c.extent, FloatTag(), frame.change[axis] + lane);
}
HWY_INLINE void
setCoordinate(const Coordinate<Slope>& c, FrameBlock& frame, std::size_t axis, std::size_t lane)
{
    const FloatTag f;
    stored(c.at, frame.at[axis] + lane);
    hn::Store(c.x, f, frame.change[3 * axis] + lane);
    hn::Store(c.y, f, frame.change[3 * axis + 1] + lane);
    hn::Store(c.z, f, frame.change[3 * axis + 2] + lane);
}

template <typename N>
HWY_INLINE Point<N> pointOf(const FrameBlock& frame, std::size_t lane)
{
    return {
        coordinateOf<N>(frame, 0, lane),
        coordinateOf<N>(frame, 1, lane),
        coordinateOf<N>(frame, 2, lane)};
}

HWY_INLINE Radius radiusOf(const FrameBlock& frame, std::size_t lane)
{
    const FloatTag f;
    return {hn::Load(f, frame.radius[0] + lane), hn::Load(f, frame.radius[1] + lane)};
}

} // namespace isofront::fields::graph::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

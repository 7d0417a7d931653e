#include "VoxelKernel.h"

#include "VoxelGrid.h"

#include <algorithm>
#include <limits>
#include <type_traits>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "VoxelKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::volume::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Below AVX2 there is no gather, and VoxelGrid does as well.
#if HWY_TARGET <= HWY_AVX2

/// As many points as doubles fit a register, and what belongs to them.
constexpr std::size_t kLanes = HWY_LANES(double);
using Doubles = hn::Simd<double, kLanes, 0>;
using Integers = hn::Simd<std::int32_t, kLanes, 0>;
using Floats = hn::Simd<float, kLanes, 0>;
using Real = hn::Vec<Doubles>;
using Whole = hn::Vec<Integers>;

/// Two voxels side by side.
struct Pair {
    Real left;
    Real right;
};

/// The voxels at `offset` [bytes] and right of them: one look-up for both.
template <typename T>
HWY_INLINE Pair pairAt(const T* voxels, Whole offset)
{
    const Doubles d;
    const Integers i;
    if constexpr (sizeof(T) == 4) {
        const Floats f;
        const auto* base = reinterpret_cast<const float*>(voxels);
        const auto left = hn::GatherOffset(f, base, offset);
        const auto right = hn::GatherOffset(f, base, hn::Add(offset, hn::Set(i, sizeof(T))));
        return {hn::PromoteTo(d, left), hn::PromoteTo(d, right)};
    } else {
        const auto* base = reinterpret_cast<const std::int32_t*>(voxels);
        const Whole both = hn::GatherOffset(i, base, offset);
        constexpr int kBits = 8 * sizeof(T);
        // the left voxel in the lowest bits; shifted up and down again to extend its sign
        if constexpr (std::is_signed_v<T>) {
            const Whole left = hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - kBits>(both));
            const Whole right = hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - 2 * kBits>(both));
            return {hn::PromoteTo(d, left), hn::PromoteTo(d, right)};
        } else {
            const Whole mask = hn::Set(i, (1 << kBits) - 1);
            const hn::Simd<std::uint32_t, kLanes, 0> u;
            const auto shifted = hn::ShiftRight<kBits>(hn::BitCast(u, both));
            return {
                hn::PromoteTo(d, hn::And(both, mask)),
                hn::PromoteTo(d, hn::And(hn::BitCast(i, shifted), mask))};
        }
    }
}

/// `mixed` of Interpolation.h.
template <typename T>
HWY_INLINE Real between(Real a, Real b, Real t)
{
    const Real sum = hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
    if constexpr (std::is_floating_point_v<T>)
        return hn::IfThenElse(hn::Eq(t, hn::Zero(Doubles())), a, sum);
    else
        return sum;
}

/// A coordinate, clamped as `clampedTo` of Interpolation.h does, as voxel and rest.
struct Place {
    Whole voxel;
    Real rest;
};

HWY_INLINE Place placeOf(const double* coordinate, int last)
{
    const Doubles d;
    const Real c = hn::LoadU(d, coordinate);
    const Real high = hn::Set(d, static_cast<double>(last));
    const Real zero = hn::Zero(d);
    const Real clamped =
        hn::IfThenElse(hn::Gt(c, zero), hn::IfThenElse(hn::Lt(c, high), c, high), zero);
    const Whole voxel = hn::DemoteTo(Integers(), clamped);
    return {voxel, hn::Sub(clamped, hn::PromoteTo(d, voxel))};
}

/// Offset to the next row or slice, or none on the last one, where its weight is zero.
HWY_INLINE Whole stepFrom(Whole voxel, int last, int stride)
{
    const Integers i;
    return hn::IfThenElseZero(hn::Lt(voxel, hn::Set(i, last)), hn::Set(i, stride));
}

/// @return false, and nothing done, if a look-up would reach beyond the voxels
template <typename T>
HWY_INLINE bool sampleGroup(
    const glm::ivec3& size,
    int lastLookUp,
    const T* voxels,
    const double* px,
    const double* py,
    const double* pz,
    float* out)
{
    const Integers i;
    const int row = size.x * static_cast<int>(sizeof(T));
    const int slice = row * size.y;
    const Place x = placeOf(px, size.x - 1);
    const Place y = placeOf(py, size.y - 1);
    const Place z = placeOf(pz, size.z - 1);
    const Whole near = hn::Add(
        hn::Add(hn::Mul(z.voxel, hn::Set(i, slice)), hn::Mul(y.voxel, hn::Set(i, row))),
        hn::Mul(x.voxel, hn::Set(i, static_cast<int>(sizeof(T)))));
    const Whole stepY = stepFrom(y.voxel, size.y - 1, row);
    const Whole far = hn::Add(near, stepFrom(z.voxel, size.z - 1, slice));
    const Whole farthest = hn::Add(far, stepY);
    if (!hn::AllFalse(i, hn::Gt(farthest, hn::Set(i, lastLookUp))))
        return false;
    const Pair a = pairAt(voxels, near);
    const Pair b = pairAt(voxels, hn::Add(near, stepY));
    const Pair c = pairAt(voxels, far);
    const Pair e = pairAt(voxels, farthest);
    const Real low = between<T>(
        between<T>(a.left, a.right, x.rest), between<T>(b.left, b.right, x.rest), y.rest);
    const Real high = between<T>(
        between<T>(c.left, c.right, x.rest), between<T>(e.left, e.right, x.rest), y.rest);
    const Floats f;
    hn::StoreU(hn::DemoteTo(f, between<T>(low, high, z.rest)), f, out);
    return true;
}

template <typename T>
bool sampleAll(
    const glm::ivec3& size,
    const T* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out)
{
    const std::int64_t bytes =
        std::int64_t{size.x} * size.y * size.z * static_cast<std::int64_t>(sizeof(T));
    if (bytes > std::numeric_limits<std::int32_t>::max())
        return false;
    // A look-up takes two voxels, and four bytes at least.
    const int lastLookUp = static_cast<int>(bytes) - (sizeof(T) == 4 ? 8 : 4);
    const VoxelGrid<T> grid(size, voxels);
    for (std::size_t first = 0; first < count; first += kLanes) {
        const std::size_t group = std::min(kLanes, count - first);
        if (group < kLanes ||
            !sampleGroup(size, lastLookUp, voxels, px + first, py + first, pz + first, out + first))
            grid.sample(px + first, py + first, pz + first, group, out + first);
    }
    return true;
}

#else

template <typename T>
bool sampleAll(
    const glm::ivec3& /*size*/,
    const T* /*voxels*/,
    const double* /*px*/,
    const double* /*py*/,
    const double* /*pz*/,
    std::size_t /*count*/,
    float* /*out*/)
{
    return false;
}

#endif

#define ISOFRONT_SAMPLE_VOXELS(name, T)                                                            \
    bool name(                                                                                     \
        const glm::ivec3& size,                                                                    \
        const T* voxels,                                                                           \
        const double* px,                                                                          \
        const double* py,                                                                          \
        const double* pz,                                                                          \
        std::size_t count,                                                                         \
        float* out)                                                                                \
    {                                                                                              \
        return sampleAll(size, voxels, px, py, pz, count, out);                                    \
    }
ISOFRONT_SAMPLE_VOXELS(sampleInt8, std::int8_t)
ISOFRONT_SAMPLE_VOXELS(sampleUint8, std::uint8_t)
ISOFRONT_SAMPLE_VOXELS(sampleInt16, std::int16_t)
ISOFRONT_SAMPLE_VOXELS(sampleUint16, std::uint16_t)
ISOFRONT_SAMPLE_VOXELS(sampleFloat, float)
#undef ISOFRONT_SAMPLE_VOXELS

} // namespace isofront::volume::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::volume::detail {

#define ISOFRONT_SAMPLE_VOXELS(name, T)                                                            \
    HWY_EXPORT(name);                                                                              \
    bool sampleVoxels(                                                                             \
        const glm::ivec3& size,                                                                    \
        const T* voxels,                                                                           \
        const double* px,                                                                          \
        const double* py,                                                                          \
        const double* pz,                                                                          \
        std::size_t count,                                                                         \
        float* out)                                                                                \
    {                                                                                              \
        return HWY_DYNAMIC_DISPATCH(name)(size, voxels, px, py, pz, count, out);                   \
    }
ISOFRONT_SAMPLE_VOXELS(sampleInt8, std::int8_t)
ISOFRONT_SAMPLE_VOXELS(sampleUint8, std::uint8_t)
ISOFRONT_SAMPLE_VOXELS(sampleInt16, std::int16_t)
ISOFRONT_SAMPLE_VOXELS(sampleUint16, std::uint16_t)
ISOFRONT_SAMPLE_VOXELS(sampleFloat, float)
#undef ISOFRONT_SAMPLE_VOXELS

} // namespace isofront::volume::detail
#endif

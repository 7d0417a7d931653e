// Runs a formula over batches and boxes, for each instruction set. A formula has
// `template <typename N> N at(const Point<N>&, const Radius&) const`; see Numbers-inl.h.

#if defined(ISOFRONT_FIELDS_BATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_BATCH_INL_H
#undef ISOFRONT_FIELDS_BATCH_INL_H
#else
#define ISOFRONT_FIELDS_BATCH_INL_H
#endif

#include "isofront/fields/Field.h"
#include "simd/Numbers-inl.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

inline constexpr std::size_t kLanes = HWY_LANES(float);

HWY_INLINE DoublePair loaded(const double* from)
{
    const DoubleTag d;
    return {hn::LoadU(d, from), hn::LoadU(d, from + kLanes / 2)};
}

HWY_INLINE void stored(const DoublePair& pair, double* to)
{
    const DoubleTag d;
    hn::StoreU(pair.first, d, to);
    hn::StoreU(pair.second, d, to + kLanes / 2);
}

/// Calls `body(x, y, z, radius, first, count)` for each group of lanes. The last group is filled up
/// with copies of the last point, so that no lane knows where in the batch it stands.
template <typename Body>
HWY_INLINE void forEachGroup(const SampleBatch& batch, const Body& body)
{
    const std::size_t size = batch.size();
    double rest[4][kLanes];
    std::fill_n(rest[3], kLanes, 0.0);
    for (std::size_t first = 0; first < size; first += kLanes) {
        const std::size_t count = std::min(size - first, kLanes);
        const double* x = batch.x.data() + first;
        const double* y = batch.y.data() + first;
        const double* z = batch.z.data() + first;
        const double* radius = batch.radius.empty() ? rest[3] : batch.radius.data() + first;
        if (count < kLanes) {
            for (std::size_t i = 0; i < kLanes; ++i) {
                const std::size_t from = std::min(i, count - 1);
                rest[0][i] = x[from];
                rest[1][i] = y[from];
                rest[2][i] = z[from];
                rest[3][i] = radius[from];
            }
            x = rest[0];
            y = rest[1];
            z = rest[2];
            radius = rest[3];
        }
        // One call only: the body is a whole terrain, inlined.
        body(loaded(x), loaded(y), loaded(z), loaded(radius), first, count);
    }
}

template <typename Formula>
void sampleBatch(const Formula& formula, const SampleBatch& batch, float* values)
{
    const FloatTag f;
    forEachGroup(
        batch,
        [&](const DoublePair& x,
            const DoublePair& y,
            const DoublePair& z,
            const DoublePair& r,
            std::size_t first,
            std::size_t count) HWY_ATTR {
            const Floats radius = narrowed(r);
            const Value value =
                formula.template at<Value>(Point<Value>{{x}, {y}, {z}}, Radius{radius, radius});
            if (count == kLanes) {
                hn::StoreU(value.v, f, values + first);
            } else {
                float all[kLanes];
                hn::StoreU(value.v, f, all);
                std::copy_n(all, count, values + first);
            }
        });
}

template <typename Formula>
void gradientBatch(const Formula& formula, const SampleBatch& batch, const GradientSpans& to)
{
    forEachGroup(
        batch,
        [&](const DoublePair& x,
            const DoublePair& y,
            const DoublePair& z,
            const DoublePair& r,
            std::size_t first,
            std::size_t count) HWY_ATTR {
            const Floats radius = narrowed(r);
            const Floats zero = hn::Zero(FloatTag());
            const Floats one = constant(1.0F);
            const Slope slope = formula.template at<Slope>(
                Point<Slope>{{x, one, zero, zero}, {y, zero, one, zero}, {z, zero, zero, one}},
                Radius{radius, radius});
            double all[3][kLanes];
            stored(widened(slope.x), all[0]);
            stored(widened(slope.y), all[1]);
            stored(widened(slope.z), all[2]);
            for (std::size_t i = 0; i < count; ++i) {
                to.x[first + i] = all[0][i];
                to.y[first + i] = all[1][i];
                to.z[first + i] = all[2][i];
            }
        });
}

/// The hull of the formula's ranges over 4 x 4 x 4 parts of a box.
/// @param slack  what rounding may add to a value on top of 1e-5 of its magnitude
template <typename Formula>
core::Interval
boundsOver(const Formula& formula, const core::Box& box, const core::Interval& radius, double slack)
{
    const glm::dvec3 whole = box.size();
    if (!(std::isfinite(whole.x + whole.y + whole.z) && whole.x >= 0 && whole.y >= 0 &&
          whole.z >= 0))
        return {};
    constexpr std::size_t kParts = 4;
    constexpr std::size_t kCount = kParts * kParts * kParts;
    // The corners of the parts are rounded; a part reaches a little further than its share.
    constexpr double kGrown = 1.00001;
    const FloatTag f;
    const glm::dvec3 part = whole * (1.0 / double(kParts));
    const glm::dvec3 far =
        glm::max(glm::dvec3(glm::abs(box.low)), glm::dvec3(glm::abs(box.high))) * 1e-15;
    const glm::dvec3 extent = 0.5 * kGrown * part + far;
    const Radius radii{
        constant(static_cast<float>(std::max(radius.low, 0.0) * (1 - 1e-6))),
        constant(static_cast<float>(radius.high * (1 + 1e-6)))};

    Floats low = constant(hwy::HighestValue<float>());
    Floats high = constant(hwy::LowestValue<float>());
    for (std::size_t first = 0; first < kCount; first += kLanes) {
        double at[3][kLanes];
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::size_t index = std::min(first + lane, kCount - 1);
            at[0][lane] = box.low.x + part.x * (double(index % kParts) + 0.5);
            at[1][lane] = box.low.y + part.y * (double(index / kParts % kParts) + 0.5);
            at[2][lane] = box.low.z + part.z * (double(index / (kParts * kParts)) + 0.5);
        }
        const Point<Range> point{
            {loaded(at[0]), constant(static_cast<float>(extent.x))},
            {loaded(at[1]), constant(static_cast<float>(extent.y))},
            {loaded(at[2]), constant(static_cast<float>(extent.z))}};
        const Range range = formula.template at<Range>(point, radii);
        low = hn::Min(low, range.low);
        high = hn::Max(high, range.high);
    }
    const double least = hn::GetLane(hn::MinOfLanes(f, low));
    const double most = hn::GetLane(hn::MaxOfLanes(f, high));
    const double margin = slack + 1e-5 * std::max(std::abs(least), std::abs(most));
    return {least - margin, most + margin};
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

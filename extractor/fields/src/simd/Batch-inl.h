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

/// Writes the lanes that count.
HWY_INLINE void storedPart(const DoublePair& pair, std::size_t count, double* to)
{
    if (count == kLanes) {
        stored(pair, to);
    } else {
        double all[kLanes];
        stored(pair, all);
        std::copy_n(all, count, to);
    }
}
HWY_INLINE void storedPart(Floats lanes, std::size_t count, float* to)
{
    const FloatTag f;
    if (count == kLanes) {
        hn::StoreU(lanes, f, to);
    } else {
        float all[kLanes];
        hn::StoreU(lanes, f, all);
        std::copy_n(all, count, to);
    }
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
            storedPart(value.v, count, values + first);
        });
}

/// @param values  null if only the gradient is asked for
template <typename Formula>
void gradientBatch(
    const Formula& formula, const SampleBatch& batch, float* values, const GradientSpans& to)
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
            if (values != nullptr)
                storedPart(slope.v, count, values + first);
            storedPart(widened(slope.x), count, to.x.data() + first);
            storedPart(widened(slope.y), count, to.y.data() + first);
            storedPart(widened(slope.z), count, to.z.data() + first);
        });
}

/// A part of a box: its centre, how often it has been halved, and the formula's range over it.
struct Part {
    glm::dvec3 centre;
    int depth = 0;
    float low = 0;
    float high = 0;

    [[nodiscard]] bool straddlesZero() const { return low <= 0 && high >= 0; }
};

/// Bounds a formula over the parts of one box.
template <typename Formula>
class Bounder {
public:
    Bounder(const Formula& formula, const core::Box& box, const core::Interval& radius)
        : _formula(formula), _box(box), _size(box.size()),
          _far(glm::max(glm::abs(box.low), glm::abs(box.high)) * 1e-15),
          _radius{
              static_cast<float>(std::max(radius.low, 0.0) * (1 - 1e-6)),
              static_cast<float>(radius.high * (1 + 1e-6))}
    {
    }

    /// First 2 x 2 x 2 parts; then those that may hold a zero are halved along each axis, again and
    /// again, until none is left or one has become so small that there probably is a zero.
    core::Interval hull()
    {
        Part parts[kFirst];
        for (std::size_t i = 0; i < kFirst; ++i) {
            const glm::dvec3 at(double(i % 2), double(i / 2 % 2), double(i / 4));
            parts[i] = {_box.low + 0.5 * _size * (at + 0.5), 0, 0, 0};
        }
        evaluate(parts, kFirst);
        bool anyBelow = false;
        bool anyAbove = false;
        for (const Part& part : parts) {
            anyBelow = anyBelow || part.high < 0;
            anyAbove = anyAbove || part.low > 0;
        }
        // Both signs for certain: nothing is gained by a closer look.
        const bool hopeless = anyBelow && anyAbove;
        for (const Part& part : parts) {
            if (!hopeless && part.straddlesZero())
                _open[_openCount++] = part;
            else
                include(part);
        }
        refine();
        return {double(_low), double(_high)};
    }

private:
    static constexpr std::size_t kFirst = 8;
    static constexpr std::size_t kAtOnce = 2;
    static constexpr int kDeepest = 4;
    /// How many parts are halved at most: bounds the time, and is seldom reached.
    static constexpr std::size_t kMostHalved = 80;

    void refine()
    {
        // The stack holds pairs; a part that is taken leaves at most eight.
        for (std::size_t halved = 0; _openCount > 0 && halved < kMostHalved; halved += kAtOnce) {
            Part children[8 * kAtOnce];
            std::size_t count = 0;
            for (std::size_t k = 0; k < kAtOnce && _openCount > 0; ++k) {
                const Part parent = _open[--_openCount];
                const glm::dvec3 quarter = 0.25 * edgeAt(parent.depth);
                for (unsigned child = 0; child < 8; ++child) {
                    const glm::dvec3 side(
                        (child & 1U) != 0 ? 1 : -1,
                        (child & 2U) != 0 ? 1 : -1,
                        (child & 4U) != 0 ? 1 : -1);
                    children[count++] = {
                        parent.centre + side * quarter, parent.depth + 1, parent.low, parent.high};
                }
            }
            evaluate(children, count);
            for (std::size_t i = 0; i < count; ++i) {
                if (!children[i].straddlesZero()) {
                    include(children[i]);
                } else if (children[i].depth < kDeepest) {
                    _open[_openCount++] = children[i];
                } else {
                    // Probably a zero: the rest stays as it is.
                    for (; i < count; ++i)
                        include(children[i]);
                    closeAll();
                    return;
                }
            }
        }
        closeAll();
    }

    void closeAll()
    {
        while (_openCount > 0)
            include(_open[--_openCount]);
    }

    [[nodiscard]] glm::dvec3 edgeAt(int depth) const { return _size * (0.5 / double(1 << depth)); }

    /// Finds the ranges, of as many parts at once as there are lanes.
    void evaluate(Part* parts, std::size_t count) const
    {
        // The corners of the parts are rounded; a part reaches a little further than its share.
        constexpr double kGrown = 0.5 * 1.00001;
        const FloatTag f;
        for (std::size_t first = 0; first < count; first += kLanes) {
            double at[3][kLanes];
            float extent[3][kLanes];
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const Part& part = parts[std::min(first + lane, count - 1)];
                const glm::dvec3 reach = kGrown * edgeAt(part.depth) + _far;
                at[0][lane] = part.centre.x;
                at[1][lane] = part.centre.y;
                at[2][lane] = part.centre.z;
                extent[0][lane] = static_cast<float>(reach.x);
                extent[1][lane] = static_cast<float>(reach.y);
                extent[2][lane] = static_cast<float>(reach.z);
            }
            const Range range = _formula.template at<Range>(
                Point<Range>{
                    {loaded(at[0]), hn::LoadU(f, extent[0])},
                    {loaded(at[1]), hn::LoadU(f, extent[1])},
                    {loaded(at[2]), hn::LoadU(f, extent[2])}},
                Radius{constant(_radius[0]), constant(_radius[1])});
            float low[kLanes];
            float high[kLanes];
            hn::StoreU(range.low, f, low);
            hn::StoreU(range.high, f, high);
            for (std::size_t lane = 0; lane < std::min(kLanes, count - first); ++lane) {
                parts[first + lane].low = low[lane];
                parts[first + lane].high = high[lane];
            }
        }
    }

    void include(const Part& part)
    {
        _low = std::min(_low, part.low);
        _high = std::max(_high, part.high);
    }

    const Formula& _formula;
    core::Box _box;
    glm::dvec3 _size;
    glm::dvec3 _far;
    float _radius[2];
    Part _open[kFirst + 8 * kMostHalved];
    std::size_t _openCount = 0;
    float _low = hwy::HighestValue<float>();
    float _high = hwy::LowestValue<float>();
};

/// An interval that holds the formula's values over a box. It is tightest about zero: parts that
/// may hold a zero are looked at more closely.
/// @param slack  what rounding may add to a value on top of 1e-5 of its magnitude
template <typename Formula>
core::Interval
boundsOver(const Formula& formula, const core::Box& box, const core::Interval& radius, double slack)
{
    const glm::dvec3 size = box.size();
    if (!(std::isfinite(size.x + size.y + size.z) && size.x >= 0 && size.y >= 0 && size.z >= 0))
        return {};
    const core::Interval hull = Bounder<Formula>(formula, box, radius).hull();
    const double margin = slack + 1e-5 * std::max(std::abs(hull.low), std::abs(hull.high));
    return {hull.low - margin, hull.high + margin};
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

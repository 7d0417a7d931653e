// Runs a program on blocks of points, for each instruction set and each kind of number.

#if defined(ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#undef ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#else
#define ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#endif

#include "graph/Program.h"
#include "graph/Scratch.h"
#include "simd/Batch-inl.h"
#include "simd/Noise-inl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using namespace isofront::fields::HWY_NAMESPACE; // NOLINT(google-build-using-namespace)

using Mask = hn::Mask<FloatTag>;

/// Points that are worked upon together: so many that the steps between instructions cost little,
/// and no more groups of lanes than a word has bits.
inline constexpr std::size_t kBatch = kLanes * 64 < kBlock ? kLanes * 64 : kBlock;
static_assert(kBatch % kLanes == 0, "whole groups");

// ---- Numbers in memory --------------------------------------------------------------------------

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

// ---- What rounding adds to ranges ---------------------------------------------------------------

// A single rounded operation is as monotone as the exact one, so the rounded ends enclose all
// rounded values. Where more than one rounding comes together, a range is widened.

HWY_INLINE Value outward(const Value& n, float /*slack*/)
{
    return n;
}
HWY_INLINE Slope outward(const Slope& n, float /*slack*/)
{
    return n;
}
HWY_INLINE Range outward(const Range& n, float slack)
{
    const Floats ulps = constant(5e-7F);
    const Floats s = constant(slack);
    return {
        hn::Sub(n.low, hn::Add(hn::Mul(hn::Abs(n.low), ulps), s)),
        hn::Add(n.high, hn::Add(hn::Mul(hn::Abs(n.high), ulps), s))};
}

template <typename N>
HWY_INLINE N stepped(const N& a, float begin, float end)
{
    return smoothStep(a, begin, end);
}
template <>
HWY_INLINE Range stepped(const Range& a, float begin, float end)
{
    // A step that has ended is exactly 0 or 1 and must stay so: factors are left out by it.
    const Range exact = smoothStep(a, begin, end);
    const Range wide = outward(exact, 0.0F);
    const Mask flat = hn::Eq(exact.low, exact.high);
    return {hn::IfThenElse(flat, exact.low, wide.low), hn::IfThenElse(flat, exact.high, wide.high)};
}

template <typename N>
HWY_INLINE N weighted(const Radius& radius, float cycles)
{
    return weight<N>(radius, cycles);
}
template <>
HWY_INLINE Range weighted<Range>(const Radius& radius, float cycles)
{
    const Range exact = weight<Range>(radius, cycles);
    const Floats zero = hn::Zero(FloatTag());
    const Floats slack = constant(1e-6F);
    return {
        hn::Max(zero, hn::Sub(exact.low, slack)),
        hn::IfThenElseZero(hn::Gt(exact.high, zero), hn::Add(exact.high, slack))};
}

template <typename N>
HWY_INLINE N placeAsNumber(const Coordinate<N>& c)
{
    return asNumber(c);
}
template <>
HWY_INLINE Range placeAsNumber(const Coordinate<Range>& c)
{
    const Floats rounding = hn::Mul(hn::Abs(narrowed(c.at)), constant(3e-7F));
    return asNumber(Coordinate<Range>{c.at, hn::Add(c.extent, hn::Add(rounding, rounding))});
}

// ---- Moved places -------------------------------------------------------------------------------

/// Twice the relative error of a few operations in float.
inline constexpr float kGrown = 1.000001F;

template <typename N>
HWY_INLINE Coordinate<N> moved(const Coordinate<N>& c, const N& by)
{
    return c + by;
}
template <>
HWY_INLINE Coordinate<Range> moved(const Coordinate<Range>& c, const Range& by)
{
    Coordinate<Range> sum = c + by;
    sum.extent = hn::Mul(sum.extent, constant(kGrown));
    return sum;
}

HWY_INLINE DoublePair within(const DoublePair& at, double origin, double inverse)
{
    const DoubleTag d;
    const Doubles o = hn::Set(d, origin);
    const Doubles i = hn::Set(d, inverse);
    return {hn::Mul(hn::Sub(at.first, o), i), hn::Mul(hn::Sub(at.second, o), i)};
}
HWY_INLINE Coordinate<Value> placedAt(const Coordinate<Value>& c, double origin, double inverse)
{
    return {within(c.at, origin, inverse)};
}
HWY_INLINE Coordinate<Range> placedAt(const Coordinate<Range>& c, double origin, double inverse)
{
    const auto factor = static_cast<float>(inverse);
    // What the difference loses in double.
    const Floats lost = hn::Mul(
        hn::Add(hn::Abs(narrowed(c.at)), constant(static_cast<float>(std::abs(origin)))),
        constant(1e-15F));
    return {
        within(c.at, origin, inverse), hn::Mul(hn::Add(c.extent, lost), constant(factor * kGrown))};
}
HWY_INLINE Coordinate<Slope> placedAt(const Coordinate<Slope>& c, double origin, double inverse)
{
    const Floats f = constant(static_cast<float>(inverse));
    return {within(c.at, origin, inverse), hn::Mul(c.x, f), hn::Mul(c.y, f), hn::Mul(c.z, f)};
}

// ---- Tests --------------------------------------------------------------------------------------

HWY_INLINE Mask decided(const Value& n, Test test, float threshold)
{
    const Floats t = constant(threshold);
    switch (test) {
    case Test::below:
        return hn::Lt(n.v, t);
    case Test::above:
        return hn::Gt(n.v, t);
    case Test::beyond:
        return hn::Gt(hn::Abs(n.v), t);
    case Test::zero:
        break;
    }
    return hn::Eq(n.v, hn::Zero(FloatTag()));
}
HWY_INLINE Mask decided(const Range& n, Test test, float threshold)
{
    const Floats t = constant(threshold);
    const Floats zero = hn::Zero(FloatTag());
    switch (test) {
    case Test::below:
        return hn::Lt(n.high, t);
    case Test::above:
        return hn::Gt(n.low, t);
    case Test::beyond:
        return hn::Or(hn::Gt(n.low, t), hn::Lt(n.high, hn::Neg(t)));
    case Test::zero:
        break;
    }
    return hn::And(hn::Eq(n.low, zero), hn::Eq(n.high, zero));
}
HWY_INLINE Mask decided(const Slope& n, Test test, float threshold)
{
    const Mask value = decided(Value{n.v}, test, threshold);
    if (test != Test::zero)
        return value;
    const Floats slope = hn::Max(hn::Max(hn::Abs(n.x), hn::Abs(n.y)), hn::Abs(n.z));
    return hn::And(value, hn::Eq(slope, hn::Zero(FloatTag())));
}

HWY_INLINE Value chosen(Mask mask, const Value& yes, const Value& no)
{
    return {hn::IfThenElse(mask, yes.v, no.v)};
}
HWY_INLINE Range chosen(Mask mask, const Range& yes, const Range& no)
{
    return {hn::IfThenElse(mask, yes.low, no.low), hn::IfThenElse(mask, yes.high, no.high)};
}
HWY_INLINE Slope chosen(Mask mask, const Slope& yes, const Slope& no)
{
    return selected(mask, yes, no);
}

// ---- Curves -------------------------------------------------------------------------------------

struct CurveSpan {
    const CurvePiece* pieces;
    std::size_t count;
};

struct CurveSample {
    Floats value;
    Floats slope;
};
HWY_INLINE CurveSample curveAt(const CurveSpan& curve, Floats x)
{
    CurveSample sample{constant(curve.pieces[0].coefficients[0]), hn::Zero(FloatTag())};
    for (std::size_t i = 0; i < curve.count; ++i) {
        const CurvePiece& piece = curve.pieces[i];
        const auto c = [&](std::size_t k) HWY_ATTR { return constant(piece.coefficients[k]); };
        const Mask here = hn::Ge(x, constant(piece.begin));
        const Floats t = hn::Sub(x, constant(piece.begin));
        const Floats inner = hn::Add(c(2), hn::Mul(t, c(3)));
        const Floats value = hn::Add(c(0), hn::Mul(t, hn::Add(c(1), hn::Mul(t, inner))));
        // Rounding must not leave what lies between the two points.
        const Floats kept = hn::Min(hn::Max(value, constant(piece.low)), constant(piece.high));
        const Floats slope = hn::Add(
            c(1),
            hn::Mul(t, hn::Add(hn::Add(c(2), c(2)), hn::Mul(t, hn::Mul(constant(3.0F), c(3))))));
        sample.value = hn::IfThenElse(here, kept, sample.value);
        sample.slope = hn::IfThenElse(here, slope, sample.slope);
    }
    return sample;
}
HWY_INLINE Value curved(const CurveSpan& curve, const Value& a)
{
    return {curveAt(curve, a.v).value};
}
HWY_INLINE Slope curved(const CurveSpan& curve, const Slope& a)
{
    const CurveSample sample = curveAt(curve, a.v);
    return mapped(a, sample.value, sample.slope);
}
HWY_INLINE Range curved(const CurveSpan& curve, const Range& a)
{
    // Between points it is monotone: the ends of the range, and the points within.
    const Floats atLow = curveAt(curve, a.low).value;
    const Floats atHigh = curveAt(curve, a.high).value;
    Floats low = hn::Min(atLow, atHigh);
    Floats high = hn::Max(atLow, atHigh);
    for (std::size_t i = 0; i < curve.count; ++i) {
        const Floats at = constant(curve.pieces[i].begin);
        const Floats value = constant(curve.pieces[i].coefficients[0]);
        const Mask inside = hn::And(hn::Le(a.low, at), hn::Le(at, a.high));
        low = hn::IfThenElse(inside, hn::Min(low, value), low);
        high = hn::IfThenElse(inside, hn::Max(high, value), high);
    }
    return {low, high};
}

// ---- Noise --------------------------------------------------------------------------------------

/// A kind of noise as a function: programs say which while they run.
template <typename N, typename Octave>
using NoiseCall = N (*)(const Octave&, const Point<N>&);

template <typename N, typename Octave>
HWY_INLINE NoiseCall<N, Octave> noiseOf(NoiseKind kind)
{
    switch (kind) {
    case NoiseKind::value:
        return &calledNoise<NoiseKind::value, N, Octave>;
    case NoiseKind::gradient:
        break;
    case NoiseKind::simplex:
        return &calledNoise<NoiseKind::simplex, N, Octave>;
    case NoiseKind::cellular:
        return &calledNoise<NoiseKind::cellular, N, Octave>;
    case NoiseKind::border:
        return &calledNoise<NoiseKind::border, N, Octave>;
    }
    return &calledNoise<NoiseKind::gradient, N, Octave>;
}

/// The same as fractalSum of a kind and norms that are known beforehand.
template <FractalKind kFractal, typename N, typename Octave>
HWY_INLINE N putTogether(
    NoiseCall<N, Octave> call,
    const Octave* octaves,
    std::size_t count,
    const FractalNorms& norms,
    const Point<N>& p,
    const Radius& radius)
{
    FractalSum<kFractal, N> fractal{fromConstant<N>(0.0F), fromConstant<N>(1.0F)};
    for (std::size_t i = 0; i < count; ++i) {
        const N factor = weight<N>(radius, octaves[i].filterCycles);
        // Shorter waves are filtered away as well, in the same lanes.
        if (vanishes(factor))
            break;
        fractal.add(call(octaves[i], p), octaves[i].amplitude, factor, norms);
    }
    return chained(fractal.sum, p);
}

template <typename N>
HWY_INLINE N detailed(
    N value,
    const DetailOctave* octaves,
    std::size_t count,
    const N& strength,
    const Point<N>& p,
    const Radius& radius)
{
    for (std::size_t i = 0; i < count; ++i) {
        const DetailOctave& octave = octaves[i];
        const N open =
            1.0F - smoothStep(magnitude(value), octave.remaining, 2.0F * octave.remaining);
        // What is too far from zero for this octave is too far for the weaker ones that follow.
        if (vanishes(open))
            break;
        const N near = open * weight<N>(radius, octave.noise.filterCycles);
        if (vanishes(near))
            continue;
        const N noise = chained(noiseOf<N, SpaceOctave>(octave.kind)(octave.noise, p), p);
        value = value + noise * octave.noise.amplitude * near * strength;
    }
    return value;
}

// ---- The machine --------------------------------------------------------------------------------

/// A program with memory for one block.
template <typename N>
class Machine {
public:
    explicit Machine(const Program& program)
        : _program(program),
          _scratch(program.frames, std::size_t(program.registers) * kParts<N> * kBlock)
    {
    }

    /// The world's places: to be filled before a run.
    [[nodiscard]] FrameBlock& world() const { return _scratch.frames()[0]; }

    /// Takes points of a batch, and fills the last group up with copies of the last point, so that
    /// no lane knows where in the batch it stands.
    void load(const SampleBatch& batch, std::size_t first)
    {
        _first = first;
        _count = std::min(kBatch, batch.size() - first);
        const std::size_t filled = groups() * kLanes;
        FrameBlock& frame = world();
        const std::array<std::span<const double>, 3> from{batch.x, batch.y, batch.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::copy_n(from[axis].data() + first, _count, frame.at[axis]);
            std::fill(frame.at[axis] + _count, frame.at[axis] + filled, frame.at[axis][_count - 1]);
        }
        if (batch.radius.empty()) {
            std::fill_n(frame.radius[0], filled, 0.0F);
        } else {
            for (std::size_t i = 0; i < _count; ++i)
                frame.radius[0][i] = static_cast<float>(batch.radius[first + i]);
            std::fill(
                frame.radius[0] + _count, frame.radius[0] + filled, frame.radius[0][_count - 1]);
        }
        std::copy_n(frame.radius[0], filled, frame.radius[1]);
    }

    [[nodiscard]] std::size_t groups() const { return (_count + kLanes - 1) / kLanes; }

    void run(std::size_t groupCount) const
    {
        const std::uint64_t all = ~std::uint64_t{0} >> (64 - groupCount);
        std::uint64_t active = all;
        // Sections that are open, innermost last.
        std::array<std::uint64_t, kDeepestGuards> outer{};
        std::array<std::uint32_t, kDeepestGuards> ends{};
        std::size_t depth = 0;
        const auto size = static_cast<std::uint32_t>(_program.instructions.size());
        for (std::uint32_t at = 0; at < size;) {
            while (depth > 0 && ends[depth - 1] == at)
                active = outer[--depth];
            const Instruction& instruction = _program.instructions[at];
            if (instruction.op != Op::guard) {
                execute(instruction, active);
                ++at;
                continue;
            }
            const std::uint64_t undecided = guard(instruction, active);
            if (undecided == 0) {
                at = instruction.end;
                continue;
            }
            outer[depth] = active;
            ends[depth++] = instruction.end;
            active = undecided;
            ++at;
        }
    }

    /// The result in a group of lanes. Adding zero turns a negative zero into a positive one.
    [[nodiscard]] HWY_INLINE N result(std::size_t lane) const
    {
        return fromMemory<N>(reg(_program.result), lane) + 0.0F;
    }

    void storeValues(float* values) const
    {
        const float* block = reg(_program.result);
        for (std::size_t i = 0; i < _count; ++i)
            values[_first + i] = block[i] + 0.0F;
    }
    void storeGradients(const GradientSpans& to) const
    {
        const float* block = reg(_program.result);
        for (std::size_t i = 0; i < _count; ++i) {
            to.x[_first + i] = double(block[kBlock + i] + 0.0F);
            to.y[_first + i] = double(block[2 * kBlock + i] + 0.0F);
            to.z[_first + i] = double(block[3 * kBlock + i] + 0.0F);
        }
    }

private:
    [[nodiscard]] float* reg(std::uint32_t index) const
    {
        return _scratch.floats() + std::size_t(index) * kParts<N> * kBlock;
    }
    [[nodiscard]] FrameBlock& frame(std::uint32_t index) const { return _scratch.frames()[index]; }

    /// Stores the results of groups that are decided, and returns the others.
    HWY_INLINE std::uint64_t guard(const Instruction& i, std::uint64_t active) const
    {
        const float* from = reg(i.a);
        float* to = reg(i.target);
        std::uint64_t undecided = active;
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const auto group = static_cast<std::size_t>(std::countr_zero(left));
            const N n = fromMemory<N>(from, group * kLanes);
            if (!hn::AllTrue(FloatTag(), decided(n, i.test, i.numbers[0])))
                continue;
            undecided &= ~(std::uint64_t{1} << group);
            toMemory(decision(i, n), to, group * kLanes);
        }
        return undecided;
    }

    static HWY_INLINE N decision(const Instruction& i, const N& n)
    {
        return i.test == Test::zero ? fromConstant<N>(0.0F) : n;
    }

    /// Stores body(lane) into the target, group after group.
    template <typename Body>
    HWY_INLINE void each(const Instruction& i, std::uint64_t active, const Body& body) const
    {
        float* to = reg(i.target);
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const std::size_t lane = static_cast<std::size_t>(std::countr_zero(left)) * kLanes;
            toMemory(body(lane), to, lane);
        }
    }
    template <typename Body>
    HWY_INLINE void unary(const Instruction& i, std::uint64_t active, const Body& body) const
    {
        const float* a = reg(i.a);
        each(i, active, [&](std::size_t lane) HWY_ATTR { return body(fromMemory<N>(a, lane)); });
    }
    template <typename Body>
    HWY_INLINE void binary(const Instruction& i, std::uint64_t active, const Body& body) const
    {
        const float* a = reg(i.a);
        const float* b = reg(i.b);
        each(i, active, [&](std::size_t lane) HWY_ATTR {
            return body(fromMemory<N>(a, lane), fromMemory<N>(b, lane));
        });
    }

    void execute(const Instruction& i, std::uint64_t active) const
    {
        const float n0 = i.numbers[0];
        const float n1 = i.numbers[1];
        const float slack = i.slack;
        switch (i.op) {
        case Op::constant:
            each(i, active, [&](std::size_t) HWY_ATTR { return fromConstant<N>(n0); });
            break;
        case Op::position:
            each(i, active, [&](std::size_t lane) HWY_ATTR {
                return placeAsNumber(coordinateOf<N>(frame(i.frame), i.axis, lane));
            });
            break;
        case Op::filterWeight:
            each(i, active, [&](std::size_t lane) HWY_ATTR {
                return weighted<N>(radiusOf(frame(i.frame), lane), n0);
            });
            break;
        case Op::noise:
            if (i.plane)
                noise(i, active, _program.planeOctaves.data() + i.first);
            else
                noise(i, active, _program.spaceOctaves.data() + i.first);
            break;
        case Op::source:
            source(i, active);
            break;
        case Op::sum:
            binary(i, active, [](const N& a, const N& b) HWY_ATTR { return a + b; });
            break;
        case Op::difference:
            binary(i, active, [](const N& a, const N& b) HWY_ATTR { return a - b; });
            break;
        case Op::product:
            binary(i, active, [](const N& a, const N& b) HWY_ATTR { return a * b; });
            break;
        case Op::scaled:
            unary(i, active, [&](const N& a) HWY_ATTR { return a * n0 + n1; });
            break;
        case Op::magnitude:
            unary(i, active, [](const N& a) HWY_ATTR { return magnitude(a); });
            break;
        case Op::square:
            unary(i, active, [](const N& a) HWY_ATTR { return squared(a); });
            break;
        case Op::root:
            unary(i, active, [](const N& a) HWY_ATTR {
                return root(most(a, fromConstant<N>(0.0F)));
            });
            break;
        case Op::least:
            binary(i, active, [](const N& a, const N& b) HWY_ATTR { return least(a, b); });
            break;
        case Op::most:
            binary(i, active, [](const N& a, const N& b) HWY_ATTR { return most(a, b); });
            break;
        case Op::smoothLeast:
            binary(i, active, [&](const N& a, const N& b) HWY_ATTR {
                return outward(smoothLeast(a, b, n0), slack);
            });
            break;
        case Op::smoothMost:
            binary(i, active, [&](const N& a, const N& b) HWY_ATTR {
                return outward(smoothMost(a, b, n0), slack);
            });
            break;
        case Op::smoothStep:
            unary(i, active, [&](const N& a) HWY_ATTR { return stepped(a, n0, n1); });
            break;
        case Op::curve: {
            const CurveSpan curve{_program.curvePieces.data() + i.first, i.count};
            unary(i, active, [&](const N& a) HWY_ATTR { return outward(curved(curve, a), slack); });
            break;
        }
        case Op::detail:
            detail(i, active);
            break;
        case Op::warp:
            warp(i, active);
            break;
        case Op::placed:
            place(i, active);
            break;
        case Op::keep: {
            const float* a = reg(i.a);
            float* to = reg(i.target);
            each(i, active, [&](std::size_t lane) HWY_ATTR {
                const N n = fromMemory<N>(a, lane);
                const Mask mask = decided(n, i.test, n0);
                return chosen(mask, decision(i, n), fromMemory<N>(to, lane));
            });
            break;
        }
        case Op::guard:
            break; // opens a section: see run
        }
    }

    template <typename Octave>
    void noise(const Instruction& i, std::uint64_t active, const Octave* octaves) const
    {
        switch (i.fractal) {
        case FractalKind::brownian:
            return noise<FractalKind::brownian>(i, active, octaves);
        case FractalKind::ridged:
            return noise<FractalKind::ridged>(i, active, octaves);
        case FractalKind::billow:
            return noise<FractalKind::billow>(i, active, octaves);
        }
    }

    template <FractalKind kFractal, typename Octave>
    HWY_NOINLINE void noise(const Instruction& i, std::uint64_t active, const Octave* octaves) const
    {
        const NoiseCall<N, Octave> call = noiseOf<N, Octave>(i.kind);
        each(i, active, [&](std::size_t lane) HWY_ATTR {
            const FrameBlock& f = frame(i.frame);
            const Point<N> p = pointOf<N>(f, lane);
            return outward(
                putTogether<kFractal, N, Octave>(
                    call, octaves, i.count, i.norms, p, radiusOf(f, lane)),
                i.slack);
        });
    }

    HWY_NOINLINE void detail(const Instruction& i, std::uint64_t active) const
    {
        const DetailOctave* octaves = _program.detailOctaves.data() + i.first;
        const float* base = reg(i.a);
        const float* strength = reg(i.b);
        each(i, active, [&](std::size_t lane) HWY_ATTR {
            const FrameBlock& f = frame(i.frame);
            const N value = detailed(
                fromMemory<N>(base, lane),
                octaves,
                i.count,
                fromMemory<N>(strength, lane),
                pointOf<N>(f, lane),
                radiusOf(f, lane));
            return outward(value, i.slack);
        });
    }

    HWY_NOINLINE void warp(const Instruction& i, std::uint64_t active) const
    {
        const FrameBlock& from = frame(i.frame);
        FrameBlock& to = frame(i.target);
        const float* by[3] = {reg(i.a), reg(i.b), reg(i.c)};
        const FloatTag f;
        const Floats stretch = constant(static_cast<float>(i.places[0]));
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const std::size_t lane = static_cast<std::size_t>(std::countr_zero(left)) * kLanes;
            for (std::size_t axis = 0; axis < 3; ++axis)
                setCoordinate(
                    moved(coordinateOf<N>(from, axis, lane), fromMemory<N>(by[axis], lane)),
                    to,
                    axis,
                    lane);
            const Radius radius = radiusOf(from, lane);
            hn::Store(hn::Mul(radius.low, stretch), f, to.radius[0] + lane);
            hn::Store(hn::Mul(radius.high, stretch), f, to.radius[1] + lane);
        }
    }

    HWY_NOINLINE void place(const Instruction& i, std::uint64_t active) const
    {
        const FrameBlock& from = frame(i.frame);
        FrameBlock& to = frame(i.target);
        const double inverse = 1.0 / i.places[3];
        const FloatTag f;
        const Floats shrink = constant(static_cast<float>(inverse));
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const std::size_t lane = static_cast<std::size_t>(std::countr_zero(left)) * kLanes;
            for (std::size_t axis = 0; axis < 3; ++axis)
                setCoordinate(
                    placedAt(coordinateOf<N>(from, axis, lane), i.places[axis], inverse),
                    to,
                    axis,
                    lane);
            const Radius radius = radiusOf(from, lane);
            hn::Store(hn::Mul(radius.low, shrink), f, to.radius[0] + lane);
            hn::Store(hn::Mul(radius.high, shrink), f, to.radius[1] + lane);
        }
    }

    /// Asks another field, with the points of all active groups at once.
    HWY_NOINLINE void source(const Instruction& i, std::uint64_t active) const
    {
        const Field& field = *_program.sources[i.first];
        const FrameBlock& f = frame(i.frame);
        float* to = reg(i.target);
        double x[kBlock];
        double y[kBlock];
        double z[kBlock];
        double radius[kBlock];
        std::size_t lanes[kBlock];
        std::size_t count = 0;
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const std::size_t lane = static_cast<std::size_t>(std::countr_zero(left)) * kLanes;
            for (std::size_t k = lane; k < lane + kLanes; ++k, ++count) {
                x[count] = f.at[0][k];
                y[count] = f.at[1][k];
                z[count] = f.at[2][k];
                radius[count] = double(f.radius[0][k]);
                lanes[count] = k;
            }
        }
        if constexpr (kParts<N> == kParts<Range>) {
            for (std::size_t k = 0; k < count; ++k) {
                const std::size_t lane = lanes[k];
                const glm::dvec3 at(x[k], y[k], z[k]);
                const glm::dvec3 reach(
                    double(f.change[0][lane]),
                    double(f.change[1][lane]),
                    double(f.change[2][lane]));
                const core::Interval range =
                    field.bounds({at - reach, at + reach}, {radius[k], double(f.radius[1][lane])});
                to[lane] = roundedDown(range.low);
                to[kBlock + lane] = -roundedDown(-range.high);
            }
        } else {
            float values[kBlock];
            const SampleBatch batch{{x, count}, {y, count}, {z, count}, {radius, count}};
            if constexpr (kParts<N> == kParts<Value>) {
                field.sample(batch, {values, count});
                for (std::size_t k = 0; k < count; ++k)
                    to[lanes[k]] = values[k];
            } else {
                double gx[kBlock];
                double gy[kBlock];
                double gz[kBlock];
                field.sampleWithGradient(
                    batch, {values, count}, {{gx, count}, {gy, count}, {gz, count}});
                for (std::size_t k = 0; k < count; ++k) {
                    const std::size_t lane = lanes[k];
                    to[lane] = values[k];
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        to[(axis + 1) * kBlock + lane] = static_cast<float>(
                            gx[k] * double(f.change[axis][lane]) +
                            gy[k] * double(f.change[3 + axis][lane]) +
                            gz[k] * double(f.change[6 + axis][lane]));
                }
            }
        }
    }

    static float roundedDown(double value)
    {
        const double held = std::clamp(value, -1e30, 1e30);
        return static_cast<float>(held - std::abs(held) * 2e-7);
    }

    const Program& _program;
    Scratch _scratch;
    std::size_t _first = 0;
    std::size_t _count = 0;
};

/// Runs the program over a batch, block by block; `finish` takes the results of each.
template <typename N, typename Finish>
void runOverBatch(const Program& program, const SampleBatch& batch, const Finish& finish)
{
    Machine<N> machine(program);
    if constexpr (kParts<N> == kParts<Slope>) {
        // The world's coordinates change with themselves.
        FrameBlock& world = machine.world();
        for (std::size_t k = 0; k < 9; ++k)
            std::fill_n(world.change[k], kBlock, k % 4 == 0 ? 1.0F : 0.0F);
    }
    for (std::size_t first = 0; first < batch.size(); first += kBatch) {
        machine.load(batch, first);
        machine.run(machine.groups());
        finish(machine);
    }
}

/// A program as a formula over ranges; see Batch-inl.h.
class BoundedProgram {
public:
    explicit BoundedProgram(const Program& program) : _machine(program) {}

    template <typename N>
    HWY_INLINE N at(const Point<N>& p, const Radius& radius) const
    {
        FrameBlock& world = _machine.world();
        const FloatTag f;
        setCoordinate(p.x, world, 0, 0);
        setCoordinate(p.y, world, 1, 0);
        setCoordinate(p.z, world, 2, 0);
        hn::Store(radius.low, f, world.radius[0]);
        hn::Store(radius.high, f, world.radius[1]);
        _machine.run(1);
        return allWhereUnknown(_machine.result(0));
    }

private:
    /// Ends beyond all numbers may come to differences without meaning.
    static HWY_INLINE Range allWhereUnknown(const Range& n)
    {
        const Floats most = constant(std::numeric_limits<float>::max());
        return {
            hn::IfThenElse(hn::IsNaN(n.low), hn::Neg(most), n.low),
            hn::IfThenElse(hn::IsNaN(n.high), most, n.high)};
    }

    Machine<Range> _machine;
};

} // namespace isofront::fields::graph::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

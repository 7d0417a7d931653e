// Runs a program on blocks of points, for each instruction set and each kind of number.

#if defined(ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#undef ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#else
#define ISOFRONT_FIELDS_GRAPH_MACHINE_INL_H
#endif

#include "graph/GridNoise-inl.h"
#include "graph/Operations-inl.h"
#include "graph/Program.h"
#include "graph/Scratch.h"
#include "simd/Batch-inl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

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

    /// Takes a row of a grid, of at most `kBatch` points; noise is taken from what rows share.
    void loadRow(const GridFrame& grid, GridNoise& noise)
    {
        _first = 0;
        _count = grid.at[0].size();
        _grid = &noise;
        const std::size_t filled = groups() * kLanes;
        const GridRow& row = noise.row();
        FrameBlock& frame = world();
        std::ranges::copy(grid.at[0], frame.at[0]);
        std::fill(frame.at[0] + _count, frame.at[0] + filled, frame.at[0][_count - 1]);
        std::fill_n(frame.at[1], filled, grid.at[1][row.y]);
        std::fill_n(frame.at[2], filled, grid.at[2][row.z]);
        std::fill_n(frame.radius[0], filled, grid.radius);
        std::fill_n(frame.radius[1], filled, grid.radius);
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
        if constexpr (kParts<N> == kParts<Value>)
            if (isShared(i))
                return sharedNoise(i, active, octaves);
        scatteredNoise(i, active, octaves);
    }

    /// True if rows of a grid share something of the instruction's noise.
    [[nodiscard]] bool isShared(const Instruction& i) const
    {
        return _grid != nullptr && _grid->of(i).frame != nullptr;
    }

    void sharedNoise(const Instruction& i, std::uint64_t active, const SpaceOctave* octaves) const
    {
        GridInstruction& shared = _grid->of(i);
        const auto sum = [&](auto over) {
            over(i, active, octaves, shared, _grid->row(), frame(i.frame), reg(i.target));
        };
        switch (i.fractal) {
        case FractalKind::brownian:
            return sum(&sumOverRow<FractalKind::brownian>);
        case FractalKind::ridged:
            return sum(&sumOverRow<FractalKind::ridged>);
        case FractalKind::billow:
            return sum(&sumOverRow<FractalKind::billow>);
        }
    }
    void sharedNoise(const Instruction& i, std::uint64_t active, const PlaneOctave* octaves) const
    {
        PlaneRows& plane = *_grid->of(i).plane;
        const std::size_t y = _grid->row().y;
        const FloatTag f;
        float* const to = reg(i.target);
        float* const kept = plane.row(y);
        const std::uint64_t unknown = active & ~plane.known(y);
        if (unknown != 0)
            scatteredNoise(i, unknown, octaves);
        forEachGroupOf(active, [&](std::size_t lane) HWY_ATTR {
            const bool isNew = (unknown >> (lane / kLanes) & 1U) != 0;
            float* const target = isNew ? kept : to;
            hn::StoreU(hn::LoadU(f, (isNew ? to : kept) + lane), f, target + lane);
        });
        plane.setKnown(y, unknown);
    }

    template <typename Octave>
    void scatteredNoise(const Instruction& i, std::uint64_t active, const Octave* octaves) const
    {
        switch (i.fractal) {
        case FractalKind::brownian:
            return noiseOfFractal<FractalKind::brownian>(i, active, octaves);
        case FractalKind::ridged:
            return noiseOfFractal<FractalKind::ridged>(i, active, octaves);
        case FractalKind::billow:
            return noiseOfFractal<FractalKind::billow>(i, active, octaves);
        }
    }

    template <FractalKind kFractal, typename Octave>
    HWY_NOINLINE void
    noiseOfFractal(const Instruction& i, std::uint64_t active, const Octave* octaves) const
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
        if constexpr (kParts<N> == kParts<Value>)
            if (isShared(i))
                return detailOverRow(
                    octaves,
                    active,
                    _grid->of(i),
                    _grid->row(),
                    frame(i.frame),
                    base,
                    strength,
                    reg(i.target));
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
    GridNoise* _grid = nullptr; ///< what rows of a grid share, while those are evaluated
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

/// Runs the program over the rows of a grid, block by block.
inline void runOverGrid(const Program& program, const SampleGrid& grid, float* values)
{
    // So few rows that what they share stays in a near cache.
    constexpr std::int64_t kMostRows = 16;
    const auto coordinates = [&](glm::length_t axis, std::int64_t first, std::int64_t count) {
        std::vector<double> all;
        for (std::int64_t i = 0; i < count; ++i) {
            const std::int64_t index = grid.first[axis] + first + i;
            all.push_back(grid.origin[axis] + grid.spacing * static_cast<double>(index));
        }
        return all;
    };
    Machine<Value> machine(program);
    constexpr auto kMostPoints = static_cast<std::int64_t>(kBatch);
    for (std::int64_t y = 0; y < grid.count.y; y += kMostRows) {
        for (std::int64_t x = 0; x < grid.count.x; x += kMostPoints) {
            const GridFrame block{
                {coordinates(0, x, std::min(kMostPoints, grid.count.x - x)),
                 coordinates(1, y, std::min(kMostRows, grid.count.y - y)),
                 coordinates(2, 0, grid.count.z)},
                grid.spacing,
                static_cast<float>(grid.radius)};
            GridNoise noise(program, block);
            for (std::size_t k = 0; k < block.at[2].size(); ++k) {
                for (std::size_t j = 0; j < block.at[1].size(); ++j) {
                    noise.startRow({j, k});
                    machine.loadRow(block, noise);
                    machine.run(machine.groups());
                    const std::size_t row = k * static_cast<std::size_t>(grid.count.y) +
                                            static_cast<std::size_t>(y) + j;
                    machine.storeValues(
                        values + row * static_cast<std::size_t>(grid.count.x) +
                        static_cast<std::size_t>(x));
                }
            }
        }
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

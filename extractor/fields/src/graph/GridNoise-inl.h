// The noise of a program over the rows of a grid, for each instruction set: what it is at single
// points but for rounding, with the work that points of a grid have in common done once.

#if defined(ISOFRONT_FIELDS_GRAPH_GRID_NOISE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_GRAPH_GRID_NOISE_INL_H
#undef ISOFRONT_FIELDS_GRAPH_GRID_NOISE_INL_H
#else
#define ISOFRONT_FIELDS_GRAPH_GRID_NOISE_INL_H
#endif

#include "graph/Operations-inl.h"
#include "graph/Program.h"
#include "simd/NoiseGrid-inl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::graph::HWY_NAMESPACE {

/// A block of a grid as a frame of the program sees it: coordinates along each axis. Nothing for
/// frames in which a row of the grid is no row, as within a warp.
struct GridFrame {
    std::array<std::vector<double>, 3> at;
    double spacing = 1;
    float radius = 0;

    /// True if doubles tell neighbouring points apart, with much to spare.
    [[nodiscard]] bool isFineEnough() const
    {
        constexpr double kFar = 0x1p40;
        const auto reach = [](const std::vector<double>& c) {
            return std::max(std::abs(c.front()), std::abs(c.back()));
        };
        return std::max({reach(at[0]), reach(at[1]), reach(at[2])}) < kFar * spacing;
    }
};

/// The frames of a program over a block, by number; the same operations as the machine's, in the
/// same order.
inline std::vector<std::optional<GridFrame>>
gridFramesOf(const Program& program, const GridFrame& world)
{
    std::vector<std::optional<GridFrame>> frames(program.frames);
    frames[0] = world;
    for (const Instruction& i : program.instructions) {
        if (i.op != Op::placed || !frames[i.frame])
            continue;
        const double inverse = 1.0 / i.places[3];
        GridFrame frame = *frames[i.frame];
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (double& c : frame.at[axis])
                c = (c - i.places[axis]) * inverse;
        frame.spacing *= inverse;
        frame.radius *= static_cast<float>(inverse);
        frames[i.target] = std::move(frame);
    }
    return frames;
}

/// Where in a block a row of samples lies.
struct GridRow {
    std::size_t y = 0;
    std::size_t z = 0;
};

/// An octave in space over the rows of a block.
class RowOctave {
public:
    RowOctave(const SpaceOctave& octave, NoiseKind kind, const GridFrame& frame)
        : _factor(hn::GetLane(
              weight<Value>({constant(frame.radius), constant(frame.radius)}, octave.filterCycles)
                  .v))
    {
        if (_factor != 0 &&
            frame.spacing * std::max(octave.frequency[0], octave.frequency[1]) <= 1.0) {
            if (kind == NoiseKind::gradient)
                _octave.template emplace<CoherentOctave<NoiseKind::gradient>>(
                    octave, frame.at[0], frame.at[1]);
            else if (kind == NoiseKind::value)
                _octave.template emplace<CoherentOctave<NoiseKind::value>>(
                    octave, frame.at[0], frame.at[1]);
        }
    }

    /// The weight that the filter gives it, the same everywhere.
    [[nodiscard]] HWY_INLINE float factor() const { return _factor; }

    /// Calls `body(noise)`, where noise(lane) is that of a group of lanes.
    /// @param scattered  the same for single points
    template <typename Scattered, typename Body>
    HWY_INLINE void withRow(
        const GridFrame& frame, const GridRow& row, const Scattered& scattered, const Body& body)
    {
        const auto sampled = [&](auto& octave) HWY_ATTR {
            if (_slice != row.z + 1) {
                octave.startSlice(frame.at[2][row.z]);
                _slice = row.z + 1;
            }
            const auto samples = octave.startRow(row.y);
            body([&](std::size_t lane) HWY_ATTR { return samples.noise(lane / kLanes); });
        };
        if (auto* gradient = std::get_if<CoherentOctave<NoiseKind::gradient>>(&_octave))
            sampled(*gradient);
        else if (auto* value = std::get_if<CoherentOctave<NoiseKind::value>>(&_octave))
            sampled(*value);
        else
            body(scattered);
    }

private:
    std::variant<
        std::monostate,
        CoherentOctave<NoiseKind::gradient>,
        CoherentOctave<NoiseKind::value>>
        _octave;
    float _factor;
    std::size_t _slice = 0; ///< where it is, counted from 1
};

/// What noise over the plane has come to: the same in every slice.
class PlaneRows {
public:
    PlaneRows(std::size_t rows) : _values(rows * kBlock), _known(rows, 0) {}

    [[nodiscard]] std::uint64_t known(std::size_t row) const { return _known[row]; }
    void setKnown(std::size_t row, std::uint64_t groups) { _known[row] |= groups; }
    [[nodiscard]] float* row(std::size_t y) { return _values.data() + y * kBlock; }

private:
    std::vector<float> _values;
    std::vector<std::uint64_t> _known; ///< groups of lanes, bit by bit
};

/// What the noise of one instruction shares over a block.
struct GridInstruction {
    const GridFrame* frame = nullptr; ///< null: point by point
    std::vector<RowOctave> octaves = {};
    std::optional<PlaneRows> plane = {};
};

/// The noise of a program over one block of a grid.
class GridNoise {
public:
    GridNoise(const Program& program, const GridFrame& world)
        : _program(program), _frames(gridFramesOf(program, world)),
          _instructions(program.instructions.size())
    {
        for (std::size_t at = 0; at < _instructions.size(); ++at) {
            const Instruction& i = program.instructions[at];
            if ((i.op != Op::noise && i.op != Op::detail) || !_frames[i.frame] ||
                !_frames[i.frame]->isFineEnough())
                continue;
            GridInstruction& shared = _instructions[at];
            shared.frame = &*_frames[i.frame];
            if (i.op == Op::noise && i.plane)
                shared.plane.emplace(world.at[1].size());
            else
                for (std::uint32_t k = 0; k < i.count; ++k) {
                    if (i.op == Op::noise) {
                        shared.octaves.emplace_back(
                            program.spaceOctaves[i.first + k], i.kind, *shared.frame);
                    } else {
                        const DetailOctave& octave = program.detailOctaves[i.first + k];
                        shared.octaves.emplace_back(octave.noise, octave.kind, *shared.frame);
                    }
                }
        }
    }

    void startRow(const GridRow& row) { _row = row; }
    [[nodiscard]] const GridRow& row() const { return _row; }

    /// What an instruction shares; its frame is null if that is nothing.
    [[nodiscard]] GridInstruction& of(const Instruction& instruction)
    {
        return _instructions[static_cast<std::size_t>(&instruction - _program.instructions.data())];
    }

private:
    const Program& _program;
    std::vector<std::optional<GridFrame>> _frames;
    std::vector<GridInstruction> _instructions;
    GridRow _row;
};

/// Calls `body(lane)` for each group of lanes in the set.
template <typename Body>
HWY_INLINE void forEachGroupOf(std::uint64_t groups, const Body& body)
{
    for (std::uint64_t left = groups; left != 0; left &= left - 1)
        body(static_cast<std::size_t>(std::countr_zero(left)) * kLanes);
}

/// Octaves put together as `putTogether` does, octave after octave.
template <FractalKind kFractal>
HWY_NOINLINE void sumOverRow(
    const Instruction& i,
    std::uint64_t active,
    const SpaceOctave* octaves,
    GridInstruction& shared,
    const GridRow& row,
    const FrameBlock& frame,
    float* to)
{
    const FloatTag f;
    alignas(64) float carrier[kFractal == FractalKind::ridged ? kBlock : 1];
    forEachGroupOf(active, [&](std::size_t lane) HWY_ATTR {
        hn::Store(hn::Zero(f), f, to + lane);
        if constexpr (kFractal == FractalKind::ridged)
            hn::Store(constant(1.0F), f, carrier + lane);
    });
    const NoiseCall<Value, SpaceOctave> call = noiseOf<Value, SpaceOctave>(i.kind);
    for (std::size_t k = 0; k < shared.octaves.size(); ++k) {
        RowOctave& octave = shared.octaves[k];
        if (octave.factor() == 0)
            break;
        const Value factor = fromConstant<Value>(octave.factor());
        const auto scattered = [&](std::size_t lane) HWY_ATTR {
            return call(octaves[k], pointOf<Value>(frame, lane));
        };
        octave.withRow(*shared.frame, row, scattered, [&](const auto& noise) HWY_ATTR {
            forEachGroupOf(active, [&](std::size_t lane) HWY_ATTR {
                FractalSum<kFractal, Value> fractal{
                    {hn::Load(f, to + lane)}, fromConstant<Value>(1.0F)};
                if constexpr (kFractal == FractalKind::ridged)
                    fractal.carrier = {hn::Load(f, carrier + lane)};
                fractal.add(noise(lane), octaves[k].amplitude, factor, i.norms);
                hn::Store(fractal.sum.v, f, to + lane);
                if constexpr (kFractal == FractalKind::ridged)
                    hn::Store(fractal.carrier.v, f, carrier + lane);
            });
        });
    }
}

/// Detail as `detailed` adds it, octave after octave.
/// @param base, strength  may be where the results go
HWY_NOINLINE void detailOverRow(
    const DetailOctave* octaves,
    std::uint64_t active,
    GridInstruction& shared,
    const GridRow& row,
    const FrameBlock& frame,
    const float* base,
    const float* strength,
    float* to)
{
    const FloatTag f;
    alignas(64) float values[kBlock];
    alignas(64) float near[kBlock];
    forEachGroupOf(active, [&](std::size_t lane) HWY_ATTR {
        hn::Store(hn::Load(f, base + lane), f, values + lane);
    });
    std::uint64_t open = active; // groups that later octaves may still change
    for (std::size_t k = 0; k < shared.octaves.size() && open != 0; ++k) {
        const DetailOctave& octave = octaves[k];
        RowOctave& rowOctave = shared.octaves[k];
        const Value factor = fromConstant<Value>(rowOctave.factor());
        std::uint64_t wanted = 0;
        forEachGroupOf(open, [&](std::size_t lane) HWY_ATTR {
            const Value value{hn::Load(f, values + lane)};
            const Value opened =
                1.0F - smoothStep(magnitude(value), octave.remaining, 2.0F * octave.remaining);
            const std::uint64_t group = std::uint64_t{1} << (lane / kLanes);
            if (vanishes(opened)) {
                open &= ~group;
                return;
            }
            const Value share = opened * factor;
            if (!vanishes(share))
                wanted |= group;
            hn::Store(share.v, f, near + lane);
        });
        if (wanted == 0)
            continue;
        const auto call = noiseOf<Value, SpaceOctave>(octave.kind);
        const auto scattered = [&](std::size_t lane) HWY_ATTR {
            return call(octave.noise, pointOf<Value>(frame, lane));
        };
        rowOctave.withRow(*shared.frame, row, scattered, [&](const auto& noise) HWY_ATTR {
            forEachGroupOf(wanted, [&](std::size_t lane) HWY_ATTR {
                const Value value{hn::Load(f, values + lane)};
                const Value share{hn::Load(f, near + lane)};
                const Value factors{hn::Load(f, strength + lane)};
                const Value sum = value + noise(lane) * octave.noise.amplitude * share * factors;
                hn::Store(sum.v, f, values + lane);
            });
        });
    }
    forEachGroupOf(active, [&](std::size_t lane) HWY_ATTR {
        hn::Store(hn::Load(f, values + lane), f, to + lane);
    });
}

} // namespace isofront::fields::graph::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

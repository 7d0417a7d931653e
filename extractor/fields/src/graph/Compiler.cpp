#include "graph/Lowering.h"
#include "graph/Program.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Hash.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace isofront::fields::graph {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

FractalSettings octavesOf(const OctaveSettings& settings)
{
    return {
        .wavelength = settings.wavelength,
        .octaves = settings.octaves,
        .amplitude = settings.amplitude,
        .lacunarity = settings.lacunarity,
        .gain = settings.gain,
        .stretch = settings.stretch};
}

/// Slopes at the points, such that a cubic between two of them is monotone: zero at turns, else the
/// weighted harmonic mean of the slopes on both sides.
std::vector<double> monotoneSlopes(const std::vector<CurvePoint>& points)
{
    std::vector<double> slopes(points.size(), 0.0);
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const double before = points[i].at - points[i - 1].at;
        const double after = points[i + 1].at - points[i].at;
        const double left = (points[i].value - points[i - 1].value) / before;
        const double right = (points[i + 1].value - points[i].value) / after;
        if (left * right <= 0)
            continue;
        const double w1 = 2 * after + before;
        const double w2 = after + 2 * before;
        slopes[i] = (w1 + w2) / (w1 / left + w2 / right);
    }
    return slopes;
}

/// Pieces before, between and after the points.
std::vector<CurvePiece> piecesOf(const std::vector<CurvePoint>& points)
{
    const std::vector<double> slopes = monotoneSlopes(points);
    std::vector<CurvePiece> pieces;
    const auto number = [](double value) { return static_cast<float>(value); };
    for (std::size_t i = 0; i < points.size(); ++i) {
        const CurvePoint& p = points[i];
        CurvePiece piece{number(p.at), {number(p.value)}, number(p.value), number(p.value)};
        if (i + 1 < points.size()) {
            const CurvePoint& q = points[i + 1];
            const double width = q.at - p.at;
            const double mean = (q.value - p.value) / width;
            piece.coefficients[1] = number(slopes[i]);
            piece.coefficients[2] = number((3 * mean - 2 * slopes[i] - slopes[i + 1]) / width);
            piece.coefficients[3] =
                number((slopes[i] + slopes[i + 1] - 2 * mean) / (width * width));
            piece.low = number(std::min(p.value, q.value));
            piece.high = number(std::max(p.value, q.value));
        }
        pieces.push_back(piece);
    }
    return pieces;
}

/// Where one input of an operation decides the result alone.
struct Shortcut {
    std::uint32_t decider; ///< which input
    std::uint32_t other;
    Test test;
    double threshold;
};

class Compiler {
public:
    Compiler(const Node& node, const GraphSettings& settings)
        : _items(lowered(node)), _settings(settings), _seed(core::mixed(settings.seed)),
          _emitted(_items.items.size(), 0)
    {
        ISOFRONT_ASSERT(!_items.areTooMany, "the graph has too many nodes");
    }

    Program run()
    {
        emit(_items.result);
        _program.registers = assignRegisters();
        return std::move(_program);
    }

private:
    [[nodiscard]] const Item& item(std::uint32_t index) const { return _items.items[index]; }

    // ---- Order ----------------------------------------------------------------------------------

    void emit(std::uint32_t index)
    {
        if (index == 0 || _emitted[index] != 0)
            return;
        const Item& it = item(index);
        emit(it.frame);
        const std::optional<Shortcut> shortcut =
            _depth < kDeepestGuards ? shortcutOf(index) : std::nullopt;
        if (!shortcut) {
            for (std::uint32_t i = 0; i < it.inputCount; ++i)
                emit(it.inputs[i]);
            append(index);
            return;
        }
        const std::uint32_t other = it.inputs[shortcut->other];
        emit(it.inputs[shortcut->decider]);
        const std::vector<char> exclusive = exclusiveTo(index, other);
        const std::vector<char> needed = neededBy(other, kNone, kNone);
        for (std::uint32_t i = 1; i < _items.items.size(); ++i)
            if (needed[i] != 0 && exclusive[i] == 0)
                emit(i);
        const std::size_t guard = appendTest(Op::guard, index, *shortcut);
        ++_depth;
        emit(other);
        append(index);
        --_depth;
        appendTest(Op::keep, index, *shortcut);
        _program.instructions[guard].end = static_cast<std::uint32_t>(_program.instructions.size());
    }

    /// The items that `from` needs, itself included; without those that are needed only as the
    /// input `target` of `user`.
    [[nodiscard]] std::vector<char>
    neededBy(std::uint32_t from, std::uint32_t user, std::uint32_t target) const
    {
        std::vector<char> needed(_items.items.size(), 0);
        needed[from] = 1;
        // Inputs come before what uses them.
        for (std::uint32_t i = from; i > 0; --i) {
            if (needed[i] == 0)
                continue;
            needed[item(i).frame] = 1;
            for (std::uint32_t k = 0; k < item(i).inputCount; ++k)
                if (i != user || item(i).inputs[k] != target)
                    needed[item(i).inputs[k]] = 1;
        }
        return needed;
    }

    /// The items that only the input `target` of `user` needs.
    [[nodiscard]] std::vector<char> exclusiveTo(std::uint32_t user, std::uint32_t target) const
    {
        std::vector<char> exclusive = neededBy(target, kNone, kNone);
        const std::vector<char> elsewhere = neededBy(_items.result, user, target);
        for (std::size_t i = 0; i < exclusive.size(); ++i)
            exclusive[i] = exclusive[i] != 0 && elsewhere[i] == 0 && _emitted[i] == 0 ? 1 : 0;
        return exclusive;
    }

    [[nodiscard]] int costExclusiveTo(std::uint32_t user, std::uint32_t target) const
    {
        const std::vector<char> exclusive = exclusiveTo(user, target);
        int cost = 0;
        for (std::uint32_t i = 1; i < exclusive.size(); ++i)
            cost += exclusive[i] != 0 && item(i).isCostly ? 1 : 0;
        return cost;
    }

    // ---- Shortcuts ------------------------------------------------------------------------------

    [[nodiscard]] std::optional<Shortcut> shortcutOf(std::uint32_t index) const
    {
        const Item& it = item(index);
        if (it.op == Op::detail) {
            const double reach = detailReach(index);
            return Shortcut{0, 1, Test::beyond, 2 * reach};
        }
        if (it.inputCount != 2 || it.inputs[0] == it.inputs[1])
            return std::nullopt;
        std::optional<Shortcut> best;
        int saved = 0;
        for (std::uint32_t other = 0; other < 2; ++other) {
            const std::optional<Shortcut> candidate = decidedWithout(it, other);
            const int cost = candidate ? costExclusiveTo(index, it.inputs[other]) : 0;
            if (cost > saved) {
                best = candidate;
                saved = cost;
            }
        }
        return best;
    }

    [[nodiscard]] std::optional<Shortcut> decidedWithout(const Item& it, std::uint32_t other) const
    {
        const std::uint32_t decider = 1 - other;
        const core::Interval& range = item(it.inputs[other]).range;
        const core::Interval& own = item(it.inputs[decider]).range;
        const double width = it.node->numbers[0];
        // A little aside, for what rounding may do to the other input.
        const auto aside = [&](double limit, double join) {
            return 1e-5 * (std::abs(limit) + join);
        };
        switch (it.op) {
        case Op::least:
            if (range.low > -1e30)
                return Shortcut{decider, other, Test::below, range.low - aside(range.low, 0)};
            break;
        case Op::most:
            if (range.high < 1e30)
                return Shortcut{decider, other, Test::above, range.high + aside(range.high, 0)};
            break;
        case Op::smoothLeast:
            if (range.low > -1e30)
                return Shortcut{
                    decider, other, Test::below, range.low - width - aside(range.low, width)};
            break;
        case Op::smoothMost:
            if (range.high < 1e30)
                return Shortcut{
                    decider, other, Test::above, range.high + width + aside(range.high, width)};
            break;
        case Op::product:
            // A factor that ends at zero, like a smooth step, often is zero.
            if (own.low == 0 || own.high == 0)
                return Shortcut{decider, other, Test::zero, 0};
            break;
        default:
            break;
        }
        return std::nullopt;
    }

    // ---- Instructions ---------------------------------------------------------------------------

    [[nodiscard]] Instruction instructionOf(std::uint32_t index) const
    {
        const Item& it = item(index);
        Instruction instruction;
        instruction.op = it.op;
        instruction.target = index;
        instruction.a = it.inputs[0];
        instruction.b = it.inputs[1];
        instruction.c = it.inputs[2];
        instruction.frame = it.frame;
        for (std::size_t i = 0; i < 3; ++i)
            instruction.numbers[i] = static_cast<float>(it.node->numbers[i]);
        return instruction;
    }

    std::size_t appendTest(Op op, std::uint32_t index, const Shortcut& shortcut)
    {
        Instruction instruction = instructionOf(index);
        instruction.op = op;
        instruction.test = shortcut.test;
        instruction.a = item(index).inputs[shortcut.decider];
        instruction.numbers[0] = static_cast<float>(shortcut.threshold);
        _program.instructions.push_back(instruction);
        return _program.instructions.size() - 1;
    }

    void append(std::uint32_t index)
    {
        const NodeData& node = *item(index).node;
        Instruction instruction = instructionOf(index);
        switch (node.op) {
        case Op::position:
            instruction.axis = static_cast<std::uint8_t>(node.which);
            break;
        case Op::filterWeight:
            instruction.numbers[0] = static_cast<float>(_settings.filterStrength / node.numbers[0]);
            break;
        case Op::noise:
            appendOctaves(instruction, node.layers[0]);
            break;
        case Op::detail:
            appendDetail(instruction, index);
            break;
        case Op::source:
            instruction.first = static_cast<std::uint32_t>(_program.sources.size());
            _program.sources.push_back(node.field);
            break;
        case Op::smoothLeast:
        case Op::smoothMost:
            instruction.slack = 1e-6F * instruction.numbers[0];
            break;
        case Op::curve: {
            instruction.first = static_cast<std::uint32_t>(_program.curvePieces.size());
            const std::vector<CurvePiece> pieces = piecesOf(node.points);
            instruction.count = static_cast<std::uint32_t>(pieces.size());
            float largest = 0;
            for (const CurvePiece& piece : pieces)
                largest = std::max({largest, std::abs(piece.low), std::abs(piece.high)});
            instruction.slack = 4e-6F * largest;
            _program.curvePieces.insert(_program.curvePieces.end(), pieces.begin(), pieces.end());
            break;
        }
        case Op::warp:
        case Op::placed:
            std::copy_n(node.numbers.begin(), 4, instruction.places);
            break;
        default:
            break;
        }
        _program.instructions.push_back(instruction);
        _emitted[index] = 1;
    }

    [[nodiscard]] std::uint64_t seedOf(const OctaveSettings& settings) const
    {
        return core::hashCombined(_seed, settings.seed);
    }

    [[nodiscard]] double kappaOf(const OctaveSettings& settings) const
    {
        return settings.filtered ? _settings.filterStrength : 0.0;
    }

    void noteWavelengths(const OctaveSettings& settings)
    {
        double wavelength = settings.wavelength / std::max(1.0, settings.stretch);
        for (int i = 1; i < settings.octaves; ++i)
            wavelength /= settings.lacunarity;
        if (settings.octaves > 0 && (_program.shortest == 0 || wavelength < _program.shortest))
            _program.shortest = wavelength;
    }

    void appendOctaves(Instruction& instruction, const OctaveSettings& settings)
    {
        noteWavelengths(settings);
        instruction.plane = settings.plane;
        instruction.kind = settings.kind;
        instruction.fractal = settings.fractal;
        instruction.norms = normsOf(settings);
        instruction.count = static_cast<std::uint32_t>(settings.octaves);
        // Ridges multiply the errors of those that carry them.
        instruction.slack = (settings.fractal == FractalKind::ridged ? 2e-5F : 4e-6F) *
                            static_cast<float>(reachOf(settings));
        const auto append = [&](auto& all, const auto& drawn) {
            instruction.first = static_cast<std::uint32_t>(all.size());
            all.insert(all.end(), drawn.begin(), drawn.end());
        };
        const double kappa = kappaOf(settings);
        if (settings.plane)
            append(
                _program.planeOctaves,
                planeOctaves(octavesOf(settings), seedOf(settings), kappa, settings.kind));
        else
            append(
                _program.spaceOctaves, spaceOctaves(octavesOf(settings), seedOf(settings), kappa));
    }

    /// The most by which detail moves a value, and what is reserved for later.
    [[nodiscard]] double detailReach(std::uint32_t index) const
    {
        const NodeData& node = *item(index).node;
        double reach = 0;
        for (const OctaveSettings& layer : node.layers)
            reach += reachOf(layer);
        return reach * strongest(index) + node.numbers[0];
    }

    /// The largest factor that the strength can be.
    [[nodiscard]] double strongest(std::uint32_t index) const
    {
        const core::Interval& strength = item(item(index).inputs[1]).range;
        const double most = std::max(-strength.low, strength.high);
        return std::isfinite(most) ? most : 1.0;
    }

    void appendDetail(Instruction& instruction, std::uint32_t index)
    {
        const NodeData& node = *item(index).node;
        std::vector<DetailOctave> octaves;
        double reach = 0;
        for (const OctaveSettings& layer : node.layers) {
            noteWavelengths(layer);
            for (const SpaceOctave& octave :
                 spaceOctaves(octavesOf(layer), seedOf(layer), kappaOf(layer)))
                octaves.push_back({octave, layer.kind, limitsOf(layer).magnitude});
            reach += reachOf(layer);
        }
        std::stable_sort(
            octaves.begin(), octaves.end(), [](const DetailOctave& a, const DetailOctave& b) {
                return std::abs(a.noise.amplitude) > std::abs(b.noise.amplitude);
            });
        instruction.first = static_cast<std::uint32_t>(_program.detailOctaves.size());
        instruction.count = static_cast<std::uint32_t>(octaves.size());
        instruction.slack = 4e-6F * static_cast<float>(reach * strongest(index));
        double remaining = node.numbers[0];
        for (std::size_t i = octaves.size(); i-- > 0;) {
            remaining += double(octaves[i].remaining) *
                         std::abs(double(octaves[i].noise.amplitude)) * strongest(index);
            octaves[i].remaining = static_cast<float>(remaining);
        }
        _program.detailOctaves.insert(_program.detailOctaves.end(), octaves.begin(), octaves.end());
    }

    // ---- Registers ------------------------------------------------------------------------------

    [[nodiscard]] static bool isFrame(Op op) { return op == Op::warp || op == Op::placed; }

    /// How many of a, b and c an instruction reads.
    [[nodiscard]] std::uint32_t readsOf(const Instruction& instruction) const
    {
        if (instruction.op == Op::guard || instruction.op == Op::keep)
            return 1;
        return item(instruction.target).inputCount;
    }

    /// Puts registers and frames in the place of items; a register is used again as soon as no
    /// later instruction reads it.
    std::uint32_t assignRegisters()
    {
        std::vector<Instruction>& all = _program.instructions;
        std::vector<std::size_t> lastRead(_items.items.size(), 0);
        for (std::size_t at = 0; at < all.size(); ++at) {
            const std::uint32_t operands[3] = {all[at].a, all[at].b, all[at].c};
            for (std::uint32_t k = 0; k < readsOf(all[at]); ++k)
                lastRead[operands[k]] = at;
            // What is decided is there until it is kept.
            lastRead[all[at].target] = std::max(lastRead[all[at].target], at);
        }
        lastRead[_items.result] = all.size();

        std::vector<std::uint32_t> place(_items.items.size(), kNone);
        place[0] = 0; // the world's frame
        std::vector<std::uint32_t> unused;
        std::uint32_t registers = 0;
        for (std::size_t at = 0; at < all.size(); ++at) {
            Instruction& instruction = all[at];
            std::uint32_t* operands[3] = {&instruction.a, &instruction.b, &instruction.c};
            const std::uint32_t reads = readsOf(instruction);
            std::uint32_t ended[3] = {kNone, kNone, kNone};
            for (std::uint32_t k = 0; k < reads; ++k) {
                const std::uint32_t operand = *operands[k];
                *operands[k] = place[operand];
                if (lastRead[operand] == at && std::find(ended, ended + k, operand) == ended + k)
                    ended[k] = operand;
            }
            for (const std::uint32_t operand : ended)
                if (operand != kNone)
                    unused.push_back(place[operand]);
            instruction.frame = place[instruction.frame];
            std::uint32_t& target = place[instruction.target];
            if (target == kNone && isFrame(instruction.op)) {
                target = _program.frames++;
            } else if (target == kNone) {
                if (unused.empty())
                    unused.push_back(registers++);
                target = unused.back();
                unused.pop_back();
            }
            instruction.target = target;
        }
        _program.result = place[_items.result];
        return registers;
    }

    Items _items;
    GraphSettings _settings;
    std::uint64_t _seed;
    std::vector<char> _emitted;
    std::size_t _depth = 0;
    Program _program;
};

} // namespace

Program compiled(const Node& node, const GraphSettings& settings)
{
    return Compiler(node, settings).run();
}

} // namespace isofront::fields::graph

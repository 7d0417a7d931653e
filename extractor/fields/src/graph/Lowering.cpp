#include "graph/Lowering.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace isofront::fields::graph {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

core::Interval product(const core::Interval& a, const core::Interval& b)
{
    core::Interval range{kInfinity, -kInfinity};
    for (const double x : {a.low, a.high})
        for (const double y : {b.low, b.high}) {
            const double p = x == 0 || y == 0 ? 0.0 : x * y;
            range = {std::min(range.low, p), std::max(range.high, p)};
        }
    return range;
}

core::Interval magnitude(const core::Interval& a)
{
    return {std::max({0.0, a.low, -a.high}), std::max(-a.low, a.high)};
}

core::Interval rangeOf(const Item& item, const std::vector<Item>& items)
{
    const NodeData& node = *item.node;
    const auto input = [&](std::size_t i) { return items[item.inputs[i]].range; };
    const auto& n = node.numbers;
    switch (item.op) {
    case Op::constant:
        return {n[0], n[0]};
    case Op::filterWeight:
        return {0, 1};
    case Op::noise:
        return rangeOf(node.layers[0]);
    case Op::sum:
        return {input(0).low + input(1).low, input(0).high + input(1).high};
    case Op::difference:
        return {input(0).low - input(1).high, input(0).high - input(1).low};
    case Op::product:
        return product(input(0), input(1));
    case Op::scaled: {
        const core::Interval p = product(input(0), {n[0], n[0]});
        return {p.low + n[1], p.high + n[1]};
    }
    case Op::magnitude:
        return magnitude(input(0));
    case Op::square: {
        const core::Interval m = magnitude(input(0));
        return {m.low * m.low, m.high * m.high};
    }
    case Op::root:
        return {std::sqrt(std::max(0.0, input(0).low)), std::sqrt(std::max(0.0, input(0).high))};
    case Op::least:
        return {std::min(input(0).low, input(1).low), std::min(input(0).high, input(1).high)};
    case Op::most:
        return {std::max(input(0).low, input(1).low), std::max(input(0).high, input(1).high)};
    case Op::smoothLeast:
        return {
            std::min(input(0).low, input(1).low) - 0.25 * n[0],
            std::min(input(0).high, input(1).high)};
    case Op::smoothMost:
        return {
            std::max(input(0).low, input(1).low),
            std::max(input(0).high, input(1).high) + 0.25 * n[0]};
    case Op::smoothStep:
        return {0, 1};
    case Op::curve: {
        core::Interval range{kInfinity, -kInfinity};
        for (const CurvePoint& point : node.points)
            range = {std::min(range.low, point.value), std::max(range.high, point.value)};
        return range;
    }
    case Op::detail: {
        double reach = 0;
        for (const OctaveSettings& layer : node.layers)
            reach += reachOf(layer);
        reach *= magnitude(input(1)).high;
        return {input(0).low - reach, input(0).high + reach};
    }
    default:
        return {};
    }
}

bool isCostlyByItself(Op op)
{
    return op == Op::noise || op == Op::detail || op == Op::source;
}

class Lowering {
public:
    Items run(const Node& node)
    {
        _items.items.emplace_back(); // the world
        _items.result = lower(node, 0);
        return std::move(_items);
    }

private:
    std::uint32_t lower(const Node& node, std::uint32_t frame)
    {
        if (_items.areTooMany)
            return 0;
        // What is shared is visited once: a graph of n nodes can have 2^n paths.
        const auto visited = _visited.find({node.data().get(), frame});
        if (visited != _visited.end())
            return visited->second;
        const std::uint32_t item = lowerAnew(*node.data(), frame);
        _visited.emplace(std::pair(node.data().get(), frame), item);
        return item;
    }

    std::uint32_t lowerAnew(const NodeData& data, std::uint32_t frame)
    {
        if (data.op == Op::warp) {
            const std::array<std::uint32_t, 3> by{
                lower(data.inputs[1], frame),
                lower(data.inputs[2], frame),
                lower(data.inputs[3], frame)};
            return lower(data.inputs[0], added(data, frame, by, 3));
        }
        if (data.op == Op::placed)
            return lower(data.inputs[0], added(data, frame, {}, 0));
        std::array<std::uint32_t, 3> inputs{};
        for (std::size_t i = 0; i < data.inputs.size(); ++i)
            inputs[i] = lower(data.inputs[i], frame);
        const bool placeless = data.op != Op::position && data.op != Op::filterWeight &&
                               data.op != Op::noise && data.op != Op::source &&
                               data.op != Op::detail;
        return added(
            data, placeless ? 0 : frame, inputs, static_cast<std::uint32_t>(data.inputs.size()));
    }

    std::uint32_t added(
        const NodeData& data,
        std::uint32_t frame,
        const std::array<std::uint32_t, 3>& inputs,
        std::uint32_t inputCount)
    {
        const Key key = keyOf(data, frame, inputs);
        const auto found = _known.find(key);
        if (found != _known.end())
            return found->second;
        Item item{data.op, frame, inputs, inputCount, &data, {}, isCostlyByItself(data.op)};
        item.range = rangeOf(item, _items.items);
        if (std::isnan(item.range.low) || std::isnan(item.range.high))
            item.range = {};
        const auto index = static_cast<std::uint32_t>(_items.items.size());
        if (index > kMostNodes) {
            _items.areTooMany = true;
            return 0;
        }
        _items.items.push_back(item);
        _known.emplace(key, index);
        return index;
    }

    // All that makes two items the same.
    using Key = std::vector<std::uint64_t>;
    static Key
    keyOf(const NodeData& data, std::uint32_t frame, const std::array<std::uint32_t, 3>& inputs)
    {
        Key key{static_cast<std::uint64_t>(data.op), frame, inputs[0], inputs[1], inputs[2]};
        const auto addDouble = [&](double value) {
            key.push_back(std::bit_cast<std::uint64_t>(value));
        };
        for (const double number : data.numbers)
            addDouble(number);
        key.push_back(data.which);
        for (const OctaveSettings& layer : data.layers) {
            for (const double number :
                 {layer.wavelength,
                  layer.amplitude,
                  layer.lacunarity,
                  layer.gain,
                  layer.stretch,
                  layer.carry})
                addDouble(number);
            key.push_back(static_cast<std::uint64_t>(layer.octaves));
            key.push_back((layer.plane ? 1U : 0U) + (layer.filtered ? 2U : 0U));
            key.push_back(static_cast<std::uint64_t>(layer.kind));
            key.push_back(static_cast<std::uint64_t>(layer.fractal));
            key.push_back(layer.seed);
        }
        for (const CurvePoint& point : data.points) {
            addDouble(point.at);
            addDouble(point.value);
        }
        key.push_back(reinterpret_cast<std::uintptr_t>(data.field.get()));
        return key;
    }

    Items _items;
    std::map<Key, std::uint32_t> _known;
    std::map<std::pair<const NodeData*, std::uint32_t>, std::uint32_t> _visited;
};

} // namespace

NoiseLimits limitsOf(const OctaveSettings& settings)
{
    return settings.plane ? planeLimits(settings.kind) : spaceLimits(settings.kind);
}

FractalNorms normsOf(const OctaveSettings& settings)
{
    FractalNorms norms = settings.plane ? planeNorms(settings.kind) : spaceNorms(settings.kind);
    norms.carry = static_cast<float>(settings.carry);
    return norms;
}

core::Interval rangeOf(const OctaveSettings& settings)
{
    const FractalNorms norms = normsOf(settings);
    const double most = double(limitsOf(settings).magnitude);
    core::Interval octave{-most, most};
    if (settings.fractal == FractalKind::billow) {
        // From the crease's bottom to the top of the largest bulge.
        const double bulge = most * double(norms.scale);
        const double rounding = double(kCreaseRounding);
        octave = {
            std::sqrt(rounding) - double(norms.billowMean),
            std::sqrt(bulge * bulge + rounding) - double(norms.billowMean)};
    } else if (settings.fractal == FractalKind::ridged) {
        octave = {-double(norms.ridgeMean), 1 - double(norms.ridgeMean)};
    }
    // An octave may be filtered away, and ridges may not be carried.
    octave = {std::min(octave.low, 0.0), std::max(octave.high, 0.0)};
    core::Interval sum{0, 0};
    double amplitude = settings.amplitude;
    for (int i = 0; i < settings.octaves; ++i) {
        const core::Interval scaled = product(octave, {amplitude, amplitude});
        sum = {sum.low + scaled.low, sum.high + scaled.high};
        amplitude *= settings.gain;
    }
    return sum;
}

double reachOf(const OctaveSettings& settings)
{
    return magnitude(rangeOf(settings)).high;
}

Items lowered(const Node& node)
{
    return Lowering().run(node);
}

bool fits(const Node& node)
{
    return !lowered(node).areTooMany;
}

} // namespace isofront::fields::graph

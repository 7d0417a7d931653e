#include "isofront/fields/Graph.h"

#include "Octaves.h"
#include "graph/NodeData.h"

#include <isofront/core/Assert.h>

#include <cmath>
#include <utility>

namespace isofront::fields::graph {

namespace {

Node made(NodeData data)
{
    return Node(std::make_shared<const NodeData>(std::move(data)));
}

bool isConstant(const Node& node)
{
    return node.data()->op == Op::constant;
}

double valueOf(const Node& node)
{
    return node.data()->numbers[0];
}

Node scaled(const Node& a, double factor, double offset)
{
    return made({.op = Op::scaled, .inputs = {a}, .numbers = {factor, offset}});
}

void check(const OctaveSettings& settings)
{
    ISOFRONT_ASSERT(settings.wavelength > 0, "a wavelength must be above zero");
    ISOFRONT_ASSERT(
        settings.octaves >= 0 && settings.octaves <= 32, "noise has at most 32 octaves");
    ISOFRONT_ASSERT(settings.lacunarity >= 1, "octaves go from long waves to short ones");
    ISOFRONT_ASSERT(settings.stretch > 0, "a stretch must be above zero");
}

} // namespace

Node::Node(double value)
    : _data(std::make_shared<const NodeData>(NodeData{.op = Op::constant, .numbers = {value}}))
{
    ISOFRONT_ASSERT(std::abs(value) <= 1e30, "a constant must be finite and at most 1e30");
}

Node position(Axis axis)
{
    return made({.op = Op::position, .which = static_cast<unsigned>(axis)});
}

Node noise(const OctaveSettings& settings)
{
    check(settings);
    return made({.op = Op::noise, .layers = {settings}});
}

Node filterWeight(double wavelength)
{
    ISOFRONT_ASSERT(wavelength > 0, "a wavelength must be above zero");
    return made({.op = Op::filterWeight, .numbers = {wavelength}});
}

Node source(std::shared_ptr<const Field> field)
{
    ISOFRONT_ASSERT(field != nullptr, "a source needs a field");
    return made({.op = Op::source, .field = std::move(field)});
}

Node operator+(const Node& a, const Node& b)
{
    if (isConstant(b))
        return scaled(a, 1.0, valueOf(b));
    if (isConstant(a))
        return scaled(b, 1.0, valueOf(a));
    return made({.op = Op::sum, .inputs = {a, b}});
}

Node operator-(const Node& a, const Node& b)
{
    if (isConstant(b))
        return scaled(a, 1.0, -valueOf(b));
    if (isConstant(a))
        return scaled(b, -1.0, valueOf(a));
    return made({.op = Op::difference, .inputs = {a, b}});
}

Node operator*(const Node& a, const Node& b)
{
    if (isConstant(b))
        return scaled(a, valueOf(b), 0.0);
    if (isConstant(a))
        return scaled(b, valueOf(a), 0.0);
    return made({.op = Op::product, .inputs = {a, b}});
}

Node operator-(const Node& a)
{
    return scaled(a, -1.0, 0.0);
}

Node abs(const Node& a)
{
    return made({.op = Op::magnitude, .inputs = {a}});
}

Node square(const Node& a)
{
    return made({.op = Op::square, .inputs = {a}});
}

Node sqrt(const Node& a)
{
    return made({.op = Op::root, .inputs = {a}});
}

Node min(const Node& a, const Node& b)
{
    return made({.op = Op::least, .inputs = {a, b}});
}

Node max(const Node& a, const Node& b)
{
    return made({.op = Op::most, .inputs = {a, b}});
}

Node smoothMin(const Node& a, const Node& b, double width)
{
    ISOFRONT_ASSERT(width > 0, "the width of a join must be above zero");
    return made({.op = Op::smoothLeast, .inputs = {a, b}, .numbers = {width}});
}

Node smoothMax(const Node& a, const Node& b, double width)
{
    ISOFRONT_ASSERT(width > 0, "the width of a join must be above zero");
    return made({.op = Op::smoothMost, .inputs = {a, b}, .numbers = {width}});
}

Node clamp(const Node& a, double low, double high)
{
    ISOFRONT_ASSERT(low <= high, "the lower limit lies above the upper one");
    return max(min(a, high), low);
}

Node smoothStep(const Node& a, double begin, double end)
{
    ISOFRONT_ASSERT(begin < end, "a step must end above its beginning");
    return made({.op = Op::smoothStep, .inputs = {a}, .numbers = {begin, end}});
}

Node mix(const Node& a, const Node& b, const Node& t)
{
    return a + t * (b - a);
}

Node curve(const Node& a, std::span<const CurvePoint> points)
{
    ISOFRONT_ASSERT(!points.empty() && points.size() <= 64, "a curve has 1 to 64 points");
    for (std::size_t i = 1; i < points.size(); ++i)
        ISOFRONT_ASSERT(points[i - 1].at < points[i].at, "the points of a curve must rise");
    return made({.op = Op::curve, .inputs = {a}, .points = {points.begin(), points.end()}});
}

Node distance(double x, double y, double z)
{
    // From a moved place: at a large distance from the origin the difference must be in double.
    const Node d =
        sqrt(square(position(Axis::x)) + square(position(Axis::y)) + square(position(Axis::z)));
    return placed(d, x, y, z);
}

Node warp(const Node& node, const Node& dx, const Node& dy, const Node& dz, double stretch)
{
    ISOFRONT_ASSERT(stretch > 0, "a stretch must be above zero");
    return made({.op = Op::warp, .inputs = {node, dx, dy, dz}, .numbers = {stretch}});
}

Node placed(const Node& node, double x, double y, double z, double scale)
{
    ISOFRONT_ASSERT(scale > 0, "a scale must be above zero");
    return made({.op = Op::placed, .inputs = {node}, .numbers = {x, y, z, scale}});
}

Node detail(
    const Node& base, std::span<const OctaveSettings> layers, const Node& strength, double reserve)
{
    for (const OctaveSettings& layer : layers) {
        check(layer);
        ISOFRONT_ASSERT(
            !layer.plane && layer.fractal == FractalKind::brownian,
            "detail is a plain sum of noise in space");
    }
    ISOFRONT_ASSERT(reserve >= 0, "a reserve can't be below zero");
    return made(
        {.op = Op::detail,
         .inputs = {base, strength},
         .numbers = {reserve},
         .layers = {layers.begin(), layers.end()}});
}

Node tunnels(const Node& solid, const TunnelSettings& settings)
{
    ISOFRONT_ASSERT(settings.radius > 0, "the radius of a tunnel must be above zero");
    const auto sheet = [&](double scale, std::uint64_t number) {
        return noise(
            {.wavelength = scale * settings.wavelength,
             .octaves = 1,
             .stretch = settings.stretch,
             .filtered = false,
             .seed = settings.seed + number});
    };
    // Where gradient noise is zero its slope is about 1.2 a cell.
    const double lengthPerUnit = 0.8 * settings.wavelength;
    const Node a = sheet(1.0, 0) * lengthPerUnit;
    const Node b = sheet(1.13, 1) * lengthPerUnit;
    const Node open = filterWeight(4.0 * settings.radius) * 1.25 - 0.25;
    const Node wide = (sheet(0.61, 2) * settings.radiusVariation + 1.0) * settings.radius * open;
    const Node axis = sqrt(square(a) + square(b) + 1.0);
    const double widest =
        settings.radius * (1.0 + double(kSpaceNoise.magnitude) * settings.radiusVariation);
    // A distance counts up to here. So the noise is evaluated only near the surface: far above it
    // nothing can be cut off, and far below it `solid - depth` decides.
    const Node distance = min(axis - wide, 3.0 * widest);
    return smoothMin(solid, max(solid - settings.depth, distance), settings.rounding);
}

} // namespace isofront::fields::graph

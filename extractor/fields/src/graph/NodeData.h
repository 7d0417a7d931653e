#pragma once

#include "isofront/fields/Graph.h"

#include <array>
#include <vector>

namespace isofront::fields::graph {

/// What a node, and an instruction of a program, does.
enum class Op : std::uint8_t {
    constant,     ///< numbers[0]
    position,     ///< coordinate number `which`
    filterWeight, ///< of the wavelength numbers[0]
    noise,
    source,
    sum,
    difference,
    product,
    scaled, ///< a * numbers[0] + numbers[1]
    magnitude,
    square,
    root,
    least,
    most,
    smoothLeast, ///< width numbers[0]
    smoothMost,  ///< width numbers[0]
    smoothStep,  ///< from numbers[0] to numbers[1]
    curve,
    detail, ///< inputs: base, strength; numbers[0]: reserve
    // Frames: they give no value, but the place and radius at which other nodes are evaluated.
    warp,   ///< inputs: the node, dx, dy, dz; numbers[0]: stretch
    placed, ///< inputs: the node; numbers[0..2]: translation, numbers[3]: scale
    // Control, in programs only; see Program.h.
    guard,
    keep,
};

struct NodeData {
    Op op = Op::constant;
    std::vector<Node> inputs = {};
    std::array<double, 4> numbers{};
    unsigned which = 0;
    std::vector<OctaveSettings> layers = {};
    std::vector<CurvePoint> points = {};
    std::shared_ptr<const Field> field = nullptr;
};

} // namespace isofront::fields::graph

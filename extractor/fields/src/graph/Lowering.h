#pragma once

#include "graph/Program.h"

#include <array>
#include <vector>

namespace isofront::fields::graph {

/// A node at a place: the same node within two warps is two items. Items that are equal are one.
struct Item {
    Op op = Op::constant;
    std::uint32_t frame = 0; ///< the item that is its frame; 0 is the world
    std::array<std::uint32_t, 3> inputs{};
    std::uint32_t inputCount = 0;
    const NodeData* node = nullptr;
    core::Interval range;  ///< of its values, anywhere and at any radius
    bool isCostly = false; ///< worth leaving out
};

/// The items of a graph; what an item needs comes before it. Item 0 is the world.
struct Items {
    std::vector<Item> items;
    std::uint32_t result = 0;
    bool areTooMany = false; ///< more than kMostNodes: then this is not the whole graph
};

Items lowered(const Node& node);

/// What octaves put together stay within.
core::Interval rangeOf(const OctaveSettings& settings);

/// How far they can be from zero.
double reachOf(const OctaveSettings& settings);

/// The limits of one octave's noise.
NoiseLimits limitsOf(const OctaveSettings& settings);
FractalNorms normsOf(const OctaveSettings& settings);

} // namespace isofront::fields::graph

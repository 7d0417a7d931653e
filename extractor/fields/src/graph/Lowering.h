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

/// How far a sum of octaves can be from zero, per unit of each one's amplitude.
double reachOf(const OctaveSettings& settings);

/// Ridges are made from noise scaled by the first; the second is the mean of the squared crest over
/// the plane, measured.
inline constexpr float kRidgeScale = 2.2F;
inline constexpr float kRidgeMean = 0.4F;

} // namespace isofront::fields::graph

#include "TileTree.h"

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isofront::tiles {

namespace {

using Json = nlohmann::ordered_json;

/// Centre and half axes, none so short that rounding leaves something of the box out.
Json boxJson(const core::Box& box)
{
    const glm::dvec3 centre = box.centre();
    const glm::dvec3 half = glm::max(box.high - centre, centre - box.low);
    const auto grown = [](double length, double at) {
        const double unit = std::max(length, std::abs(at)) * std::numeric_limits<double>::epsilon();
        return length + 2 * unit;
    };
    const Json axes = {
        centre.x,
        centre.y,
        centre.z,
        grown(half.x, centre.x),
        0,
        0,
        0,
        grown(half.y, centre.y),
        0,
        0,
        0,
        grown(half.z, centre.z)};
    return {{"box", axes}};
}

} // namespace

std::string TileTree::fileName(const TileId& tile)
{
    return std::to_string(tile.depth) + "/" + std::to_string(tile.at.x) + "-" +
           std::to_string(tile.at.y) + "-" + std::to_string(tile.at.z) + ".glb";
}

std::vector<std::uint64_t> TileTree::parentsAt(int depth) const
{
    std::vector<std::uint64_t> keys;
    for (const Tile& tile : level(depth + 1))
        keys.push_back(tile.id.parent().key());
    std::ranges::sort(keys);
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

void TileTree::setLevel(int depth, std::vector<Tile> tiles, double step)
{
    if (depth + 1 < depths()) {
        const std::vector<Tile>& below = level(depth + 1);
        for (std::size_t i = 0; i < below.size(); ++i) {
            const std::uint64_t key = below[i].id.parent().key();
            Tile& parent = *std::ranges::lower_bound(
                tiles, key, {}, [](const Tile& tile) { return tile.id.key(); });
            parent.children.push_back(i);
            if ((parent.octants & 1U << below[i].id.octant()) == 0)
                parent.measuredError = step;
        }
        for (Tile& tile : tiles)
            if (tile.children.empty()) {
                tile.vanishes = true;
                tile.measuredError = step;
            }
    }
    _levels[static_cast<std::size_t>(depth)] = std::move(tiles);
}

std::vector<TileId> TileTree::dropBelow(int depth, double maxError, double step)
{
    std::vector<TileId> dropped;
    for (Tile& tile : _levels[static_cast<std::size_t>(depth)]) {
        const bool isWhole = tile.measuredError < step;
        if (!isWhole || tile.measuredError > maxError)
            continue;
        for (const std::size_t child : std::exchange(tile.children, {}))
            drop(depth + 1, child, dropped);
    }
    return dropped;
}

void TileTree::drop(int depth, std::size_t index, std::vector<TileId>& dropped)
{
    Tile& tile = _levels[static_cast<std::size_t>(depth)][index];
    tile.isDropped = true;
    dropped.push_back(tile.id);
    for (const std::size_t child : std::exchange(tile.children, {}))
        drop(depth + 1, child, dropped);
}

void TileTree::finish()
{
    for (int depth = depths() - 1; depth >= 0; --depth)
        for (Tile& tile : _levels[static_cast<std::size_t>(depth)]) {
            tile.box = tile.content;
            tile.error = tile.children.empty() && !tile.vanishes ? 0 : tile.measuredError;
            for (const std::size_t index : tile.children) {
                const Tile& child = level(depth + 1)[index];
                tile.box.low = glm::min(tile.box.low, child.box.low);
                tile.box.high = glm::max(tile.box.high, child.box.high);
                tile.error = std::max(tile.error, child.error);
            }
        }
}

nlohmann::ordered_json TileTree::tileJson(int depth, std::size_t index) const
{
    const Tile& tile = level(depth)[index];
    Json json;
    json["boundingVolume"] = boxJson(tile.box);
    json["geometricError"] = tile.error;
    if (depth == 0)
        json["refine"] = "REPLACE"; // what is below it inherits it
    if (tile.hasFile())
        json["content"] = {{"uri", fileName(tile.id)}, {"boundingVolume", boxJson(tile.content)}};
    for (const std::size_t child : tile.children)
        json["children"].push_back(tileJson(depth + 1, child));
    if (tile.vanishes) // what takes its place is nothing
        json["children"] =
            Json::array({{{"boundingVolume", boxJson(tile.content)}, {"geometricError", 0}}});
    return json;
}

nlohmann::ordered_json TileTree::json(const core::Box& whole) const
{
    Json json;
    json["asset"] = {{"version", "1.1"}};
    const bool isEmpty = level(0).empty();
    const core::Box& box = isEmpty ? whole : level(0).front().box;
    // what is missing as long as nothing is shown: everything
    json["geometricError"] = glm::length(box.size());
    if (isEmpty)
        json["root"] = {
            {"boundingVolume", boxJson(box)}, {"geometricError", 0}, {"refine", "REPLACE"}};
    else
        json["root"] = tileJson(0, 0);
    return json;
}

} // namespace isofront::tiles

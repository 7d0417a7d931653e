#pragma once

#include "TileCutting.h"

#include <isofront/core/Box.h>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::tiles {

/// A tile of the tree: what is known of its file, if it has one, and of what lies below it.
struct Tile {
    TileId id;
    core::Box content;                 ///< of its triangles [world]; empty if there is no file
    double measuredError = 0;          ///< [world]
    std::uint8_t octants = 0;          ///< as in TilePart
    std::uint64_t triangles = 0;       ///< in its file
    std::uint64_t bytes = 0;           ///< of its file
    bool vanishes = false;             ///< the next level has nothing at all in its cube
    bool isDropped = false;            ///< no part of the tileset any more
    std::vector<std::size_t> children; ///< in the next level

    // What `TileTree::finish` finds out.
    core::Box box;    ///< of it and all below it [world]
    double error = 0; ///< geometric error [world]

    [[nodiscard]] bool hasFile() const { return !content.isEmpty(); }
};

/// The tiles of a tileset, level by level.
class TileTree {
public:
    explicit TileTree(int levels) : _levels(static_cast<std::size_t>(levels)) {}

    [[nodiscard]] int depths() const { return static_cast<int>(_levels.size()); }
    [[nodiscard]] const std::vector<Tile>& level(int depth) const
    {
        return _levels[static_cast<std::size_t>(depth)];
    }
    /// Tiles of this depth that the next level, which must be there, needs above it, in order.
    [[nodiscard]] std::vector<std::uint64_t> parentsAt(int depth) const;
    /// Puts a level, in order, above the next one. Where a tile shows nothing in the cube of one of
    /// its children, or has none, its error becomes `step`.
    void setLevel(int depth, std::vector<Tile> tiles, double step);
    /// Takes away what lies below tiles of this depth whose errors are at most this and that show
    /// something wherever their children do.
    /// @return what was taken away
    std::vector<TileId> dropBelow(int depth, double maxError, double step);
    /// Gives all tiles their boxes and errors, each no less than its children's.
    void finish();
    /// The tileset's description. `finish` must have been called.
    /// @param whole  what there is to see, if there are no tiles [world]
    [[nodiscard]] nlohmann::ordered_json json(const core::Box& whole) const;

    /// The name of a tile's file in the tileset's folder.
    static std::string fileName(const TileId& tile);

private:
    void drop(int depth, std::size_t index, std::vector<TileId>& dropped);
    [[nodiscard]] nlohmann::ordered_json tileJson(int depth, std::size_t index) const;

    std::vector<std::vector<Tile>> _levels;
};

} // namespace isofront::tiles

#pragma once

#include "exchange/MeshReaders.h"

#include <isofront/core/Box.h>

#include <filesystem>
#include <string>
#include <vector>

namespace isofront::tiles::test {

/// A tile as a client reads it. World space: z up.
struct ReadTile {
    int depth = 0;
    core::Box box;
    core::Box contentBox; ///< empty without content
    double error = 0;
    std::string uri; ///< empty without content
    std::vector<ReadTile> children;
};

/// The tree of a tileset; what isn't as the specification says is a test failure.
ReadTile readTileset(const std::filesystem::path& folder);
/// All tiles of a tree, parents first.
std::vector<const ReadTile*> allOf(const ReadTile& root);
/// The mesh of a tile, turned back from y up to z up.
exchange::test::ReadMesh readTile(const std::filesystem::path& folder, const ReadTile& tile);

} // namespace isofront::tiles::test

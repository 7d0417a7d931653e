#include "TilesetReader.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace isofront::tiles::test {

namespace {

core::Box boxOf(const nlohmann::json& volume)
{
    const auto numbers = volume.at("box").get<std::vector<double>>();
    EXPECT_EQ(numbers.size(), 12U);
    for (const std::size_t zero : {4U, 5U, 6U, 8U, 9U, 10U})
        EXPECT_EQ(numbers.at(zero), 0);
    const glm::dvec3 centre{numbers.at(0), numbers.at(1), numbers.at(2)};
    const glm::dvec3 half{numbers.at(3), numbers.at(7), numbers.at(11)};
    return {centre - half, centre + half};
}

ReadTile tileOf(const nlohmann::json& json, int depth)
{
    ReadTile tile;
    tile.depth = depth;
    tile.box = boxOf(json.at("boundingVolume"));
    tile.error = json.at("geometricError").get<double>();
    if (depth == 0) {
        EXPECT_EQ(json.at("refine"), "REPLACE");
    }
    if (json.contains("content")) {
        tile.uri = json.at("content").at("uri").get<std::string>();
        tile.contentBox = boxOf(json.at("content").at("boundingVolume"));
    }
    if (json.contains("children")) {
        EXPECT_FALSE(json.at("children").empty()); // the schema wants at least one
        for (const auto& child : json.at("children"))
            tile.children.push_back(tileOf(child, depth + 1));
    }
    return tile;
}

} // namespace

ReadTile readTileset(const std::filesystem::path& folder)
{
    const auto json = nlohmann::json::parse(std::ifstream(folder / "tileset.json"));
    EXPECT_EQ(json.at("asset").at("version"), "1.1");
    const ReadTile root = tileOf(json.at("root"), 0);
    EXPECT_GE(json.at("geometricError").get<double>(), root.error);
    return root;
}

std::vector<const ReadTile*> allOf(const ReadTile& root)
{
    std::vector<const ReadTile*> tiles{&root};
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const ReadTile& tile = *tiles[i];
        for (const ReadTile& child : tile.children)
            tiles.push_back(&child);
    }
    return tiles;
}

exchange::test::ReadMesh readTile(const std::filesystem::path& folder, const ReadTile& tile)
{
    exchange::test::ReadMesh mesh = exchange::test::readGlb(folder / tile.uri);
    for (glm::dvec3& position : mesh.positions)
        position = {position.x, -position.z, position.y};
    for (glm::vec3& normal : mesh.normals)
        normal = {normal.x, -normal.z, normal.y};
    return mesh;
}

} // namespace isofront::tiles::test

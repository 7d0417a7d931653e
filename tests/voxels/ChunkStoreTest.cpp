#include "ChunkCodec.h"
#include "Models.h"
#include "support/Random.h"
#include "support/TemporaryFolder.h"

#include <isofront/voxels/ChunkStore.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <tuple>

namespace isofront::voxels {
namespace {

Chunk anyChunk(std::mt19937_64& random, const ChunkKey& key, bool coloured)
{
    Chunk chunk;
    chunk.key = key;
    std::set<std::uint32_t> places;
    const std::size_t count = 1 + tests::below(random, 3000);
    while (places.size() < count)
        places.insert(static_cast<std::uint32_t>(tests::below(random, 1U << 24U)));
    for (const std::uint32_t place : places) {
        chunk.voxels.push_back(
            {place | static_cast<std::uint32_t>(tests::below(random, 64)) << 24U,
             static_cast<std::uint32_t>(tests::below(random, 1U << 30U))});
        if (coloured)
            chunk.colours.push_back(static_cast<std::uint32_t>(random()));
    }
    if (tests::below(random, 2) == 0)
        return chunk;
    for (std::uint32_t voxel = 0; voxel < chunk.voxels.size(); voxel += 7) {
        const auto mask = static_cast<std::uint32_t>(1 + tests::below(random, 63));
        const auto first = static_cast<std::uint32_t>(chunk.faceAttributes.size());
        chunk.faceSets.push_back({voxel, first | mask << 26U});
        for (int i = 0; i < std::popcount(mask); ++i)
            chunk.faceAttributes.push_back(
                {static_cast<std::uint32_t>(random()), static_cast<std::uint32_t>(random())});
    }
    return chunk;
}

StoredModel anyModel()
{
    StoredModel model;
    model.name = "dragon \"of\" Stanford \xc3\xa4";
    model.lattice = {{0.1, -1e9, 1e-30}, 0.1 + 0.2, 777, 3};
    model.voxels = 1;
    model.allVoxels = std::uint64_t{1} << 60U;
    model.chunks = 3;
    model.coloured = true;
    model.separability = Separability::conservative;
    return model;
}

struct Kind {
    const char* name;
    std::function<core::Result<std::unique_ptr<ChunkStore>>(const std::filesystem::path&)> create;
    std::function<core::Result<std::unique_ptr<ChunkStore>>(const std::filesystem::path&)> open;
};

class Stores : public testing::TestWithParam<int> {
protected:
    static Kind kind()
    {
        return GetParam() == 0 ? Kind{"lmdb", createStore, openStore}
                               : Kind{"folder", createFolderStore, openFolderStore};
    }
    tests::TemporaryFolder folder;
};

TEST_P(Stores, giveBackWhatTheyWereGiven)
{
    auto random = tests::random(1);
    const std::filesystem::path path = folder.path("model");
    std::map<ChunkKey, Chunk> chunks;
    {
        auto store = kind().create(path);
        ASSERT_TRUE(store) << store.error().message;
        for (int i = 0; i < 40; ++i) {
            const ChunkKey key{
                static_cast<std::uint32_t>(tests::below(random, 3)),
                static_cast<std::uint32_t>(tests::below(random, 300)),
                static_cast<std::uint32_t>(tests::below(random, 3)),
                static_cast<std::uint32_t>(tests::below(random, 70000))};
            if (chunks.contains(key))
                continue;
            chunks[key] = anyChunk(random, key, i % 2 == 0);
            ASSERT_FALSE((*store)->put(chunks[key]));
        }
        ASSERT_FALSE((*store)->finish(anyModel()));
    }
    const auto store = kind().open(path);
    ASSERT_TRUE(store) << store.error().message;
    EXPECT_EQ((*store)->model(), anyModel());
    std::vector<ChunkKey> keys;
    for (const auto& [key, chunk] : chunks)
        keys.push_back(key);
    std::ranges::sort(
        keys, {}, [](const ChunkKey& k) { return std::tuple(k.level, k.z, k.y, k.x); });
    EXPECT_EQ((*store)->keys(), keys);
    for (const auto& [key, chunk] : chunks) {
        const auto read = (*store)->get(key);
        ASSERT_TRUE(read) << read.error().message;
        ASSERT_TRUE(*read);
        EXPECT_EQ(**read, chunk);
    }
    const auto none = (*store)->get({2, 1000, 0, 0});
    ASSERT_TRUE(none);
    EXPECT_FALSE(*none);
}

TEST_P(Stores, thatWereNotFinishedAreNotOpened)
{
    auto random = tests::random(2);
    const std::filesystem::path path = folder.path("model");
    EXPECT_EQ(
        kind().open(path).error().code,
        GetParam() == 0 ? core::ErrorCode::inputOutput : core::ErrorCode::badData);
    const pid_t child = ::fork();
    if (child == 0) {
        auto store = kind().create(path);
        for (std::uint32_t i = 0; i < 20; ++i)
            (void)(*store)->put(anyChunk(random, {0, i, 0, 0}, true));
        ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status));
    ASSERT_TRUE(std::filesystem::exists(path.string() + ".part"));
    const auto unfinished = kind().open(path.string() + ".part");
    ASSERT_FALSE(unfinished);
    EXPECT_EQ(unfinished.error().code, core::ErrorCode::badData);
    EXPECT_NE(unfinished.error().message.find("not finished"), std::string::npos)
        << unfinished.error().message;
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST_P(Stores, nameTheirReason)
{
    EXPECT_EQ(kind().create("/nowhere/at/all").error().code, core::ErrorCode::inputOutput);
    const std::filesystem::path text = folder.file("text", std::string(10'000, 'x'));
    const auto opened = kind().open(text);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message.find(text.string()), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Stores, testing::Values(0, 1), [](const auto& kind) {
    return kind.param == 0 ? "lmdb" : "folder";
});

TEST(LmdbStore, keepsAnEarlierModelUntilTheNextIsFinished)
{
    tests::TemporaryFolder folder;
    auto random = tests::random(3);
    const std::filesystem::path path = folder.path("model");
    StoredModel model = anyModel();
    for (const char* name : {"first", "second"}) {
        model.name = name;
        auto store = createStore(path);
        ASSERT_TRUE(store);
        ASSERT_FALSE((*store)->put(anyChunk(random, {0, 1, 2, 3}, false)));
        if (name == std::string("first")) { // the second is given up
            ASSERT_FALSE((*store)->finish(model));
        }
    }
    const auto store = openStore(path);
    ASSERT_TRUE(store) << store.error().message;
    EXPECT_EQ((*store)->model().name, "first");
}

TEST(Chunks, knowTheAttributesOfEachFace)
{
    Chunk chunk;
    for (std::uint32_t i = 0; i < 10; ++i) {
        chunk.voxels.push_back({packPlace(i, 0, 0, 0x15), 100 + i});
        chunk.colours.push_back(200 + i);
    }
    chunk.faceAttributes = {{1, 2}, {3, 4}, {5, 6}, {7, 8}};
    chunk.faceSets = {{2, 0U | 0x15U << 26U}, {7, 1U | 0x20U << 26U}, {9, 3U | 0x01U << 26U}};
    // the faces of a mask in turn, and all others as the voxel
    const std::map<std::pair<std::size_t, std::size_t>, FaceAttributes> own{
        {{2, 0}, {1, 2}}, {{2, 2}, {3, 4}}, {{2, 4}, {5, 6}}, {{7, 5}, {3, 4}}, {{9, 0}, {7, 8}}};
    for (std::size_t voxel = 0; voxel < chunk.voxels.size(); ++voxel)
        for (std::size_t face = 0; face < kFaces; ++face) {
            const auto found = own.find({voxel, face});
            const auto n = static_cast<std::uint32_t>(voxel);
            const FaceAttributes expected =
                found == own.end() ? FaceAttributes{100 + n, 200 + n} : found->second;
            EXPECT_EQ(attributesOf(chunk, voxel, static_cast<Face>(face)), expected);
        }
    chunk.colours.clear();
    EXPECT_EQ(attributesOf(chunk, 1, Face::lowX), (FaceAttributes{101, 0}));
}

TEST(Chunks, whoseFaceSetsMakeNoSenseAreRefused)
{
    Chunk chunk;
    chunk.voxels = {{packPlace(0, 0, 0, 1), 0}, {packPlace(1, 0, 0, 1), 0}};
    chunk.faceAttributes = {{1, 2}, {3, 4}};
    const auto isRefused = [&](const std::vector<FaceSet>& sets) {
        chunk.faceSets = sets;
        return !decodedChunk(encoded(chunk), chunk.key);
    };
    EXPECT_FALSE(isRefused({{0, 0x21U << 26U}, {1, 1U | 0x01U << 26U}}));
    EXPECT_TRUE(isRefused({{1, 0x21U << 26U}, {0, 0x01U << 26U}}));
    EXPECT_TRUE(isRefused({{1, 0x21U << 26U}, {1, 0x01U << 26U}}));
    EXPECT_TRUE(isRefused({{2, 0x01U << 26U}}));
    EXPECT_TRUE(isRefused({{1, 1U | 0x21U << 26U}}));
    EXPECT_TRUE(isRefused({{1, 0x3ffffffU | 0x01U << 26U}}));
}

TEST(Chunks, thatAreDamagedAreRefused)
{
    auto random = tests::random(4);
    const ChunkKey key{1, 2, 3, 4};
    Chunk chunk = anyChunk(random, key, true);
    while (chunk.faceSets.empty())
        chunk = anyChunk(random, key, true);
    const std::vector<std::byte> bytes = encoded(chunk);
    ASSERT_EQ(*decodedChunk(bytes, key), chunk);
    EXPECT_FALSE(decodedChunk(bytes, {1, 2, 3, 5}));
    for (int trial = 0; trial < tests::trials(2000); ++trial) {
        std::vector<std::byte> other = bytes;
        if (trial % 4 == 0)
            other.resize(tests::below(random, bytes.size()));
        else
            other[tests::below(random, trial % 2 == 0 ? 32 : bytes.size())] ^=
                static_cast<std::byte>(1 + tests::below(random, 255));
        const auto read = decodedChunk(other, key);
        ASSERT_FALSE(read) << trial;
        EXPECT_EQ(read.error().code, core::ErrorCode::badData);
        EXPECT_NE(read.error().message.find("chunk 2, 3, 4 of level 1"), std::string::npos);
    }
}

TEST(ModelDescriptions, thatAreDamagedAreRefused)
{
    auto random = tests::random(5);
    const std::string whole = encoded(anyModel());
    ASSERT_EQ(*decodedModel(whole), anyModel());
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string other = whole;
        other[at] =
            static_cast<char>(other[at] ^ (1 + static_cast<int>(tests::below(random, 127))));
        const auto read = decodedModel(other);
        // more digits than a number has say the same
        EXPECT_TRUE(!read || *read == anyModel()) << other;
        EXPECT_FALSE(decodedModel(whole.substr(0, at)));
    }
}

TEST(ModelDescriptions, withPartsOfOtherKindsAreRefused)
{
    using Json = nlohmann::ordered_json;
    const Json whole = Json::parse(encoded(anyModel()));
    const Json others = Json::parse(
        R"([null, true, false, 0, 5, -1, 1.5, 1e300, 4294967296, 18446744073709551615, "", "x", [],
            [1, 2], [1, 2, 3], [1, 2, "x"], [0, 0, 1e308], {}, {"a": 1}])");
    for (const auto& [key, value] : whole.items()) {
        Json changed = whole;
        changed.erase(key);
        EXPECT_FALSE(decodedModel(changed.dump())) << "without " << key;
        for (const Json& other : others) {
            changed = whole;
            changed[key] = other;
            const auto read = decodedModel(changed.dump());
            if (other == value)
                continue;
            ASSERT_FALSE(read) << key << " is " << other;
            EXPECT_EQ(read.error().code, core::ErrorCode::badData);
        }
    }
    EXPECT_FALSE(decodedModel(R"({"format": 5})"));
    EXPECT_FALSE(decodedModel("[1]"));
    const std::string deep(100'000, '[');
    EXPECT_FALSE(decodedModel("{\"format\": " + deep + std::string(deep.size(), ']') + "}"));
}

TEST(ModelDescriptions, ofLatticesThatMakeNoSenseAreRefused)
{
    const double infinity = std::numeric_limits<double>::infinity();
    const auto isRefused = [](const std::function<void(VoxelLattice&)>& change) {
        StoredModel model = anyModel();
        change(model.lattice);
        const auto read = decodedModel(encoded(model));
        EXPECT_TRUE(!read || *read == model);
        return !read;
    };
    EXPECT_FALSE(isRefused([](VoxelLattice& lattice) { lattice.edge = 1e-300; }));
    EXPECT_FALSE(isRefused([](VoxelLattice& lattice) { lattice = {{}, 1, 65536, 9}; }));
    EXPECT_TRUE(isRefused([](VoxelLattice& lattice) { lattice = {{}, 1, 65537, 10}; }));
    EXPECT_TRUE(isRefused([](VoxelLattice& lattice) { lattice.resolution = 0; }));
    for (const std::uint32_t levels : {0U, 2U, 4U, 40U})
        EXPECT_TRUE(isRefused([&](VoxelLattice& lattice) { lattice.levels = levels; })) << levels;
    for (const double edge : {0.0, -1.0, infinity, 1e308, std::nan("")})
        EXPECT_TRUE(isRefused([&](VoxelLattice& lattice) { lattice.edge = edge; })) << edge;
    for (const double place : {infinity, -infinity, std::nan("")})
        EXPECT_TRUE(isRefused([&](VoxelLattice& lattice) { lattice.origin.y = place; })) << place;
}

TEST(ModelDescriptions, ofOtherVersionsNameTheRemedy)
{
    auto json = nlohmann::ordered_json::parse(encoded(anyModel()));
    const int version = json["version"].get<int>();
    json["version"] = version - 1;
    EXPECT_NE(decodedModel(json.dump()).error().message.find("voxelise again"), std::string::npos);
    json["version"] = version + 3;
    EXPECT_NE(decodedModel(json.dump()).error().message.find("newer"), std::string::npos);
}

TEST(ModelDescriptions, tellOfTheSourceOnlyInAVersionOfItsOwn)
{
    StoredModel model = anyModel();
    const auto without = nlohmann::ordered_json::parse(encoded(model));
    EXPECT_EQ(without["version"], 3) << "as it was before sources were kept";
    EXPECT_FALSE(without.contains("source"));
    EXPECT_FALSE(decodedModel(encoded(model))->source);
    model.source =
        ModelSource{"meshes/dragon \xc3\xa4.ply.gz", std::uint64_t{1} << 60U, 0xffffffffU};
    auto with = nlohmann::ordered_json::parse(encoded(model));
    EXPECT_EQ(with["version"], 4);
    const auto read = decodedModel(encoded(model));
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(*read, model);
    for (const char* part : {"path", "bytes", "checksum"}) {
        auto damaged = with;
        damaged["source"].erase(part);
        EXPECT_FALSE(decodedModel(damaged.dump())) << part;
        damaged = with;
        damaged["source"][part] = -1;
        EXPECT_FALSE(decodedModel(damaged.dump())) << part;
    }
    for (const int version : {3, 5}) {
        auto damaged = with;
        damaged["version"] = version;
        EXPECT_FALSE(decodedModel(damaged.dump())) << version;
    }
}

TEST(ModelDescriptions, tellOfTheFieldOnlyInAVersionOfItsOwn)
{
    StoredModel model = anyModel();
    model.field = ModelField{"proc:torus?ring=0.75 \xc3\xa4", 0.1 + 0.2, 0.5, true, ~0ULL};
    for (const bool hasSource : {false, true}) {
        if (hasSource)
            model.source = ModelSource{"any.ply", 7, 8};
        auto with = nlohmann::ordered_json::parse(encoded(model));
        EXPECT_EQ(with["version"], 5);
        const auto read = decodedModel(encoded(model));
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(*read, model);
        for (const char* part : {"source", "isovalue", "filter", "closed", "checksum"}) {
            auto damaged = with;
            damaged["field"].erase(part);
            EXPECT_FALSE(decodedModel(damaged.dump())) << part;
            damaged = with;
            damaged["field"][part] = nlohmann::json::array();
            EXPECT_FALSE(decodedModel(damaged.dump())) << part;
        }
        auto damaged = with;
        damaged["field"]["isovalue"] = 0.3;
        EXPECT_FALSE(decodedModel(damaged.dump())) << "its checksum is another";
        damaged = with;
        damaged["version"] = 4;
        EXPECT_FALSE(decodedModel(damaged.dump()));
    }
}

TEST(ModelSources, areFoundAgainAndKnown)
{
    const tests::TemporaryFolder temporary;
    const std::filesystem::path folder = temporary.path("any").parent_path();
    std::filesystem::create_directories(folder / "models" / "meshes");
    const std::filesystem::path model = folder / "models" / "any.voxels";
    const auto write = [](const std::filesystem::path& path, const std::string& text) {
        std::ofstream(path, std::ios::binary) << text;
    };
    const std::filesystem::path beside = folder / "models" / "meshes" / "any.ply";
    write(beside, "a mesh");
    const auto near = describedSource(beside, model);
    ASSERT_TRUE(near) << near.error().message;
    EXPECT_EQ(near->path, "meshes/any.ply");
    EXPECT_EQ(near->bytes, 6U);
    EXPECT_TRUE(std::filesystem::equivalent(placeOfSource(*near, model), beside));
    EXPECT_TRUE(checkSource(*near, beside));
    // both moved together
    std::filesystem::rename(folder / "models", folder / "moved");
    const std::filesystem::path moved = folder / "moved" / "any.voxels";
    EXPECT_TRUE(checkSource(*near, placeOfSource(*near, moved)));
    EXPECT_EQ(
        checkSource(*near, placeOfSource(*near, model)).error().code, core::ErrorCode::inputOutput);

    const std::filesystem::path elsewhere = folder / "other.ply";
    write(elsewhere, "a mesh");
    const auto far = describedSource(elsewhere, moved);
    ASSERT_TRUE(far) << far.error().message;
    EXPECT_TRUE(std::filesystem::path(far->path).is_absolute());
    EXPECT_EQ(far->checksum, near->checksum);
    for (const char* text : {"a mess", "a mesh ", ""}) {
        write(elsewhere, text);
        EXPECT_EQ(
            checkSource(*far, placeOfSource(*far, moved)).error().code, core::ErrorCode::badData)
            << text;
    }
    EXPECT_FALSE(describedSource(folder / "none.ply", moved));
}

} // namespace
} // namespace isofront::voxels

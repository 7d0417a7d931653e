#include "support/Random.h"
#include "support/TemporaryFolder.h"

#include <isofront/voxels/ChunkStore.h>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <bit>
#include <csignal>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

namespace {

using Identity = std::pair<dev_t, ino_t>;

Identity identityOf(const struct stat& status)
{
    return {status.st_dev, status.st_ino};
}

/// What was made durable, while a test asks for it.
std::multiset<Identity>* durable = nullptr;

} // namespace

/// Stands before the C library's in this program, to see who calls it.
extern "C" int fsync(int descriptor)
{
    struct stat status {};
    if (durable != nullptr && ::fstat(descriptor, &status) == 0)
        durable->insert(identityOf(status));
    return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace isofront::voxels {
namespace {

namespace fs = std::filesystem;

StoredModel anyModel(std::string name = "any")
{
    StoredModel model;
    model.name = std::move(name);
    model.lattice = {{}, 1, 256, 1};
    return model;
}

Chunk chunkOf(std::mt19937_64& random, const ChunkKey& key, std::uint32_t voxels)
{
    Chunk chunk;
    chunk.key = key;
    for (std::uint32_t i = 0; i < voxels; ++i)
        chunk.voxels.push_back(
            {packPlace(i % 256, i / 256 % 256, i / 65536, 1),
             static_cast<std::uint32_t>(tests::below(random, 1000))});
    return chunk;
}

TEST(LmdbStore, isWrittenByOneAtATime)
{
    const tests::TemporaryFolder folder;
    auto random = tests::random(1);
    const fs::path path = folder.path("model");
    {
        auto first = createStore(path);
        ASSERT_TRUE(first) << first.error().message;
        ASSERT_FALSE((*first)->put(chunkOf(random, {0, 0, 0, 0}, 10)));
        const auto second = createStore(path);
        ASSERT_FALSE(second);
        EXPECT_EQ(second.error().code, core::ErrorCode::inputOutput);
        EXPECT_NE(second.error().message.find("another process"), std::string::npos);
        EXPECT_NE(second.error().message.find(path.string()), std::string::npos);
        ASSERT_FALSE((*first)->finish(anyModel("first")));
        EXPECT_EQ((*openStore(path))->model().name, "first");
        EXPECT_TRUE(createStore(path)) << "the first is done";
    }
    EXPECT_EQ((*openStore(path))->model().name, "first") << "the second was given up";
    // what was left by a process that was killed is in nobody's way
    const fs::path left = folder.file("model.part", std::string(20'000, 'x'));
    auto next = createStore(path);
    ASSERT_TRUE(next) << next.error().message;
    ASSERT_FALSE((*next)->put(chunkOf(random, {0, 0, 0, 0}, 10)));
    ASSERT_FALSE((*next)->finish(anyModel("next")));
    next->reset();
    EXPECT_EQ((*openStore(path))->model().name, "next");
    EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), {}), 1);
}

TEST(LmdbStore, asksWhetherTheDiskIsFull)
{
    const tests::TemporaryFolder folder;
    auto random = tests::random(2);
    const fs::path path = folder.path("model");
    auto store = createStore(path);
    ASSERT_TRUE(store);
    ASSERT_FALSE((*store)->put(chunkOf(random, {0, 0, 0, 0}, 100'000)));
    // a page that there is room for the begin of only, as on a full disk
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    rlimit small = before;
    small.rlim_cur = 100'100;
    auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto failed = (*store)->finish(anyModel());
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    ASSERT_TRUE(failed);
    EXPECT_EQ(failed->code, core::ErrorCode::inputOutput);
    EXPECT_NE(failed->message.find("is the disk full? free some space"), std::string::npos)
        << failed->message;
    store->reset();
    EXPECT_TRUE(fs::is_empty(path.parent_path()));
}

/// Whatever it says, it returns.
void readAllOf(const fs::path& path, std::mt19937_64& random)
{
    const auto store = openStore(path);
    if (!store) {
        ASSERT_EQ(store.error().code, core::ErrorCode::badData) << store.error().message;
        ASSERT_NE(store.error().message.find(path.string()), std::string::npos);
        return;
    }
    (void)(*store)->directory();
    const std::vector<ChunkKey> keys = (*store)->keys();
    for (int i = 0; i < 3 && !keys.empty(); ++i)
        (void)(*store)->get(keys[tests::below(random, keys.size())]);
}

TEST(LmdbStore, isReadOrRefusedWhateverIsDamagedInItsTree)
{
    const tests::TemporaryFolder folder;
    auto random = tests::random(3);
    const fs::path path = folder.path("model");
    {
        // of small chunks, which lie in the tree, and of larger ones, which have pages of their own
        auto store = createStore(path);
        for (std::uint32_t i = 0; i < 150; ++i)
            ASSERT_FALSE(
                (*store)->put(chunkOf(random, {0, i % 7, i % 5, i}, i % 5 == 0 ? 900 : 2)));
        ASSERT_FALSE((*store)->finish(anyModel()));
        ASSERT_EQ((*store)->keys().size(), 150U);
    }
    ASSERT_EQ((*openStore(path))->keys().size(), 150U);
    std::ifstream file(path, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(file), {}};

    // where the pages of metas and of the tree have something
    constexpr std::size_t kPage = 4096;
    constexpr std::size_t kMetaBytes = 152;
    std::vector<std::size_t> places;
    std::size_t branches = 0;
    std::set<std::size_t> overflown;
    for (std::size_t page = 0; page < whole.size() / kPage; ++page) {
        const auto halfAt = [&](std::size_t at) {
            std::uint16_t value = 0;
            std::memcpy(&value, whole.data() + page * kPage + at, sizeof value);
            return value;
        };
        if (overflown.contains(page))
            continue;
        const std::uint16_t flags = halfAt(10);
        if ((flags & 4U) != 0) // what follows is of one chunk
            for (std::size_t next = 0; next < halfAt(12); ++next)
                overflown.insert(page + next);
        branches += flags & 1U;
        for (std::size_t at = 0; at < kPage; ++at)
            if (page < 2 ? at < kMetaBytes
                         : (flags & 3U) != 0 && (at < halfAt(12) || at >= halfAt(14)))
                places.push_back(page * kPage + at);
    }
    ASSERT_GE(branches, 1U);
    ASSERT_GT(places.size(), 5000U);

    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    ASSERT_GE(descriptor, 0);
    const auto put = [&](std::size_t at, char byte) {
        ASSERT_EQ(::pwrite(descriptor, &byte, 1, static_cast<::off_t>(at)), 1);
    };
    const auto readWith = [&](std::initializer_list<std::pair<std::size_t, char>> bytes) {
        for (const auto& [at, byte] : bytes)
            put(at, byte);
        readAllOf(path, random);
        for (const auto& [at, byte] : bytes)
            put(at, whole[at]);
    };
    const auto anyByte = [&] { return static_cast<char>(random()); };
    const auto anyPlace = [&] { return places[tests::below(random, places.size())]; };
    const auto count = std::min(
        places.size(), static_cast<std::size_t>(tests::trials(static_cast<int>(places.size()))));
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t at = places[i * places.size() / count];
        // none, all and any of its bits
        const char bytes[]{0, '\xff', anyByte()};
        readWith({{at, bytes[i % 3]}});
    }
    for (int trial = 0; trial < tests::trials(3000); ++trial)
        readWith({{anyPlace(), anyByte()}, {anyPlace(), anyByte()}});
    ::close(descriptor);
    ASSERT_EQ((*openStore(path))->keys().size(), 150U) << "all is as it was";
}

TEST(FolderStore, isDurableWhenItHasItsName)
{
    const tests::TemporaryFolder folder;
    auto random = tests::random(4);
    const fs::path path = folder.path("model");
    std::multiset<Identity> seen;
    auto store = createFolderStore(path);
    ASSERT_TRUE(store);
    durable = &seen;
    for (std::uint32_t i = 0; i < 3; ++i)
        EXPECT_FALSE((*store)->put(chunkOf(random, {i, 0, 0, 0}, 10)));
    const auto failed = (*store)->finish(anyModel());
    durable = nullptr;
    ASSERT_FALSE(failed);
    std::vector<fs::path> expected{path, path.parent_path()};
    for (const auto& entry : fs::recursive_directory_iterator(path))
        expected.push_back(entry.path());
    EXPECT_EQ(expected.size(), 2U + 3 * 2 + 2);
    for (const fs::path& name : expected) {
        struct stat status {};
        ASSERT_EQ(::stat(name.c_str(), &status), 0);
        EXPECT_TRUE(seen.contains(identityOf(status))) << name;
    }
}

TEST(LmdbStore, hasADurableName)
{
    const tests::TemporaryFolder folder;
    const fs::path path = folder.path("model");
    std::multiset<Identity> seen;
    auto store = createStore(path);
    ASSERT_TRUE(store);
    durable = &seen;
    const auto failed = (*store)->finish(anyModel());
    durable = nullptr;
    ASSERT_FALSE(failed);
    struct stat status {};
    ASSERT_EQ(::stat(path.parent_path().c_str(), &status), 0);
    EXPECT_TRUE(seen.contains(identityOf(status)));
}

TEST(FolderStore, takesTheFolderOfAProcessThatWasKilledButNoOther)
{
    const tests::TemporaryFolder folder;
    const fs::path path = folder.path("model");
    const fs::path part = folder.path("model.part");
    const auto put = [](const fs::path& file) {
        fs::create_directories(file.parent_path());
        std::ofstream(file) << "something";
    };
    // while one is written, nobody else writes it
    {
        auto first = createFolderStore(path);
        ASSERT_TRUE(first) << first.error().message;
        const auto second = createFolderStore(path);
        ASSERT_FALSE(second);
        EXPECT_EQ(second.error().code, core::ErrorCode::inputOutput);
        EXPECT_NE(second.error().message.find("another process"), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(part));
    // what is left of one that was killed is replaced
    for (const char* file : {"0/1-2-3.chunk", "1/0-0-0.chunk.part", "directory", "model.json.part"})
        put(part / file);
    {
        auto store = createFolderStore(path);
        ASSERT_TRUE(store) << store.error().message;
        EXPECT_TRUE(fs::is_empty(part));
        ASSERT_FALSE((*store)->finish({.name = "nothing", .lattice = {.resolution = 1}}));
    }
    EXPECT_TRUE(openFolderStore(path));
    EXPECT_FALSE(fs::exists(part));
    fs::remove_all(path);
    // what isn't a model's stays
    for (const char* file :
         {"notes.txt",
          "0/notes.chunk",
          "12/1-2-3.chunk",
          "letters/1-2-3.chunk",
          "0/1/1-2-3.chunk"}) {
        put(part / file);
        const auto refused = createFolderStore(path);
        ASSERT_FALSE(refused) << file;
        EXPECT_NE(refused.error().message.find("model.part"), std::string::npos);
        EXPECT_TRUE(fs::exists(part / file));
        fs::remove_all(part);
    }
}

TEST(LmdbStore, leavesNothingWhereItCanNotBeMade)
{
    // a folder in the place of the file that LMDB locks: there the name can't be had
    const tests::TemporaryFolder folder;
    fs::create_directories(folder.path("model.part-lock"));
    EXPECT_FALSE(createStore(folder.path("model")));
    EXPECT_FALSE(fs::exists(folder.path("model.part")));
    EXPECT_FALSE(fs::exists(folder.path("model")));
}

} // namespace
} // namespace isofront::voxels

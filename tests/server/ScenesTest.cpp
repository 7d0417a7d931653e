#include "Log.h"
#include "Metrics.h"
#include "TemporaryFolder.h"
#include "scenes/SceneFiles.h"
#include "scenes/SceneRegistry.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <thread>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

class Scenes : public testing::Test {
protected:
    Scenes()
    {
        settings.data = folder.path / "data";
        settings.sources = folder.path / "sources";
        fs::create_directories(settings.sources);
        open();
    }

    static Settings quiet()
    {
        Settings settings;
        settings.logLevel = "error";
        return settings;
    }

    void open()
    {
        registry.reset();
        auto opened = SceneRegistry::open(settings, log, metrics);
        ASSERT_TRUE(opened) << opened.error().message;
        registry = std::move(*opened);
    }

    /// Waits until it is ready or has failed.
    SceneRecord prepared(const std::string& id) const
    {
        auto record = registry->find(id);
        while (record && record->state == SceneRecord::State::preparing) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            record = registry->find(id);
        }
        return record.value_or(SceneRecord{});
    }

    core::Result<SceneRecord> formula(const std::string& text) const
    {
        return registry->create("", {SceneOrigin::Kind::procedural, text, {}});
    }

    core::Result<SceneRecord> upload(const std::string& name, const std::string& bytes) const
    {
        UploadedFile file(folder.write("coming.part", bytes));
        return registry->create("", {SceneOrigin::Kind::upload, name, {}}, file);
    }

    static SceneOrigin ballIn(SceneOrigin::Kind kind, const std::string& name, int edge)
    {
        SceneOrigin origin{kind, name, {}};
        origin.options.rawLayout = ballLayout(edge);
        return origin;
    }

    core::Result<SceneRecord> uploadBall(int edge) const
    {
        UploadedFile file(folder.write("coming.part", ballVolume(edge)));
        return registry->create("", ballIn(SceneOrigin::Kind::upload, "ball.raw", edge), file);
    }

    TemporaryFolder folder;
    Settings settings = quiet();
    Log log{settings};
    Metrics metrics;
    std::unique_ptr<SceneRegistry> registry;
};

TEST_F(Scenes, ofFormulasAreDescribed)
{
    const auto made = formula("proc:sphere");
    ASSERT_TRUE(made) << made.error().message;
    const SceneRecord record = prepared(made->id);
    ASSERT_EQ(record.state, SceneRecord::State::ready) << record.failure;
    ASSERT_TRUE(record.description);
    EXPECT_EQ(record.description->kind, "procedural");
    EXPECT_FALSE(record.description->bounds.isEmpty());
    const Histogram& values = record.description->values;
    EXPECT_LT(values.low, record.description->isovalue);
    EXPECT_GT(values.high, record.description->isovalue);
    EXPECT_EQ(
        std::accumulate(values.counts.begin(), values.counts.end(), std::uint64_t{0}),
        64U * 64U * 64U);
    EXPECT_EQ(registry->list().size(), 1U);
}

TEST_F(Scenes, ofUploadsSurviveARestart)
{
    const auto made = uploadBall(16);
    ASSERT_TRUE(made) << made.error().message;
    const SceneRecord before = prepared(made->id);
    ASSERT_EQ(before.state, SceneRecord::State::ready) << before.failure;
    EXPECT_EQ(before.description->values.low, 10);
    EXPECT_EQ(before.description->values.high, 200);
    open();
    const auto after = registry->find(made->id);
    ASSERT_TRUE(after);
    EXPECT_EQ(toText(*after), toText(before));
    const auto scene = registry->acquire(*after);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_TRUE((*scene)->source.volume);
}

TEST_F(Scenes, thatWereNotLookedAtAreLookedAtAfterARestart)
{
    const auto made = formula("proc:torus");
    ASSERT_TRUE(made);
    const fs::path file = settings.data / "scenes" / made->id / "scene.json";
    prepared(made->id);
    registry.reset();
    std::ofstream(file, std::ios::binary) << toText(*made); // as it was when it was made
    open();
    EXPECT_EQ(prepared(made->id).state, SceneRecord::State::ready);
}

TEST_F(Scenes, thatTheServiceDiesOfAreGivenUp)
{
    const auto made = formula("proc:torus");
    ASSERT_TRUE(made);
    const fs::path file = settings.data / "scenes" / made->id / "scene.json";
    prepared(made->id);
    registry.reset();
    SceneRecord killer = *made;
    killer.attempts = 2;
    std::ofstream(file, std::ios::binary) << toText(killer);
    open();
    const SceneRecord record = prepared(made->id);
    EXPECT_EQ(record.state, SceneRecord::State::failed);
    EXPECT_NE(record.failure.find("ended each time"), std::string::npos);
}

TEST_F(Scenes, areGoneWhenDeleted)
{
    const auto made = uploadBall(16);
    ASSERT_TRUE(made);
    const auto scene = registry->acquire(prepared(made->id));
    ASSERT_TRUE(scene);
    EXPECT_TRUE(*registry->remove(made->id));
    EXPECT_FALSE(*registry->remove(made->id));
    EXPECT_FALSE(registry->find(made->id));
    EXPECT_TRUE(fs::is_empty(settings.data / "scenes"));
    // who holds it keeps it
    const std::vector<double> x{7.5};
    std::vector<float> value(1);
    (*scene)->source.field->sample({.x = x, .y = x, .z = x}, value);
    EXPECT_EQ(value[0], 200);
    open();
    EXPECT_TRUE(registry->list().empty());
}

TEST_F(Scenes, leaveNothingOfAProcessThatWasKilled)
{
    registry.reset();
    fs::create_directories(settings.data / "scenes" / ".new-0123");
    fs::create_directories(settings.data / "scenes" / ".gone-0123");
    fs::create_directories(settings.data / "scenes" / std::string(32, 'a'));
    open();
    EXPECT_TRUE(registry->list().empty());
    EXPECT_FALSE(fs::exists(settings.data / "scenes" / ".new-0123"));
    EXPECT_FALSE(fs::exists(settings.data / "scenes" / ".gone-0123"));
    // what can't be read is somebody's: left alone
    EXPECT_TRUE(fs::exists(settings.data / "scenes" / std::string(32, 'a')));
}

TEST_F(Scenes, thatCantBeReadSayWhyWithoutFolders)
{
    for (const std::string& bytes :
         {std::string("nothing"),
          std::string(),
          ballVolume(16).substr(0, 1000),
          std::string("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n"
                      "data file: /etc/passwd\n\n")}) {
        const auto made = upload("bad.nrrd", bytes);
        ASSERT_TRUE(made);
        const SceneRecord record = prepared(made->id);
        EXPECT_EQ(record.state, SceneRecord::State::failed);
        EXPECT_NE(record.failure.find("bad.nrrd"), std::string::npos) << record.failure;
        EXPECT_EQ(record.failure.find(folder.path.string()), std::string::npos) << record.failure;
    }
}

TEST_F(Scenes, areLimited)
{
    settings.scenes = 2;
    settings.storageBytes = 5000;
    open();
    EXPECT_TRUE(uploadBall(16));
    const auto tooMuch = uploadBall(16);
    ASSERT_FALSE(tooMuch);
    EXPECT_EQ(tooMuch.error().code, core::ErrorCode::resourceLimit);
    EXPECT_TRUE(formula("proc:sphere"));
    const auto tooMany = formula("proc:sphere");
    ASSERT_FALSE(tooMany);
    EXPECT_EQ(tooMany.error().code, core::ErrorCode::resourceLimit);
    ASSERT_TRUE(*registry->remove(registry->list()[0].id));
    EXPECT_TRUE(formula("proc:sphere"));
}

TEST_F(Scenes, areMadeOfTheServicesFilesOnly)
{
    folder.write("sources/scans/ball.raw", ballVolume(16));
    folder.write("secret.raw", ballVolume(16));
    fs::create_symlink(folder.path / "secret.raw", settings.sources / "link.raw");
    folder.write("sources/.hidden/ball.raw", ballVolume(16));
    folder.write("sources/readme.txt", "no source");

    const auto made = registry->create("", ballIn(SceneOrigin::Kind::file, "scans/ball.raw", 16));
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(prepared(made->id).state, SceneRecord::State::ready);
    for (const std::string& path :
         {std::string("../secret.raw"),
          std::string("scans/../../secret.raw"),
          std::string("link.raw"),
          (folder.path / "secret.raw").string(),
          std::string("none"),
          std::string(),
          std::string("."),
          std::string("scans/..")})
        EXPECT_FALSE(registry->create("", {SceneOrigin::Kind::file, path, {}})) << path;

    const auto files = sourceFilesIn(settings.sources);
    std::vector<std::string> names;
    for (const SourceFile& file : files)
        names.push_back(file.path);
    EXPECT_EQ(std::ranges::count(names, "scans/ball.raw"), 1);
    EXPECT_EQ(std::ranges::count(names, "readme.txt"), 0);
    EXPECT_EQ(std::ranges::count(names, ".hidden/ball.raw"), 0);
}

TEST_F(Scenes, formulasNameNoFiles)
{
    folder.write("graph.json", "{}");
    for (const std::string& text :
         {std::string("sphere"),
          std::string("proc:"),
          std::string("proc:none"),
          "proc:terrain?preset=" + (folder.path / "graph.json").string(),
          std::string("proc:terrain?seed=1&preset=/etc/passwd.json"),
          std::string("/etc/passwd"),
          std::string()})
        EXPECT_FALSE(formula(text)) << text;
    EXPECT_TRUE(formula("proc:terrain?preset=canyon&seed=3"));
}

TEST_F(Scenes, goFromMemoryWhenOthersNeedIt)
{
    const auto first = uploadBall(64);
    const auto second = uploadBall(64);
    ASSERT_TRUE(first && second);
    const SceneRecord a = prepared(first->id);
    const SceneRecord b = prepared(second->id);
    const std::uint64_t bytes = a.description->memoryBytes;
    ASSERT_GT(bytes, 0U);
    settings.memoryBytes = 3 * bytes; // half of it holds one
    open();
    const fields::Field* before = nullptr;
    {
        const auto scene = registry->acquire(a);
        ASSERT_TRUE(scene);
        before = (*scene)->source.field.get();
        const auto again = registry->acquire(a);
        EXPECT_EQ((*again)->source.field.get(), before);
        const auto both = registry->acquire(b); // the first is held, so it stays
        ASSERT_TRUE(both) << both.error().message;
        EXPECT_EQ(metrics.value(Metrics::Level::openScenes), 2);
    }
    ASSERT_TRUE(registry->acquire(b));
    EXPECT_EQ(metrics.value(Metrics::Level::openScenes), 2);
    ASSERT_TRUE(registry->remove(b.id));
    EXPECT_EQ(metrics.value(Metrics::Level::openScenes), 1);
}

TEST(Uploads, areNamedSafely)
{
    EXPECT_EQ(uploadName("head.nrrd").value_or(""), "head.nrrd");
    EXPECT_EQ(uploadName("../../x/head.NII.gz").value_or(""), "head.NII.gz");
    EXPECT_EQ(uploadName("my scan;rm -rf.mha").value_or(""), "my_scan_rm_-rf.mha");
    EXPECT_EQ(uploadName("...x.tif").value_or(""), "x.tif");
    for (const char* const name :
         {"", "x", "x.exe", "head.nhdr", "head.mhd", "..", "/", ".nrrd", "a/", "x.nrrd\n.sh"})
        EXPECT_FALSE(uploadName(name)) << name;
    EXPECT_LE(uploadName(std::string(5000, 'x') + ".nrrd").value_or("").size(), 100U);
}

TEST(Uploads, thatNameOtherFilesAreRefused)
{
    const TemporaryFolder folder;
    const auto isGood = [&](const std::string& name, const std::string& text) {
        return checkSelfContained(folder.write(name, text)).has_value();
    };
    EXPECT_TRUE(isGood("a.nrrd", "NRRD0004\nsizes: 1 1 1\n\nvoxels data file: x"));
    EXPECT_TRUE(isGood("a.nrrd", "NRRD0004\r\nsizes: 1 1 1\r\n\r\n"));
    EXPECT_FALSE(isGood("a.nrrd", "NRRD0004\nDATA FILE: /etc/passwd\n\n"));
    EXPECT_FALSE(isGood("a.NRRD", "NRRD0004\ndatafile:/etc/passwd\n\n"));
    EXPECT_FALSE(isGood("a.nrrd", "NRRD0004\ndata file: LIST\n/etc/passwd\n\n"));
    EXPECT_FALSE(isGood("a.nrrd", "NRRD0004\nsizes: 1 1 1\n"));
    EXPECT_TRUE(isGood("a.mha", "NDims = 3\nElementDataFile = LOCAL\nxxx"));
    EXPECT_FALSE(isGood("a.mha", "NDims = 3\nElementDataFile = /etc/passwd\n"));
    EXPECT_FALSE(isGood("a.mha", "NDims = 3\nelementdatafile=x.raw\nElementDataFile = LOCAL\n"));
    EXPECT_FALSE(isGood("a.mha", "NDims = 3\n"));
    // what one library takes for a line, and another for two
    EXPECT_FALSE(isGood("a.nrrd", "NRRD0004\n# c\rdata file: /etc/passwd\nsizes: 4 4 4\n\nx"));
    EXPECT_FALSE(isGood("a.mha", "ElementDataFile \r = /etc/passwd\nElementDataFile = LOCAL\n"));
    EXPECT_FALSE(isGood(
        "a.mha", std::string("ElementDataFile\0x = /etc/passwd\nElementDataFile = LOCAL\n", 53)));
    EXPECT_FALSE(
        isGood("a.mha", "Comment = " + std::string(1000, 'x') + "\nElementDataFile = LOCAL\n"));
    EXPECT_FALSE(isGood("a.nrrd", std::string(3'000'000, 'x')));
    EXPECT_TRUE(isGood("a.vdb", "anything"));
}

} // namespace
} // namespace isofront::server

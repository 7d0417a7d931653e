#include "Log.h"
#include "Metrics.h"
#include "TemporaryFolder.h"
#include "scenes/ClientWords.h"
#include "scenes/SceneFiles.h"
#include "scenes/SceneRegistry.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <numeric>
#include <thread>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> pathsIn(const fs::path& folder)
{
    std::vector<std::string> paths;
    for (const SourceFile& file : sourceFilesIn(folder).files)
        paths.push_back(file.path);
    return paths;
}

/// A box of 1 x 2 x 3, its low corner at the origin.
constexpr const char* kBox = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\n"
                             "v 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n"
                             "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

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

TEST_F(Scenes, ofMeshesAreDescribed)
{
    SceneOrigin origin{SceneOrigin::Kind::upload, "box.obj", {}};
    origin.options.meshResolution = 24;
    UploadedFile file(folder.write("coming.part", "mtllib /etc/passwd\n" + std::string(kBox)));
    const auto made = registry->create("", origin, file);
    ASSERT_TRUE(made) << made.error().message;
    const SceneRecord record = prepared(made->id);
    if (record.failure.find("ISOFRONT_WITH_OPENVDB") != std::string::npos)
        GTEST_SKIP() << record.failure;
    ASSERT_EQ(record.state, SceneRecord::State::ready) << record.failure;
    const SceneDescription& box = *record.description;
    EXPECT_EQ(box.kind, "mesh");
    EXPECT_EQ(box.isovalue, 0);
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        EXPECT_LE(box.bounds.low[axis], 0);
        EXPECT_GE(box.bounds.high[axis], axis + 1);
    }
    EXPECT_LT(box.bounds.size().z, 5);
    EXPECT_LT(box.values.low, -0.1); // within
    EXPECT_GT(box.values.high, 0.1);
    EXPECT_GT(
        std::accumulate(box.values.counts.begin(), box.values.counts.end(), std::uint64_t{0}), 0U);
    // a client's file names no others
    ASSERT_EQ(box.notes.size(), 1U);
    EXPECT_EQ(box.notes[0], "its materials are left out: other files aren't read");
    open();
    EXPECT_EQ(registry->find(made->id)->origin.options.meshResolution, 24);
}

TEST_F(Scenes, ofMeshesInOtherFilesAreMadeOfTheServicesOnly)
{
    const std::string gltf =
        R"({"asset":{"version":"2.0"},"buffers":[{"uri":"box.bin","byteLength":36}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                          "min":[0,0,0],"max":[1,1,0]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})";
    const auto made = upload("box.glb", gltf); // readers look at what is in it
    ASSERT_TRUE(made);
    const SceneRecord refused = prepared(made->id);
    EXPECT_EQ(refused.state, SceneRecord::State::failed);
    EXPECT_NE(refused.failure.find("lies in another file"), std::string::npos) << refused.failure;

    const std::array<float, 9> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
    folder.write(
        "sources/box.bin",
        std::string(reinterpret_cast<const char*>(corners.data()), sizeof corners));
    folder.write("sources/box.gltf", gltf);
    const auto ofFile = registry->create("", {SceneOrigin::Kind::file, "box.gltf", {}});
    ASSERT_TRUE(ofFile) << ofFile.error().message;
    const SceneRecord record = prepared(ofFile->id);
    if (record.failure.find("ISOFRONT_WITH_OPENVDB") != std::string::npos)
        GTEST_SKIP() << record.failure;
    EXPECT_EQ(record.state, SceneRecord::State::ready) << record.failure;
}

TEST_F(Scenes, areListedInTheOrderInWhichTheyWereMade)
{
    std::vector<std::string> made;
    for (int i = 0; i < 50; ++i)
        made.push_back(formula("proc:sphere")->id);
    std::vector<std::string> listed;
    std::vector<std::string> times;
    for (const SceneRecord& record : registry->list()) {
        listed.push_back(record.id);
        times.push_back(record.created);
    }
    EXPECT_EQ(listed, made);
    EXPECT_EQ(std::ranges::adjacent_find(times), times.end());
    EXPECT_TRUE(std::ranges::all_of(times, [](const std::string& time) {
        return time.size() == std::string_view("2026-11-22T20:00:00.012345Z").size();
    })) << times[0];
}

TEST_F(Scenes, refuseOptionsThatHaveNoEffect)
{
    const std::map<std::string, std::vector<std::string>> effective{
        {"proc:sphere", {}},
        {"a.vdb", {"grid"}},
        {"a.nrrd", {"voxel_size"}},
        {"a.NII.GZ", {"voxel_size"}},
        {"a.raw", {"raw", "voxel_size"}},
        {"a.raw.gz", {"raw", "voxel_size"}},
        {"a.hgt", {"detail", "pixel_size", "height_scale", "no_data"}},
        {"a.tif", {"voxel_size", "detail", "pixel_size", "height_scale", "no_data"}},
        {"a.ply.gz", {"mesh_resolution", "mesh_reach"}},
        {"folder", {"series", "voxel_size"}}};
    const nlohmann::ordered_json all{
        {"grid", "density"},
        {"series", "1"},
        {"raw", "2x2x2,uint8"},
        {"detail", "natural"},
        {"voxel_size", {1, 1, 1}},
        {"pixel_size", {1, 1}},
        {"height_scale", 2},
        {"no_data", 0},
        {"mesh_resolution", 100},
        {"mesh_reach", 1}};
    EXPECT_EQ(optionsToJson(*parseOptions(all)), all);
    for (const auto& [name, options] : effective)
        for (const auto& [option, value] : all.items()) {
            const bool isFormula = name.starts_with("proc:");
            SceneOrigin origin{SceneOrigin::Kind::upload, name, {}};
            if (isFormula)
                origin.kind = SceneOrigin::Kind::procedural;
            origin.options = *parseOptions({{option, value}});
            const auto checked = checkOptions(origin.options, origin, name == "folder");
            const bool isGood = std::ranges::find(options, option) != options.end();
            EXPECT_EQ(checked.has_value(), isGood) << name << " " << option;
            if (!checked) {
                EXPECT_NE(checked.error().message.find("'" + option + "'"), std::string::npos);
            }
            if (isFormula) {
                EXPECT_FALSE(registry->create("", origin));
            }
        }
    for (const nlohmann::ordered_json& wrong :
         {nlohmann::ordered_json{{"mesh_resolution", 7}},
          {{"mesh_resolution", 100.5}},
          {{"mesh_resolution", 1e300}},
          {{"mesh_resolution", "100"}},
          {{"mesh_reach", 0}},
          {{"grid", "a\nb"}},
          {{"grid", std::string("a\0b", 3)}}})
        EXPECT_FALSE(parseOptions(wrong)) << wrong;
}

TEST_F(Scenes, countUploadsThatAreUnderWay)
{
    settings.scenes = 3;
    settings.storageBytes = 10'000;
    open();
    const SceneOrigin origin = ballIn(SceneOrigin::Kind::upload, "ball.raw", 16); // 4096 bytes
    {
        const auto first = registry->expectUpload(origin);
        const auto second = registry->expectUpload(origin);
        ASSERT_TRUE(first && second);
        EXPECT_FALSE((*first)->extend(6000));
        EXPECT_FALSE((*first)->extend(5000)); // it has them already
        EXPECT_FALSE((*second)->extend(4000));
        const auto full = (*second)->extend(4001);
        ASSERT_TRUE(full);
        EXPECT_EQ(full->status, 507);
        EXPECT_FALSE(uploadBall(16)) << "nothing is left for it";
        // what came in takes the place of what was expected
        UploadedFile file(folder.write("coming.part", ballVolume(16)));
        ASSERT_TRUE(registry->create("", origin, file, first->get()));
        EXPECT_FALSE((*second)->extend(10'000 - 4096));
        EXPECT_TRUE((*second)->extend(10'000 - 4095));
    }
    EXPECT_TRUE(uploadBall(16)) << "given back";
    EXPECT_FALSE(uploadBall(16));
    EXPECT_TRUE(formula("proc:sphere"));
    EXPECT_FALSE(registry->expectUpload(origin)) << "there are three scenes";
    ASSERT_TRUE(*registry->remove(registry->list()[2].id));
    EXPECT_TRUE(registry->expectUpload(origin));
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

    const std::vector<std::string> names = pathsIn(settings.sources);
    EXPECT_EQ(std::ranges::count(names, "scans/ball.raw"), 1);
    EXPECT_EQ(std::ranges::count(names, "readme.txt"), 0);
    EXPECT_EQ(std::ranges::count(names, ".hidden/ball.raw"), 0);
}

/// What is listed can be asked for, and the other way round.
TEST(Sources, areListedAndTakenByOneRule)
{
    const TemporaryFolder folder;
    const std::string dicom = std::string(128, '\0') + "DICM";
    folder.write("a/ball.raw", "x");
    folder.write("a/deep/er/mesh.PLY", "x");
    folder.write("a/readme.txt", "x");
    folder.write("a/.hidden.raw", "x");
    folder.write(".hidden/ball.raw", "x");
    folder.write("two\nlines.raw", "x");
    folder.write("no\xffutf8.raw", "x");
    folder.write("\xc3\xa9tude.nii.gz", "x");
    folder.write("slices/1.dcm", "x");
    folder.write("slices/2.dcm", "x");
    folder.write("one/1.dcm", "x");
    folder.write("nameless/IM1", dicom);
    folder.write("nameless/1.2.840", dicom);
    folder.write("letters/a", "x");
    folder.write("letters/b", "x");
    folder.write("stack/1.tif", "x");
    folder.write("stack/2.tif", "x");
    fs::create_directories(folder.path / "empty.raw");
    fs::create_symlink("a/ball.raw", folder.path / "link.raw");
    fs::create_directory_symlink("slices", folder.path / "linked");
    fs::create_symlink(folder.path / "slices/1.dcm", folder.path / "one/2.dcm");
    ASSERT_EQ(mkfifo((folder.path / "pipe.raw").c_str(), 0600), 0);

    const std::vector<std::string> expected{
        "a/ball.raw",
        "a/deep/er/mesh.PLY",
        "nameless",
        "slices",
        "stack",
        "stack/1.tif",
        "stack/2.tif",
        "\xc3\xa9tude.nii.gz"};
    EXPECT_EQ(pathsIn(folder.path), expected);
    EXPECT_TRUE(sourceFilesIn(folder.path).isComplete);
    std::size_t taken = 0;
    for (const auto& entry : fs::recursive_directory_iterator(
             folder.path, fs::directory_options::follow_directory_symlink)) {
        const std::string path = entry.path().lexically_relative(folder.path).string();
        const bool isListed = std::ranges::find(expected, path) != expected.end();
        EXPECT_EQ(sourceFileIn(folder.path, path).has_value(), isListed) << path;
        taken += isListed ? 1U : 0U;
    }
    EXPECT_EQ(taken, expected.size());
    EXPECT_TRUE(sourceFileIn(folder.path, "slices/"));
    EXPECT_TRUE(sourceFileIn(folder.path, "a//ball.raw"));
    for (const char* const path :
         {"a/../a/ball.raw", "./a/ball.raw", "a/ball.raw/", "linked/1.dcm"})
        EXPECT_FALSE(sourceFileIn(folder.path, path)) << path;
}

TEST(Sources, areListedUpToALimit)
{
    const TemporaryFolder folder;
    for (int i = 0; i < 20; ++i)
        folder.write(std::to_string(i % 3) + "/" + std::to_string(i) + ".raw", "");
    for (const std::size_t most : {1U, 7U, 19U}) {
        const SourceFiles found = sourceFilesIn(folder.path, most);
        EXPECT_EQ(found.files.size(), most);
        EXPECT_FALSE(found.isComplete) << most;
    }
    EXPECT_EQ(sourceFilesIn(folder.path, 20).files.size(), 20U);
    EXPECT_TRUE(sourceFilesIn(folder.path, 20).isComplete);
}

TEST(Sources, thatComeLaterAreListedInTheEnd)
{
    const TemporaryFolder folder;
    SourceFolder sources(folder.path);
    EXPECT_TRUE(sources.files().files.empty());
    folder.write("a.raw", "");
    while (sources.files().files.empty())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(SourceFolder("").files().files.empty());
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

TEST_F(Scenes, ofFormulasThatMakeNoFieldAreNotMade)
{
    for (const char* const text :
         {"proc:sphere?radius=-1",
          "proc:sphere?radius=x",
          "proc:sphere?radius=1&radius=2",
          "proc:sphere?none=1",
          "proc:sphere?radius",
          "proc:sphere?",
          "proc:terrain?preset=none"}) {
        const auto made = formula(text);
        ASSERT_FALSE(made) << text;
        EXPECT_EQ(made.error().code, core::ErrorCode::usage) << text;
    }
    EXPECT_TRUE(registry->list().empty());
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
    EXPECT_EQ(uploadName("dragon.PLY.gz").value_or(""), "dragon.PLY.gz");
    for (const char* const name :
         {"",
          "x",
          "x.exe",
          "head.nhdr",
          "head.mhd",
          "..",
          "/",
          ".nrrd",
          "a/",
          "x.nrrd\n.sh",
          "x.gltf"})
        EXPECT_FALSE(uploadName(name)) << name;
    EXPECT_LE(uploadName(std::string(5000, 'x') + ".nrrd").value_or("").size(), 100U);
}

TEST(ClientWords, areThoseOfRequests)
{
    EXPECT_EQ(
        inClientWords("/data/a/x.raw: give --raw SIZE; see /data/a/y", "/data/a/"),
        "x.raw: give option raw SIZE; see y");
    EXPECT_EQ(inClientWords("(--voxel-size tells)", ""), "(option voxel_size tells)");
    EXPECT_EQ(
        inClientWords("--no-data, --height-scale", ""), "option no_data, option height_scale");
    EXPECT_EQ(
        inClientWords("raise it (--memory-limit)", ""), "raise it (the service's max-memory)");
    for (const char* const text :
         {"", "--", "a--", "-- b", "--rawest", "--raw-raw", "as with gdcmconv --raw or dcmdjpeg"})
        EXPECT_EQ(inClientWords(text, ""), text);
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

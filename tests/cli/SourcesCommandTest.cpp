// Sources of all kinds, as a user names them: through the real program.

#include "cli/CommandFixture.h"
#include "support/FileBytes.h"
#include "volume/DicomBytes.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::cli {
namespace {

using Json = nlohmann::json;

/// Through voxels of 0 to 200, a ball of radius 5 about (8, 8, 8) at 100.
std::uint8_t ballAt(int i, int j, int k)
{
    const double distance = std::sqrt(std::pow(i - 8, 2) + std::pow(j - 8, 2) + std::pow(k - 8, 2));
    return static_cast<std::uint8_t>(std::clamp(100 + 20 * (5 - distance), 0.0, 200.0));
}

class SourcesCommand : public Command {
protected:
    static std::string slice(int k)
    {
        std::string bytes;
        for (int j = 0; j < 17; ++j)
            for (int i = 0; i < 17; ++i)
                bytes += static_cast<char>(ballAt(i, j, k));
        return bytes;
    }
    static std::string ball()
    {
        std::string bytes;
        for (int k = 0; k < 17; ++k)
            bytes += slice(k);
        return bytes;
    }
    static test::DicomSlice dicomSlice(int k, bool hasRuns)
    {
        test::DicomSlice result;
        result.columns = 17;
        result.rows = 17;
        for (int j = 0; j < 17; ++j)
            for (int i = 0; i < 17; ++i)
                result.pixels.push_back(ballAt(i, j, k));
        result.position = {0, 0, double(k)};
        result.instance = k;
        result.hasRuns = hasRuns;
        return result;
    }

    /// Extracts at 100 and expects the ball, `scale` times as large, about its middle.
    void expectBall(const std::string& source, double scale = 1) const
    {
        const Outcome outcome = run("extract " + source + " --isovalue 100 -o ball.ply --json -q");
        ASSERT_EQ(outcome.exitCode, 0) << source << ": " << outcome.errors;
        const Json json = Json::parse(outcome.output);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(double(json["bounds"]["min"][axis]), 3 * scale, 0.1 * scale) << source;
            EXPECT_NEAR(double(json["bounds"]["max"][axis]), 13 * scale, 0.1 * scale) << source;
        }
    }
};

TEST_F(SourcesCommand, readRawNumbersAsTheyAreDescribed)
{
    write("ball.raw", ball());
    expectBall("ball.raw --raw 17x17x17,uint8 --voxel-size 1,1,1");
    expectBall("ball.raw --raw 17x17x17,uint8 --voxel-size 2.5,2.5,2.5", 2.5);
    write("ball.raw.json", R"({"dimensions": [17, 17, 17], "type": "uint8"})");
    expectBall("ball.raw");
    write("late.bin", std::string(100, 'x') + ball());
    expectBall("late.bin --raw 17x17x17,uint8,little,100");

    const Outcome assumed = run("extract ball.raw --raw 17x17x17,uint8 -o a.ply");
    EXPECT_EQ(assumed.exitCode, 0) << assumed.errors;
    EXPECT_NE(assumed.errors.find("--voxel-size"), std::string::npos) << assumed.errors;
    const Outcome less = run("extract ball.raw --raw 17x17x16,uint8 --voxel-size 1,1,1 -o a.ply");
    EXPECT_EQ(less.exitCode, 0) << less.errors;
    EXPECT_NE(less.errors.find("the last 289 are not used"), std::string::npos) << less.errors;
    const Outcome all = run("extract ball.raw --raw 17x17x17,uint8 --voxel-size 1,1,1 -o a.ply");
    EXPECT_EQ(all.errors.find("not used"), std::string::npos) << all.errors;

    expectFailure(
        "extract ball.raw --raw 17x17x18,uint8 -o a.ply", 3, {"ball.raw", "17 x 17 x 18", "4913"});
    expectFailure("extract ball.raw --raw 17x17,uint8 -o a.ply", 2, {"ball.raw", "17x17,uint8"});
    write("plain.raw", ball());
    expectFailure("extract plain.raw -o a.ply", 2, {"plain.raw", "--raw", "plain.raw.json"});
}

TEST_F(SourcesCommand, readTiffSlices)
{
    std::vector<tests::TiffPageBytes> pages;
    fs::create_directory(folder / "slices");
    for (int k = 0; k < 17; ++k) {
        tests::TiffPageBytes page;
        page.width = 17;
        page.height = 17;
        page.chunks = {slice(k)};
        pages.push_back(page);
        write("slices/slice" + std::to_string(k) + ".tif", tests::tiffBytes({pages.back()}));
    }
    write("ball.tif", tests::tiffBytes(pages));
    expectBall("ball.tif --voxel-size 1,1,1");
    expectBall("slices --voxel-size 0.5,0.5,0.5", 0.5);
    expectFailure("extract ball.tif -o a.ply", 2, {"ball.tif", "--voxel-size"});
    const Outcome info = run("info ball.tif --voxel-size 1,1,1 --json");
    ASSERT_EQ(info.exitCode, 0) << info.errors;
    EXPECT_EQ(Json::parse(info.output).at("volume").at("format"), "TIFF");
}

TEST_F(SourcesCommand, readDicomFolders)
{
    fs::create_directories(folder / "scan");
    for (int k = 0; k < 17; ++k)
        write("scan/" + std::to_string(k * 5 % 17), test::dicomBytes(dicomSlice(k, k % 2 == 0)));
    for (int k = 0; k < 3; ++k) {
        test::DicomSlice scout = dicomSlice(k, false);
        scout.series = "1.2.3.77";
        scout.description = "scout";
        write("scan/scout" + std::to_string(k), test::dicomBytes(scout));
    }
    expectBall("scan");
    expectBall("scan --series plain");
    const Outcome scout = run("info scan --series scout --json");
    ASSERT_EQ(scout.exitCode, 0) << scout.errors;
    EXPECT_EQ(Json::parse(scout.output).at("volume").at("dimensions"), Json({17, 17, 3}));
    expectFailure("extract scan --series liver -o a.ply", 2, {"liver", "plain", "scout"});

    std::string packed = test::dicomBytes(dicomSlice(0, true));
    packed[packed.find("1.2.840.10008.1.2.5") + 18] = '9';
    fs::create_directory(folder / "packed");
    write("packed/0", packed);
    expectFailure(
        "extract packed -o a.ply",
        3,
        {"packed", "transfer syntax 1.2.840.10008.1.2.9", "gdcmconv"});
}

TEST_F(SourcesCommand, readFilesThatAPresetNames)
{
    fs::create_directories(folder / "maps/heights");
    // A ramp towards the east: 0 to 400 m over 800 m.
    std::vector<std::uint16_t> heights;
    for (int j = 0; j < 9; ++j)
        for (int i = 0; i < 9; ++i)
            heights.push_back(static_cast<std::uint16_t>(50 * i));
    write("maps/heights/ramp.png", tests::greyPngBytes(9, 9, heights));
    writeNrrd("maps/block.nrrd", {3, 3, 3}, std::vector<float>(27, 7.0F));
    const auto preset = [](const std::string& file) {
        return R"({"isofrontGraph": 1, "name": "n", "description": "d",
  "box": {"centre": [0, 0, 200], "edge": 800},
  "nodes": {"land": {"type": "elevation", "file": ")" +
               file + R"(", "pixelSize": 100},
    "block": {"type": "placed", "at": [0, 0, 500], "scale": 30,
              "input": {"type": "volume", "file": "block.nrrd", "isovalue": 5}},
    "all": {"type": "max", "inputs": ["land", "block"]}},
  "result": "all",
  "materials": [{"name": "stone", "colour": "#102030", "where": "block"},
                {"name": "grass", "colour": "#405060"}]})";
    };
    write("maps/ramp.json", preset("heights/ramp.png"));
    const Outcome outcome = run("extract 'proc:graph?file=maps/ramp.json' --spacing 12.5 "
                                "--attributes -o ramp.ply --json -q");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
    const Json bounds = Json::parse(outcome.output)["bounds"];
    // The land reaches from wall to wall, and the block floats above it, 60 m wide.
    EXPECT_NEAR(double(bounds["min"][2]), 0, 1);
    EXPECT_NEAR(double(bounds["max"][2]), 560, 7);
    const std::string ply = contentsOf(folder / "ramp.ply");
    EXPECT_NE(ply.find("property uint attribute"), std::string::npos);
    EXPECT_NE(ply.find(std::string("\x10\x20\x30\x01", 4)), std::string::npos);
    EXPECT_NE(ply.find(std::string("\x40\x50\x60\x02", 4)), std::string::npos);

    write("maps/lost.json", preset("heights/lost.png"));
    expectFailure(
        "extract 'proc:graph?file=maps/lost.json' -o a.ply",
        4,
        {"maps/lost.json", "'land'", "heights/lost.png"});
    write("maps/slip.json", "{\n  \"isofrontGraph\": 1,,\n}");
    expectFailure(
        "extract 'proc:graph?file=maps/slip.json' -o a.ply",
        3,
        {"maps/slip.json", "line 2, column 22", "a name in double quotes"});
}

#ifdef ISOFRONT_WITH_OPENVDB
TEST_F(SourcesCommand, takeMeshesWhoseIsovalueIsAnOffset)
{
    ASSERT_EQ(run("extract proc:sphere --level 9 -q -o ball.ply").exitCode, 0);
    const Json mesh = Json::parse(run("info ball.ply --json").output);
    EXPECT_EQ(mesh.at("description"), "mesh");
    for (const double offset : {0.0, 0.05, -0.05}) {
        const Outcome outcome =
            run("extract ball.ply --mesh-resolution 32 --mesh-reach 0.1 --isovalue " +
                std::to_string(offset) + " -o grown.glb --json -q");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
        const Json json = Json::parse(outcome.output);
        EXPECT_GT(json["triangles"], 1000);
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(
                double(json["bounds"]["max"][axis]),
                double(mesh["world_box"]["max"][axis]) + offset,
                0.01);
    }
    expectFailure("extract ball.ply --mesh-resolution 7 -o a.ply", 2, {"--mesh-resolution"});
    expectFailure("extract ball.ply --mesh-reach 5 -o a.ply", 2, {"ball.ply", "longest edge"});
    expectFailure("extract ball.ply --memory-limit 0.001 -o a.ply", 6, {"ball.ply"});
    // a tent, open below
    write("tent.obj", "v 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 -1 0\nf 1 2 3\nf 1 3 4\nf 1 4 2\n");
    const Outcome open = run("extract tent.obj --mesh-resolution 32 -o tent.ply");
    EXPECT_EQ(open.exitCode, 0) << open.errors;
    EXPECT_NE(open.errors.find("note: 3 edges belong to one triangle only"), std::string::npos)
        << open.errors;
}
#endif

TEST_F(SourcesCommand, areListedInTheHelpOfEveryCommandThatTakesThem)
{
    for (const char* command : {
             "extract",
             "info",
#ifdef ISOFRONT_WITH_VULKAN
             "render",
             "fly",
#endif
         }) {
        const Outcome help = run(std::string(command) + " --help");
        EXPECT_EQ(help.exitCode, 0);
        for (const char* kind :
             {".nrrd", ".vdb", ".hgt", "DICOM", "TIFF", ".raw", ".glb", "proc:NAME"})
            EXPECT_NE(help.output.find(kind), std::string::npos) << command << " " << kind;
    }
}

#ifdef ISOFRONT_WITH_VULKAN
TEST_F(SourcesCommand, areDrawnWithANoteOnTheIsovalueAndFillThePicture)
{
    // A ball in a corner of much empty room.
    std::vector<float> values(64 * 64 * 64);
    for (int k = 0; k < 17; ++k)
        for (int j = 0; j < 17; ++j)
            for (int i = 0; i < 17; ++i)
                values[static_cast<std::size_t>((k * 64 + j) * 64 + i)] = float(ballAt(i, j, k));
    writeNrrd("ball.nrrd", {64, 64, 64}, values);
    const Outcome told = run("render ball.nrrd --size 64x48 -o a.png");
    ASSERT_EQ(told.exitCode, 0) << told.errors;
    EXPECT_NE(told.errors.find("no --isovalue given"), std::string::npos) << told.errors;
    const Outcome given = run("render ball.nrrd --isovalue 100 --size 64x48 -o a.png --json");
    ASSERT_EQ(given.exitCode, 0) << given.errors;
    EXPECT_EQ(given.errors.find("no --isovalue given"), std::string::npos) << given.errors;
    const Json json = Json::parse(given.output);
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(double(json["target"][axis]), 8, 4) << axis;
}
#endif

} // namespace
} // namespace isofront::cli

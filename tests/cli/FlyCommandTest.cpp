// Flights of voxel models, and of fields with voxels in the distance, through the real program.

#include "cli/CommandFixture.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::cli {
namespace {

using Json = nlohmann::json;

class FlyCommand : public Command {
protected:
    Json json(const std::string& arguments) const
    {
        const Outcome outcome = run(arguments + " --json -q", "ISOFRONT_DEVICE=cpu");
        EXPECT_EQ(outcome.exitCode, 0) << arguments << "\n" << outcome.errors;
        return outcome.exitCode == 0 ? Json::parse(outcome.output) : Json();
    }
    Json reportOf(const std::string& flight) const
    {
        return Json::parse(contentsOf(folder / flight / "report.json"));
    }
};

TEST_F(FlyCommand, goesAroundAModelWithinItsCache)
{
    json("voxelize proc:sphere --resolution 600 -o ball.voxels");
    const std::string fly = "fly ball.voxels --size 240x160 --frames 5 --speed 9 ";
    const Json flown = json(fly + "--measure-popping --out ample");
    EXPECT_EQ(flown["frames"], 5);
    EXPECT_EQ(flown["mean_triangles"], 0);
    EXPECT_EQ(flown["effective_voxel_pixels_max"], 1);
    EXPECT_EQ(flown["chunks_damaged"], 0);
    const Json ample = reportOf("ample");
    EXPECT_TRUE(ample["settings"]["pixel_error"].is_null());
    EXPECT_EQ(ample["settings"]["others"]["model"], "proc:sphere");
    EXPECT_EQ(ample["summary"]["voxels_mean"], flown["mean_voxels"]);
    for (const Json& frame : ample["frames"]) {
        EXPECT_GT(frame["voxels"], 5000);
        EXPECT_EQ(frame["triangles"], 0);
        EXPECT_TRUE(frame["largest_pop"].is_number());
    }
    // it is gone around, and come nearer to
    const auto distance = [&](std::size_t frame) {
        const Json& eye = ample["frames"][frame]["eye"];
        return std::hypot(eye[0].get<double>(), eye[1].get<double>(), eye[2].get<double>());
    };
    EXPECT_GT(distance(0), 2.0);
    EXPECT_LT(distance(4), distance(0));
    EXPECT_NE(ample["frames"][0]["eye"], ample["frames"][4]["eye"]);

    const Json close = json(fly + "--voxel-pixels 0.5 --cache-mib 1 --out small");
    EXPECT_GT(close["effective_voxel_pixels_max"], 0.5) << "it doesn't fit";
    const Json small = reportOf("small");
    EXPECT_LE(small["summary"]["voxel_bytes_max"], 1 << 20);
    EXPECT_GT(small["summary"]["voxel_bytes_max"], 0);
    EXPECT_EQ(small["summary"]["effective_voxel_pixels_max"], close["effective_voxel_pixels_max"]);
}

TEST_F(FlyCommand, staysAboveIslandsThatFloat)
{
    // of this seed one begins over nothing
    const Json flown =
        json("fly --preset islands --seed 1 --size 96x54 --pixel-error 6 --frames 2 --out flight");
    EXPECT_GT(flown["mean_triangles"], 1000);
    const Json report = reportOf("flight");
    for (const Json& frame : report["frames"])
        EXPECT_GT(frame["eye"][2].get<double>(), 0) << "below them";
}

TEST_F(FlyCommand, keepsClearOfTheGroundOfALandscapesModel)
{
    const Json made = json("voxelize proc:terrain --resolution 160 -o land.voxels");
    json("fly land.voxels --size 64x36 --frames 9 --speed 9000 --out land");
    const double least = 24 * made["model"]["voxel_edge"].get<double>();
    for (const Json& frame : reportOf("land")["frames"]) {
        std::string ray;
        for (const Json& coordinate : frame["eye"])
            ray += coordinate.dump() + ",";
        const Json hit = json("info land.voxels --ray " + ray + "0,0,-1")["hit"];
        ASSERT_FALSE(hit.is_null());
        // half of it: between two looks at the ground, and under the mean of several
        EXPECT_GT(hit["distance"], 0.5 * least);
    }
}

TEST_F(FlyCommand, showsCoarserVoxelsWhereAModelIsDamaged)
{
    json("voxelize proc:sphere --resolution 300 --format folder -o ball");
    for (const auto& file : fs::directory_iterator(folder / "ball" / "0"))
        fs::remove(file.path());
    const Outcome flown =
        run("fly ball --size 160x90 --voxel-pixels 0.3 --frames 2 --out f --json",
            "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(flown.exitCode, 0) << flown.errors;
    EXPECT_NE(flown.errors.find("of level 0 is missing"), std::string::npos) << flown.errors;
    EXPECT_GT(Json::parse(flown.output)["chunks_damaged"], 0);
    EXPECT_GT(Json::parse(flown.output)["mean_voxels"], 1000);
}

TEST_F(FlyCommand, showsTheDistanceOfAPictureAsVoxelsToo)
{
    const std::string draw = "render proc:gyroid --eye 0,-60,0 --size 160x120 ";
    const Json meshes = json(draw + "-o meshes.png");
    EXPECT_TRUE(meshes["far_field"].is_null());
    json("voxelize proc:gyroid --resolution 200 -o gyroid.voxels");
    const Json made = json(draw + "--far-voxels 200 -o made.png");
    const Json stored = json(draw + "--far-voxels gyroid.voxels -o stored.png");
    EXPECT_EQ(made["far_field"], stored["far_field"]);
    EXPECT_EQ(contentsOf(folder / "made.png"), contentsOf(folder / "stored.png"));
    EXPECT_EQ(made["far_field"]["resolution"], 200);
    EXPECT_EQ(made["far_field"]["mesh_blocks"], 0);
    EXPECT_GT(made["far_field"]["voxel_blocks"], 0);
    EXPECT_GT(made["far_field"]["voxels_drawn"], 1000);
    EXPECT_EQ(made["triangles_drawn"], 0);
    EXPECT_NE(contentsOf(folder / "made.png"), contentsOf(folder / "meshes.png"));
    // none of it is far enough for such an error
    const Json near = json(draw + "--far-voxels 4 --hand-over 0.05 -o near.png");
    EXPECT_EQ(near["far_field"]["voxel_blocks"], 0);
    EXPECT_EQ(near["triangles_drawn"], meshes["triangles_drawn"]);
    EXPECT_EQ(contentsOf(folder / "near.png"), contentsOf(folder / "meshes.png"));
}

TEST_F(FlyCommand, teachesWhatAFarFieldIs)
{
    write("text.voxels", "mine");
    const std::string draw = "render proc:sphere -o a.png";
    const std::string fly = "fly proc:sphere --out f";
    const auto expectNotUnderstood = [&](const std::string& command, const std::string& wrong) {
        expectFailure(
            command + " --far-voxels '" + wrong + "'",
            2,
            {"--far-voxels '" + wrong + "'", "a whole number of voxels", "isofront voxelize"});
    };
    for (const std::string wrong : {"-5", "256.5", "", "1e3"})
        expectNotUnderstood(draw, wrong);
    expectNotUnderstood(fly, "abc");
    for (const std::string wrong : {"1", "99999999999999999999"})
        expectFailure(draw + " --far-voxels " + wrong, 2, {wrong, "2 to 8192"});
    expectFailure(fly + " --far-voxels 8193", 2, {"8193", "2 to 8192"});
    expectFailure(draw + " --far-voxels none.voxels", 4, {"none.voxels", "no such file"});
    expectFailure(fly + " --far-voxels no/where", 4, {"no/where", "no such file"});
    for (const std::string& command : {draw, fly}) {
        expectFailure(command + " --far-voxels text.voxels", 3, {"--far-voxels", "text.voxels"});
        expectFailure(command + " --hand-over 2", 2, {"--hand-over", "--far-voxels"});
        expectFailure(command + " --cache-mib 9", 2, {"--cache-mib", "without --far-voxels"});
    }
    EXPECT_FALSE(fs::exists(folder / "f"));
    EXPECT_FALSE(fs::exists(folder / "a.png"));
}

TEST_F(FlyCommand, saysHowManyVoxelsWouldTakeOver)
{
    const std::string draw = "render proc:gyroid --size 160x120 -o a.png --json --far-voxels ";
    const Outcome coarse = run(draw + "16", "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(coarse.exitCode, 0) << coarse.errors;
    EXPECT_EQ(Json::parse(coarse.output)["far_field"]["voxel_blocks"], 0);
    const std::string words = ": --far-voxels ";
    const std::size_t at = coarse.errors.find(words);
    ASSERT_NE(at, std::string::npos) << coarse.errors;
    const std::string enough = std::to_string(std::stoi(coarse.errors.substr(at + words.size())));
    const Outcome fine = run(draw + enough, "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(fine.exitCode, 0) << fine.errors;
    EXPECT_GT(Json::parse(fine.output)["far_field"]["voxel_blocks"], 0);
    EXPECT_EQ(fine.errors.find("--hand-over"), std::string::npos) << fine.errors;
}

TEST_F(FlyCommand, refusesAFarFieldOfAnotherSurfaceAndNamesBoth)
{
    const auto make = [&](const std::string& source, const std::string& name) {
        json("voxelize " + source + " --resolution 40 -o " + name);
    };
    const std::string torus = "'proc:torus?tube=0.2'";
    make(torus, "torus.voxels");
    const auto draw = [&](const std::string& source, const std::string& far) {
        return "render " + source + " --size 64x36 -o a.png --far-voxels " + far;
    };
    // however it is written
    json(draw("'proc:torus?tube=2e-1&ring=0.75'", "torus.voxels"));
    json(draw("'proc:torus?ring=0.750&tube=.2'", "torus.voxels"));
    const Json field = json("info torus.voxels")["model"]["field"];
    EXPECT_EQ(field["source"], "proc:torus?ring=0.75&tube=0.2");
    EXPECT_EQ(field["isovalue"], 0);
    EXPECT_EQ(field["filter"], 0.5);
    EXPECT_EQ(field["closed"], false);
    expectFailure(
        draw("proc:torus", "torus.voxels"),
        2,
        {"torus.voxels", "proc:torus?ring=0.75&tube=0.2", "proc:torus?ring=0.75&tube=0.3"});
    expectFailure(draw("proc:sphere", "torus.voxels"), 2, {"proc:torus", "proc:sphere"});
    expectFailure(
        draw(torus, "torus.voxels --isovalue 0.05"), 2, {"isovalue 0.05", "isovalue 0.0,"});
    expectFailure(draw(torus, "torus.voxels --filter 1"), 2, {"by 1.0", "by 0.5", "--filter"});
    // of the two filters that are taken, the other: 5 times as strong in pictures, 7.5 in flights
    make(torus + " --filter 3.75", "smoother.voxels");
    json("fly " + torus + " --frames 1 --size 64x36 --out flown --far-voxels smoother.voxels");
    make(torus + " --filter 2.5", "smooth.voxels");
    json(draw(torus, "smooth.voxels"));
    expectFailure(draw(torus, "smooth.voxels --filter 1"), 2, {"by 2.5", "by 1.0", "--filter 5"});
    expectFailure(draw(torus, "torus.voxels --closed"), 2, {"open", "--closed"});
    expectFailure("fly proc:torus --out f --far-voxels torus.voxels", 2, {"tube=0.2", "tube=0.3"});
    EXPECT_FALSE(fs::exists(folder / "f"));
    // a mesh, however like it looks
    ASSERT_EQ(run("extract " + torus + " --level 9 -q -o torus.ply").exitCode, 0);
    make("torus.ply", "mesh.voxels");
    expectFailure(draw(torus, "mesh.voxels"), 2, {"torus.ply", "a mesh", "proc:torus"});
    // a file that has changed, or lies elsewhere
    std::vector<float> values(8 * 8 * 8);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = float(i % 8);
    writeNrrd("a.nrrd", {8, 8, 8}, values);
    make("a.nrrd --isovalue 3.5", "volume.voxels");
    json(draw("a.nrrd", "volume.voxels --isovalue 3.5"));
    fs::create_directory(folder / "moved");
    fs::copy(folder / "a.nrrd", folder / "moved/a.nrrd");
    json(draw("moved/a.nrrd", "volume.voxels --isovalue 3.5"));
    expectFailure(
        draw("a.nrrd", "volume.voxels --isovalue 3.5 --voxel-size 1,2,1"), 2, {"other options"});
    for (float& value : values)
        value = 7 - value;
    writeNrrd("a.nrrd", {8, 8, 8}, values);
    expectFailure(draw("a.nrrd", "volume.voxels --isovalue 3.5"), 2, {"another a.nrrd", "again"});
}

TEST_F(FlyCommand, refusesWhatChangesNothingAndLeavesNoFolder)
{
    json("voxelize proc:sphere --resolution 16 -o ball.voxels");
    json("voxelize proc:sphere --isovalue 100 --resolution 16 -o empty.voxels");
    for (const std::string option :
         {"--isovalue 1",
          "--far-voxels 100",
          "--pixel-error 2",
          "--lattice 4",
          "--preset canyon",
          "--seed 3",
          "--max-memory 3MiB"})
        expectFailure(
            "fly ball.voxels --out f " + option,
            2,
            {option.substr(0, option.find(' ')), "voxel model"});
    for (const std::string option : {"--way cubes", "--voxel-pixels 2", "--up 0,1,0"})
        expectFailure(
            "fly proc:sphere --out f " + option,
            2,
            {option.substr(0, option.find(' ')), "no voxel model"});
    expectFailure("fly ball.voxels --out f --up 0,0,0", 2, {"--up"});
    expectFailure("fly empty.voxels --out f/g", 3, {"empty.voxels", "no voxels"});
    expectFailure("fly none.voxels --out f", 4, {"none.voxels"});
    EXPECT_FALSE(fs::exists(folder / "f"));
    write("file", "mine");
    expectFailure("fly ball.voxels --out file/g", 4, {"--out file/g"});
}

} // namespace
} // namespace isofront::cli

// Meshes and voxel models through the real program.

#include "cli/CommandFixture.h"

#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <string>

namespace isofront::cli {
namespace {

using Json = nlohmann::json;

/// A tetrahedron with one corner at the origin and three on the axes, closed.
constexpr const char* kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\n"
                                     "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class ModelsCommand : public Command {
protected:
    Json json(const std::string& arguments) const
    {
        const Outcome outcome = run(arguments + " --json -q");
        EXPECT_EQ(outcome.exitCode, 0) << arguments << "\n" << outcome.errors;
        return outcome.exitCode == 0 ? Json::parse(outcome.output) : Json();
    }
    void writeBall() const
    {
        ASSERT_EQ(run("extract proc:sphere --level 9 --quality plain -q -o ball.ply").exitCode, 0);
    }
    /// All files of a folder, by their names in it.
    std::map<std::string, std::string> filesOf(const std::string& name) const
    {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::recursive_directory_iterator(folder / name))
            if (entry.is_regular_file())
                files[fs::relative(entry.path(), folder / name)] = contentsOf(entry.path());
        return files;
    }
    /// Names in the test's folder that begin so.
    std::size_t leftOf(const std::string& begin) const
    {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(folder))
            count += entry.path().filename().string().starts_with(begin) ? 1U : 0U;
        return count;
    }
};

TEST_F(ModelsCommand, voxelizeAMeshAndTellWhatItBecame)
{
    writeBall();
    const Json mesh = json("info ball.ply");
    const Json made = json("voxelize ball.ply --resolution 400 -o ball.voxels");
    for (const char* key :
         {"output",
          "bytes",
          "scratch_bytes",
          "touched_voxels",
          "empty_regions",
          "bounds",
          "seconds",
          "peak_rss_bytes",
          "threads",
          "settings",
          "warnings"})
        EXPECT_TRUE(made.contains(key)) << key;
    for (const char* key : {"total", "load", "voxelize", "finish"})
        EXPECT_TRUE(made["seconds"].contains(key)) << key;
    EXPECT_EQ(made["mesh"], mesh["mesh"]);
    EXPECT_EQ(made["bounds"], mesh["world_box"]);
    EXPECT_EQ(made["mesh"]["open_edges"], 0);
    EXPECT_EQ(made["empty_regions"], 1) << "the inside of the ball";
    EXPECT_EQ(made["bytes"], fs::file_size(folder / "ball.voxels"));

    const Json told = json("info ball.voxels --check");
    const Json& model = told["model"];
    for (const auto& [key, value] : made["model"].items())
        EXPECT_EQ(model[key], value) << key;
    EXPECT_EQ(model["name"], "ball.ply");
    EXPECT_EQ(model["format"], "lmdb");
    EXPECT_EQ(model["levels"], 2);
    EXPECT_EQ(model["damaged"], Json::array());
    EXPECT_EQ(model["voxels_by_level"][0], model["voxels"]);
    EXPECT_EQ(
        model["voxels_by_level"][0].get<std::uint64_t>() +
            model["voxels_by_level"][1].get<std::uint64_t>(),
        model["all_voxels"]);
    EXPECT_EQ(model["chunks_by_level"], Json({8, 1}));
    // A sphere of area A crosses the middle lines of E|n|_1 A = 1.5 A voxels, which is as many as
    // it touches; and separates by E max|n_i| A, where E max|n_i| = 3 sqrt(2) atan(1 / sqrt(2)) /
    // pi.
    const double area = 3.141592653589793 * 399.5 * 399.5;
    const double largest = 3 * std::sqrt(2.0) * std::atan(std::sqrt(0.5)) / 3.141592653589793;
    EXPECT_NEAR(double(model["voxels"]), largest * area, 0.003 * area);
    EXPECT_NEAR(double(made["touched_voxels"]), 1.5 * area, 0.006 * area);
    // the coarsest level contains the mesh, and is at most a coarse voxel larger
    const double edge = model["voxel_edge"];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = made["bounds"]["min"][axis];
        const double high = made["bounds"]["max"][axis];
        EXPECT_NEAR(double(told["world_box"]["min"][axis]), low, 2 * edge);
        EXPECT_NEAR(double(told["world_box"]["max"][axis]), high, 2 * edge);
    }
    EXPECT_EQ(run("info ball.voxels").errors, "");
}

TEST_F(ModelsCommand, voxelizeToTheSameBytesOnAnyNumberOfThreads)
{
    writeBall();
    for (const std::string threads : {"1", "3"})
        json(
            "voxelize ball.ply --resolution 520 --format folder --threads " + threads + " -o t" +
            threads);
    const auto files = filesOf("t1");
    EXPECT_GT(files.size(), 20U);
    EXPECT_TRUE(files == filesOf("t3"));
    EXPECT_EQ(json("info t3 --check")["model"]["format"], "folder");
}

TEST_F(ModelsCommand, voxelizeAsTheOptionsSay)
{
    writeBall();
    const auto voxels = [&](const std::string& options) {
        return json("voxelize ball.ply --resolution 100 -o a.voxels " + options);
    };
    const Json six = voxels("");
    const Json all = voxels("--conservative");
    EXPECT_EQ(all["model"]["separability"], "conservative");
    EXPECT_EQ(all["model"]["voxels"], six["touched_voxels"]);
    EXPECT_LT(six["model"]["voxels"], all["model"]["voxels"]);
    EXPECT_EQ(voxels("--all-faces")["empty_regions"], 0);
    EXPECT_EQ(voxels("--all-faces")["model"]["voxels"], six["model"]["voxels"]);
}

TEST_F(ModelsCommand, tellWhatIsUnusualInAMesh)
{
    write("whole.obj", kTetrahedron);
    const Json whole = json("info whole.obj");
    EXPECT_EQ(whole["mesh"]["triangles"], 4);
    EXPECT_EQ(whole["mesh"]["vertices"], 4);
    EXPECT_EQ(whole["mesh"]["notes"], Json::array());
    EXPECT_EQ(whole["world_box"], Json({{"min", {0, 0, 0}}, {"max", {1, 2, 4}}}));

    write(
        "odd.obj", std::string(kTetrahedron) + "v nan 0 0\nf 1 2 5\nf 1 2 99\nf 1 1 2\nf 1 2 3\n");
    const Json odd = json("info odd.obj")["mesh"];
    EXPECT_EQ(odd["not_finite"], 1);
    EXPECT_EQ(odd["out_of_range"], 1);
    EXPECT_EQ(odd["degenerate"], 1);
    EXPECT_EQ(odd["notes"].size(), 4U) << odd.dump();
    const Outcome made = run("voxelize odd.obj --resolution 20 -o odd.voxels");
    EXPECT_EQ(made.exitCode, 0) << made.errors;
    EXPECT_NE(made.errors.find("warning: 1 triangles have no area"), std::string::npos)
        << made.errors;
}

TEST_F(ModelsCommand, refuseWhatMakesNoSenseAndLeaveNothingBehind)
{
    write("a.obj", kTetrahedron);
    write("flat.obj", "v 0 0 0\n");
    write("cut.stl", std::string(100, 'x'));
    const std::string rest = " --resolution 20 -o x.voxels";
    expectFailure("voxelize a.obj -o x.voxels", 2, {"--resolution"});
    expectFailure("voxelize a.obj --resolution 20", 2, {"--output"});
    expectFailure("voxelize a.obj --resolution 0 -o x.voxels", 2, {"--resolution"});
    expectFailure("voxelize a.obj --resolution 65537 -o x.voxels", 2, {"65536"});
    expectFailure("voxelize a.obj --format tree" + rest, 2, {"--format", "lmdb", "folder"});
    expectFailure("voxelize a.xyz" + rest, 2, {"a.xyz", ".ply"});
    expectFailure("voxelize none.obj" + rest, 4, {"none.obj"});
    expectFailure("voxelize cut.stl" + rest, 3, {"cut.stl"});
    expectFailure("voxelize flat.obj" + rest, 3, {"flat.obj", "no triangles"});
    expectFailure("voxelize a.obj --resolution 20 -o no/x.voxels", 4, {"no/x.voxels"});
    expectFailure("voxelize a.obj --resolution 20 -o a.obj", 2, {"a.obj", "source"});
    expectFailure("voxelize a.obj --scratch no/where" + rest, 4, {"no/where"});
    fs::create_directory(folder / "full");
    write("full/mine", "mine");
    expectFailure("voxelize a.obj --resolution 20 --format folder -o full", 2, {"full"});
    expectFailure("voxelize a.obj --resolution 20 -o full", 4, {"full"});
    expectFailure("voxelize flat.obj --resolution 20 --format folder -o x.folder", 3, {"flat.obj"});
    write("big.obj", std::string(2 << 20, '\n') + kTetrahedron);
    expectFailure("voxelize big.obj --memory-limit 0.001" + rest, 6, {"big.obj", "bytes"});
    expectFailure("info a.obj --check", 2, {"--check", "a.obj"});
    EXPECT_EQ(leftOf("x."), 0U);
    EXPECT_EQ(contentsOf(folder / "full/mine"), "mine");
}

TEST_F(ModelsCommand, leaveWhatWasThereIfTheyAreInterrupted)
{
    writeBall();
    json("voxelize ball.ply --resolution 20 -o earlier");
    const std::string earlier = contentsOf(folder / "earlier");
    for (const std::string source : {"ball.ply", "proc:sphere"})
        for (const std::string format : {"lmdb", "folder"}) {
            const bool isFile = format == "lmdb";
            if (isFile)
                write("m", earlier);
            // told to end when it has begun; if that comes too late, the model has to be whole
            const std::string script =
                "cd '" + folder.string() + "' && { '" ISOFRONT_BINARY "' voxelize " + source +
                " -q --resolution 8192 --format " + format +
                " -o m 2>stderr & } ; "
                "while kill -0 $! 2>/dev/null && [ ! -e m.part ]; do sleep 0.01; done; "
                "kill -TERM $! 2>/dev/null; wait $!";
            const int status = std::system(script.c_str());
            ASSERT_TRUE(WIFEXITED(status));
            if (WEXITSTATUS(status) == 0) {
                const Json model = json("info m --check")["model"];
                EXPECT_EQ(model["resolution"], 8192) << model;
                EXPECT_GT(model["voxels"], 8192 * 8192) << model;
            } else {
                EXPECT_EQ(WEXITSTATUS(status), 130) << contentsOf(folder / "stderr");
                EXPECT_EQ(leftOf("m"), isFile ? 1U : 0U) << "the model, or a part of it";
                if (isFile) {
                    EXPECT_EQ(contentsOf(folder / "m"), earlier);
                }
            }
            fs::remove_all(folder / "m");
        }
}

TEST_F(ModelsCommand, waitBetweenThePassesWhereTheModelGoes)
{
    write("a.obj", kTetrahedron);
    // no files can be made in this folder for temporary ones, not even by root
    const Outcome made = run("voxelize a.obj --resolution 20 -o x.voxels", "TMPDIR=/proc");
    EXPECT_EQ(made.exitCode, 0) << made.errors;
    EXPECT_EQ(leftOf("x.voxels"), 1U);
    EXPECT_EQ(leftOf("isofront-"), 0U);
}

TEST_F(ModelsCommand, nameDamagedChunks)
{
    writeBall();
    json("voxelize ball.ply --resolution 400 --format folder -o ball");
    const fs::path chunk = folder / "ball/0/1-0-1.chunk"; // z, y, x
    std::string bytes = contentsOf(chunk);
    ASSERT_GT(bytes.size(), 100U);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    write("ball/0/1-0-1.chunk", bytes);
    EXPECT_EQ(run("info ball").exitCode, 0) << "it isn't read";
    const Outcome checked = run("info ball --check --json");
    EXPECT_EQ(checked.exitCode, 3);
    EXPECT_NE(checked.errors.find("chunk 1, 0, 1 of level 0"), std::string::npos) << checked.errors;
    EXPECT_EQ(Json::parse(checked.output)["model"]["damaged"].size(), 1U);
    json("voxelize ball.ply --resolution 400 -o whole");
    const std::string whole = contentsOf(folder / "whole");
    for (const std::size_t kept :
         {whole.size() - 1, whole.size() / 2, std::size_t{9000}, std::size_t{100}}) {
        write("cut", whole.substr(0, kept));
        expectFailure("info cut", 3, {"cut"});
    }
    fs::remove(chunk);
    const Outcome missing = run("info ball --check");
    EXPECT_EQ(missing.exitCode, 3);
    EXPECT_NE(missing.errors.find("chunk 1, 0, 1 of level 0 is missing"), std::string::npos)
        << missing.errors;
    EXPECT_EQ(json("info ball")["model"]["chunks_missing"], 1);
    EXPECT_NE(run("info ball").output.find("missing      1 chunk;"), std::string::npos);
}

TEST_F(ModelsCommand, voxelizeFieldsOfFormulas)
{
    const Json made = json("voxelize proc:sphere --resolution 300 -o ball.voxels");
    const Json& model = made["model"];
    EXPECT_EQ(model["name"], "proc:sphere");
    EXPECT_EQ(model["resolution"], 300);
    EXPECT_EQ(model["levels"], 2);
    EXPECT_EQ(model["coloured"], true);
    EXPECT_EQ(made["empty_regions"], 1) << "the inside of the ball";
    EXPECT_GT(made["field"]["samples"], 0);
    EXPECT_EQ(made["field"]["sanitised_samples"], 0);
    EXPECT_FALSE(made.contains("touched_voxels"));
    EXPECT_EQ(json("info ball.voxels --check")["model"]["damaged"], Json::array());

    // a larger ball has more voxels, and a solid beyond the border is closed only on request
    const Json larger =
        json("voxelize proc:sphere --resolution 300 --isovalue -0.1 -o larger.voxels");
    EXPECT_GT(larger["model"]["voxels"], model["voxels"]);
    const Json open = json("voxelize proc:plane --resolution 20 --filter 0 -o open.voxels");
    const Json closed =
        json("voxelize proc:plane --resolution 20 --filter 0 --closed -o closed.voxels");
    EXPECT_EQ(open["model"]["voxels"], 20 * 20);
    EXPECT_GT(closed["model"]["voxels"], 3 * 20 * 20);
}

TEST_F(ModelsCommand, voxelizeVolumesAtTheirOwnVoxels)
{
    std::vector<float> values;
    for (int z = 0; z < 20; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 30; ++x)
                values.push_back(static_cast<float>(8 - std::hypot(x - 14, y - 12, z - 10)));
    writeNrrd("ball.nrrd", {30, 24, 20}, values);
    const Json own = json("voxelize ball.nrrd --isovalue 0 --filter 0 -o own.voxels");
    EXPECT_EQ(own["model"]["resolution"], 30);
    EXPECT_EQ(own["model"]["voxel_edge"], 1);
    // the middle of a voxel is a sample of the volume
    const Json bounds = own["bounds"];
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(own["model"]["origin"][axis], bounds["min"][axis].get<double>() - 0.5);
    EXPECT_EQ(own["field"]["isovalue"], 0);
    // as many voxels as there are, asked for by their number
    const Json same =
        json("voxelize ball.nrrd --isovalue 0 --filter 0 --resolution 30 -o same.voxels");
    EXPECT_EQ(contentsOf(folder / "own.voxels"), contentsOf(folder / "same.voxels"));
    // voxels stay cubes where those of the volume are not: of the least spacing
    const Json tall =
        json("voxelize ball.nrrd --voxel-size 1,1,3 --isovalue 0 --filter 0 -o tall.voxels");
    EXPECT_EQ(tall["model"]["voxel_edge"], 1);
    EXPECT_EQ(tall["model"]["resolution"], 19 * 3 + 1);
    EXPECT_GT(tall["model"]["voxels"], own["model"]["voxels"]);
}

TEST_F(ModelsCommand, sayWhichOptionsOfVoxelizeAreForWhat)
{
    write("tetrahedron.obj", kTetrahedron);
    expectFailure("voxelize tetrahedron.obj -o t.voxels", 2, {"--resolution"});
    expectFailure("voxelize proc:torus -o t.voxels", 2, {"proc:torus", "--resolution"});
    expectFailure("voxelize proc:none --resolution 8 -o t.voxels", 2, {"proc:none"});
    for (const std::string option :
         {"--closed", "--isovalue 3", "--filter 0.5", "--voxel-size 1,1,1", "--detail none"})
        expectFailure(
            "voxelize tetrahedron.obj --resolution 8 -o t.voxels " + option,
            2,
            {option.substr(0, option.find(' ')), "tetrahedron.obj", "mesh"});
    writeNrrd("two.nrrd", {2, 2, 2}, std::vector<float>(8, 1.0F));
    expectFailure("voxelize two.nrrd --resolution 1 -o t.voxels", 2, {"two.nrrd", "--resolution"});
    // nothing is there to be seen, which is no failure
    const Json none = json("voxelize proc:sphere --isovalue 99 --resolution 8 -o none.voxels");
    EXPECT_EQ(none["model"]["voxels"], 0);
    EXPECT_EQ(none["warnings"].size(), 1U);
    EXPECT_EQ(json("info none.voxels --check")["model"]["chunks"], 0);
}

TEST_F(ModelsCommand, tellTheFirstVoxelOnARay)
{
    write("four.obj", kTetrahedron);
    const Json made = json("voxelize four.obj --resolution 300 -o four.voxels");
    const double edge = made["model"]["voxel_edge"];
    // up from below, at both levels: a coarser voxel is met where a finer one is, or before
    const std::string ray = " --ray 0.21,0.31,-5,0,0,2";
    const Json fine = json("info four.voxels" + ray)["hit"];
    const Json coarse = json("info four.voxels --ray-level 1" + ray)["hit"];
    EXPECT_EQ(fine["face"], "-z");
    EXPECT_EQ(fine["level"], 0);
    EXPECT_EQ(coarse["level"], 1);
    // the lattice begins a quarter of a voxel before the mesh
    EXPECT_NEAR(fine["distance"].get<double>(), 5 - 0.25 * edge, 1e-6 * edge);
    EXPECT_NEAR(fine["point"][2].get<double>(), -0.25 * edge, 1e-6 * edge);
    EXPECT_LT(fine["normal"][2].get<double>(), -0.99);
    EXPECT_TRUE(fine["colour"].is_null());
    EXPECT_LE(coarse["distance"].get<double>(), fine["distance"].get<double>());
    for (std::size_t axis = 0; axis < 2; ++axis)
        EXPECT_EQ(coarse["voxel"][axis], fine["voxel"][axis].get<int>() / 2);
    EXPECT_TRUE(json("info four.voxels --ray 0,0,1e6,0,0,1")["hit"].is_null());
    EXPECT_NE(run("info four.voxels" + ray).output.find("face -z"), std::string::npos);
    // however short the direction is
    EXPECT_EQ(
        json("info four.voxels --ray 0.21,0.31,-5,0,0,2e-300")["hit"]["point"], fine["point"]);
    for (const char* wrong :
         {"four.voxels --ray 1,2,3",
          "four.voxels --ray 0,0,0,0,0,0",
          "four.voxels --ray 1,2,3,4,5,x",
          "four.voxels --ray 0,0,9,0,0,1 --ray-level 2",
          "four.voxels --ray-level 1",
          "four.obj --ray 0,0,9,0,0,1"})
        EXPECT_EQ(run(std::string("info ") + wrong).exitCode, 2) << wrong;
}

#ifdef ISOFRONT_WITH_VULKAN
TEST_F(ModelsCommand, areNotWrittenInThePlaceOfAPipe)
{
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    const auto refused = run("voxelize proc:sphere --resolution 16 -o pipe");
    EXPECT_EQ(refused.exitCode, 4);
    EXPECT_NE(refused.errors.find("pipe is there and no regular file"), std::string::npos);
    EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
}

TEST_F(ModelsCommand, tellOtherCommandsWhatTakesAModel)
{
    write("cube.ply", "ply");
    expectFailure("extract cube.ply -o a.glb", 3, {"cube.ply"});
    json("voxelize proc:sphere --resolution 16 -o ball.voxels");
    const auto stored = run("extract ball.voxels -o a.glb");
    EXPECT_EQ(stored.exitCode, 2);
    EXPECT_NE(stored.errors.find("isofront render"), std::string::npos) << stored.errors;
    for (const char* command : {"info none.voxels", "render none.voxels -o a.png"}) {
        const auto missing = run(command);
        EXPECT_EQ(missing.exitCode, 4);
        EXPECT_NE(missing.errors.find("none.voxels: there is no such file"), std::string::npos);
    }
}

TEST_F(ModelsCommand, renderAModelAtTheDetailThatIsAskedFor)
{
    write("t.obj", kTetrahedron);
    json("voxelize t.obj --resolution 300 -o t.voxels");
    json("voxelize t.obj --resolution 300 --format folder -o t");
    json("voxelize proc:sphere --isovalue 100 --resolution 20 -o empty.voxels");
    json("voxelize proc:sphere --resolution 16 -o ball.voxels");
    expectFailure("render empty.voxels -o empty.png", 3, {"empty.voxels", "no voxels"});
    const Json fine = json("render t.voxels --size 320x240 -o fine.png");
    const Json coarse = json("render t.voxels --size 320x240 --voxel-pixels 4 -o coarse.png");
    EXPECT_EQ(fine["voxels_splatted"], fine["voxels_drawn"]);
    EXPECT_GT(fine["voxels_drawn"], 3 * coarse["voxels_drawn"].get<std::uint64_t>());
    EXPECT_GT(coarse["voxels_drawn"], 100);
    EXPECT_EQ(fine["chunks_damaged"], 0);
    EXPECT_EQ(fine["effective_voxel_pixels"], 1.0);
    // The other kind of store gives the same picture.
    json("render t --size 320x240 -o other.png");
    EXPECT_EQ(contentsOf(folder / "fine.png"), contentsOf(folder / "other.png"));
    // A chunk that is gone is named by the model that is drawn, and one above it stands in.
    for (const auto& file : fs::directory_iterator(folder / "t" / "0"))
        fs::remove(file.path());
    const Outcome stoodIn = run("render t --size 320x240 --json -o other.png");
    EXPECT_EQ(stoodIn.exitCode, 0);
    EXPECT_NE(stoodIn.errors.find("t: chunk 0, 0, 0 of level 0 is missing"), std::string::npos)
        << stoodIn.errors;
    const Json coarser = Json::parse(stoodIn.output);
    EXPECT_GT(coarser["chunks_damaged"], 0);
    EXPECT_GT(coarser["voxels_drawn"], 1000);
    EXPECT_LT(2 * coarser["voxels_drawn"].get<std::uint64_t>(), fine["voxels_drawn"]);
    const Json cubes = json("render t.voxels --size 320x240 --way cubes --up 0,0,1 -o cubes.png");
    EXPECT_EQ(cubes["voxels_splatted"], 0);
    for (const std::string option :
         {"--isovalue 1",
          "--lattice 4",
          "--pixel-error 3",
          "--closed",
          "--quality best",
          "--max-cells 100000"})
        expectFailure(
            "render t.voxels -o a.png " + option,
            2,
            {option.substr(0, option.find(' ')), "voxel model"});
    for (const std::string option : {"--up 0,1,0", "--way cubes", "--cache-mib 9"})
        expectFailure(
            "render proc:sphere -o a.png " + option,
            2,
            {option.substr(0, option.find(' ')), "no voxel model"});
    for (const std::string option : {"--source a.obj", "--no-source"})
        for (const std::string command : {"render proc:sphere -o a.png ", "fly --frames 1 "})
            expectFailure(
                command + option, 2, {option.substr(0, option.find(' ')), "no voxel model"});
    expectFailure(
        "render ball.voxels --source t.obj -o a.png", 2, {"--source t.obj", "ball.voxels"});
    for (const char* wrong : {"--way points", "--voxel-pixels 0", "--cache-mib 0", "--up 0,0,0"})
        EXPECT_EQ(run(std::string("render t.voxels -o a.png ") + wrong).exitCode, 2) << wrong;
}

TEST_F(ModelsCommand, showTheMeshThatAModelWasMadeFromCloseUp)
{
    fs::create_directories(folder / "meshes");
    write("meshes/t.obj", kTetrahedron);
    json("voxelize meshes/t.obj --resolution 40 -o t.voxels");
    EXPECT_EQ(json("info t.voxels")["model"]["source"]["path"], "meshes/t.obj");
    const std::string picture = "render t.voxels --size 160x120 -o ";
    const Json near = json(picture + "near.png");
    EXPECT_GT(near["source"]["triangles_drawn"], 4) << "cut along cells";
    EXPECT_GT(near["source"]["bytes"], 100);
    EXPECT_EQ(near["source"]["error"], nullptr);
    EXPECT_EQ(near["source"]["is_full"], false);
    const Json without = json(picture + "voxels.png --no-source");
    EXPECT_EQ(without["source"], nullptr);
    EXPECT_GT(without["voxels_drawn"], 100);
    EXPECT_NE(contentsOf(folder / "near.png"), contentsOf(folder / "voxels.png"));
    const Json flown = json("fly t.voxels --frames 2 --size 160x120 --out f");
    EXPECT_EQ(flown["source"]["file"], near["source"]["file"]);
    EXPECT_EQ(flown["source"]["error"], nullptr);
    const Json record = Json::parse(contentsOf(folder / "f" / "report.json"));
    std::uint64_t most = 0;
    std::uint64_t mostOnHost = 0;
    for (const Json& frame : record["frames"]) {
        EXPECT_GT(frame["source_bytes"], 100);
        EXPECT_EQ(frame["mesh_bytes"], frame["source_bytes"]);
        most = std::max<std::uint64_t>(most, frame["source_bytes"]);
        mostOnHost = std::max<std::uint64_t>(mostOnHost, frame["source_host_bytes"]);
    }
    EXPECT_EQ(flown["source"]["bytes_max"], most);
    EXPECT_EQ(flown["source"]["host_bytes_max"], mostOnHost);
    EXPECT_EQ(record["summary"]["source_bytes_max"], most);
    EXPECT_EQ(record["summary"]["source_host_bytes_max"], mostOnHost);
    EXPECT_GT(mostOnHost, 0);
    const Json bare = json("fly t.voxels --frames 1 --size 160x120 --no-source --out bare");
    EXPECT_EQ(bare["source"], nullptr);
    // voxels that are fine enough need no source
    EXPECT_EQ(json(picture + "far.png --voxel-pixels 1000")["source"]["triangles_drawn"], 0);

    fs::rename(folder / "meshes", folder / "moved");
    const Outcome lost = run(picture + "lost.png --json");
    EXPECT_EQ(lost.exitCode, 0) << lost.errors;
    EXPECT_NE(lost.errors.find("t.obj"), std::string::npos) << lost.errors;
    EXPECT_NE(lost.errors.find("--source"), std::string::npos) << lost.errors;
    EXPECT_EQ(Json::parse(lost.output)["source"]["triangles_drawn"], 0);
    EXPECT_EQ(contentsOf(folder / "lost.png"), contentsOf(folder / "voxels.png"));
    json(picture + "moved.png --source moved/t.obj");
    EXPECT_EQ(contentsOf(folder / "moved.png"), contentsOf(folder / "near.png"));

    write("moved/t.obj", std::string(kTetrahedron) + "# another\n");
    // one that was named is not left out in silence
    expectFailure(
        "render t.voxels --source moved/t.obj -o a.png", 3, {"--source moved/t.obj", "changed"});
    expectFailure("render t.voxels --source nope.obj -o a.png", 4, {"--source nope.obj"});
    fs::create_directory(folder / "meshes");
    fs::copy_file(folder / "moved/t.obj", folder / "meshes/t.obj");
    const Outcome changed = run(picture + "changed.png --json");
    EXPECT_EQ(changed.exitCode, 0) << changed.errors;
    EXPECT_NE(changed.errors.find("changed"), std::string::npos) << changed.errors;
    EXPECT_EQ(contentsOf(folder / "changed.png"), contentsOf(folder / "voxels.png"));
    EXPECT_EQ(run(picture + "a.png --no-source --source moved/t.obj").exitCode, 2);

    // one that is larger than it may be
    write("big.obj", std::string(2 << 20, '\n') + kTetrahedron);
    json("voxelize big.obj --resolution 40 -o big.voxels");
    const std::string large = "render big.voxels --size 160x120 --json -o big.png";
    EXPECT_GT(Json::parse(run(large).output)["source"]["triangles_drawn"], 4);
    const Outcome limited = run(large + " --memory-limit 0.001");
    EXPECT_EQ(limited.exitCode, 0) << limited.errors;
    EXPECT_NE(limited.errors.find("--memory-limit"), std::string::npos) << limited.errors;
    EXPECT_EQ(Json::parse(limited.output)["source"]["triangles_drawn"], 0);
}
#endif

} // namespace
} // namespace isofront::cli

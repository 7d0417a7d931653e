#include "cli/CommandFixture.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace isofront::cli {
namespace {

using Json = nlohmann::json;

std::string shipped(const std::string& name)
{
    return "'" ISOFRONT_DATA "/volumes/" + name + "'";
}

/// Vertices and triangles of a binary PLY as this program writes it, read apart from its writer.
struct PlyMesh {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    explicit PlyMesh(const fs::path& path)
    {
        const std::string text = contentsOf(path);
        const std::size_t body = text.find("end_header\n") + 11;
        std::istringstream header(text.substr(0, body));
        std::size_t vertexCount = 0;
        std::size_t faceCount = 0;
        std::size_t vertexBytes = 0;
        std::string element;
        for (std::string word; header >> word;) {
            if (word == "element") {
                std::size_t count = 0;
                header >> element >> count;
                (element == "vertex" ? vertexCount : faceCount) = count;
            } else if (word == "property" && element == "vertex") {
                header >> word;
                vertexBytes += word == "double" ? 8U : 4U;
            }
        }
        const char* at = text.data() + body;
        for (std::size_t i = 0; i < vertexCount; ++i, at += vertexBytes) {
            vertices.emplace_back();
            std::memcpy(vertices.back().data(), at, 24);
        }
        for (std::size_t i = 0; i < faceCount; ++i, at += 13) {
            triangles.emplace_back();
            std::memcpy(triangles.back().data(), at + 1, 12);
        }
        EXPECT_EQ(at, text.data() + text.size());
    }

    /// Edges that belong to one triangle only; by index or, welded, by position.
    [[nodiscard]] std::vector<std::array<std::uint32_t, 2>> openEdges(bool welded) const
    {
        std::vector<std::uint32_t> name(vertices.size());
        std::map<std::array<double, 3>, std::uint32_t> at;
        for (std::uint32_t i = 0; i < vertices.size(); ++i)
            name[i] = welded ? at.try_emplace(vertices[i], i).first->second : i;
        std::map<std::array<std::uint32_t, 2>, int> uses;
        for (const auto& t : triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = name[t[k]];
                const std::uint32_t b = name[t[(k + 1) % 3]];
                ++uses[{std::min(a, b), std::max(a, b)}];
            }
        std::vector<std::array<std::uint32_t, 2>> open;
        for (const auto& [edge, count] : uses) {
            EXPECT_LE(count, 2);
            if (count == 1)
                open.push_back(edge);
        }
        return open;
    }
};

TEST_F(Command, teachesByHelp)
{
    for (const std::string command : {"", "extract ", "info ", "tiles "}) {
        const Outcome outcome = run(command + "--help");
        EXPECT_EQ(outcome.exitCode, 0);
        EXPECT_NE(outcome.output.find("SOURCE"), std::string::npos);
        EXPECT_TRUE(outcome.errors.empty());
    }
    EXPECT_NE(run("--version").output.find("isofront 0."), std::string::npos);
    expectFailure("", 2, {"--help"});
    expectFailure("explode proc:sphere", 2, {"explode", "extract", "info"});
    expectFailure("extract proc:sphere", 2, {"--output"});
}

TEST_F(Command, writesTilesThatItsObjectDescribes)
{
    const Outcome outcome = run("tiles proc:torus --levels 2 --tile-steps 16 -o tiles --json -q");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
    EXPECT_TRUE(outcome.errors.empty()) << outcome.errors;
    const Json json = Json::parse(outcome.output);
    ASSERT_EQ(json["levels"].size(), 2U);
    EXPECT_EQ(json["levels"][0]["step"], 2 * json["levels"][1]["step"].get<double>());
    EXPECT_GT(json["levels"][0]["geometric_error"], 0.0);
    EXPECT_EQ(json["levels"][1]["geometric_error"], 0.0);
    std::uintmax_t bytes = 0;
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "tiles"))
        if (entry.is_regular_file()) {
            bytes += entry.file_size();
            ++files;
        }
    EXPECT_EQ(json["files"], files);
    EXPECT_EQ(json["bytes"], bytes);
    const Json tileset = Json::parse(contentsOf(folder / "tiles/tileset.json"));
    EXPECT_EQ(tileset["asset"]["version"], "1.1");
    EXPECT_EQ(
        Json::parse(tileset["asset"]["extras"]["settings"].get<std::string>()), json["settings"]);
    // what is there isn't touched
    expectFailure("tiles proc:sphere -o tiles", 4, {"tiles", "empty"});
    EXPECT_EQ(Json::parse(contentsOf(folder / "tiles/tileset.json")), tileset);
}

TEST_F(Command, refusesTilesThatCannotBe)
{
    expectFailure("tiles proc:torus", 2, {"--output"});
    expectFailure("tiles proc:spere -o t", 2, {"spere", "sphere"});
    expectFailure("tiles proc:torus -o t --levels 0", 2, {"--levels"});
    expectFailure("tiles proc:torus -o t --levels 13", 2, {"--levels"});
    expectFailure("tiles proc:torus -o t --levels 2 --spacing 1", 2, {"--levels", "--spacing"});
    expectFailure("tiles proc:torus -o t --spacing native", 2, {"--spacing S", "--levels"});
    expectFailure("tiles proc:torus -o t --spacing 1x", 2, {"1x"});
    expectFailure("tiles proc:torus -o t --spacing 1e-300", 2, {"12 levels", "--spacing"});
    expectFailure("tiles proc:torus -o t --tile-steps 48", 2, {"48", "power of two"});
    expectFailure("tiles proc:torus -o t --tile-steps 8 --lattice 16", 2, {"8", "32"});
    expectFailure("tiles proc:torus -o t --lattice 5", 2, {"5", "16"});
    expectFailure("tiles proc:torus -o t --error nan", 2, {"--error"});
    expectFailure("tiles proc:torus -o t --max-triangles 1", 6, {"--max-triangles"});
    expectFailure("tiles proc:torus -o no/such/t", 4, {"no/such"});
    EXPECT_FALSE(fs::exists(folder / "t"));
}

TEST_F(Command, refusesWhatMakesNoSenseAndNamesTheRemedy)
{
    expectFailure("extract proc:spere -o a.ply", 2, {"spere", "sphere", "torus"});
    expectFailure("extract proc:sphere?radios=1 -o a.ply", 2, {"radios", "radius"});
    expectFailure("extract 'proc:terrain?preset=alpin' -o a.ply", 2, {"alpin", "canyon"});
    expectFailure("extract proc:sphere -o a.xyz", 2, {".xyz", ".glb", ".ply"});
    expectFailure("extract proc:sphere -o a.ply --lattice 5", 2, {"5", "16"});
    expectFailure("extract proc:sphere -o a.ply --level 93", 2, {"93", "92"});
    expectFailure("extract proc:sphere -o a.ply --spacing fine", 2, {"fine", "native"});
    expectFailure("extract proc:sphere -o a.ply --spacing native", 2, {"--spacing S"});
    expectFailure(
        "extract proc:sphere -o a.ply --spacing 1 --level 3", 2, {"--spacing", "--level"});
    expectFailure("extract proc:sphere -o a.ply --max-error -1", 2, {"--max-error"});
    for (const char* option :
         {"--eye 1.3,0,0 --fov nan",
          "--filter nan",
          "--memory-limit nan",
          "--isovalue nan",
          "--isovalue inf",
          "--isovalue 1e39"})
        expectFailure("extract proc:sphere -o a.ply " + std::string(option), 2, {"number"});
    expectFailure(
        "extract proc:sphere -o a.ply --eye 9,0,0 --pixel-error inf", 2, {"--pixel-error"});
    expectFailure("extract proc:sphere -o a.ply --simplify -0.1", 2, {"--simplify"});
    expectFailure("extract proc:sphere -o a.ply --smooth 101", 2, {"--smooth"});
    expectFailure("extract proc:sphere -o a.ply --vertices above", 2, {"balanced"});
    expectFailure("extract proc:sphere -o a.ply --normals five", 2, {"six"});
    expectFailure("extract '' -o a.ply", 2, {"SOURCE"});
    expectFailure("extract proc:sphere -o a.ply --eye 1,2", 2, {"--eye", "1,2"});
    for (const char* option : {"--pixel-error 1", "--fov 30", "--size 640x480"})
        expectFailure("extract proc:sphere -o a.ply " + std::string(option), 2, {"--eye"});
    write("notes.txt", "not a volume");
    expectFailure("info notes.txt", 2, {"notes.txt", ".nrrd", ".vdb"});
    EXPECT_FALSE(fs::exists(folder / "a.ply"));
}

TEST_F(Command, namesThePathThatCantBeReadOrWritten)
{
    expectFailure("info nowhere.nrrd", 4, {"nowhere.nrrd"});
    expectFailure("extract nowhere.nii -o a.ply", 4, {"nowhere.nii"});
    expectFailure("extract proc:sphere --level 3 -o no/such/folder/a.glb", 4, {"no/such/folder"});
    if (geteuid() != 0) { // root may read anything
        write("secret.nrrd", "NRRD0004\n");
        fs::permissions(folder / "secret.nrrd", fs::perms::none);
        expectFailure("info secret.nrrd", 4, {"secret.nrrd"});
    }
}

#ifdef ISOFRONT_WITH_ITK
TEST_F(Command, tellsWhatIsWrongWithDamagedVolumes)
{
    writeNrrd("good.nrrd", {8, 8, 8}, std::vector<float>(512, 1.0F));
    const std::string good = contentsOf(folder / "good.nrrd");
    write("empty.nrrd", "");
    write("magic.nrrd", "GIF89a" + good.substr(6));
    write("short.nrrd", good.substr(0, good.size() - 100));
    std::string absurd = good;
    absurd.replace(absurd.find("8 8 8"), 5, "900000000 900000000 9");
    write("absurd.nrrd", absurd);
    std::string zero = good;
    zero.replace(zero.find("8 8 8"), 5, "8 0 8");
    write("zero.nrrd", zero);
    for (const std::string name : {"empty", "magic", "short", "absurd", "zero"}) {
        expectFailure("info " + name + ".nrrd", 3, {name + ".nrrd"});
        expectFailure("extract " + name + ".nrrd -o a.ply", 3, {name + ".nrrd"});
    }
    writeNrrd("nan.nrrd", {8, 8, 8}, std::vector<float>(512, std::nanf("")));
    expectFailure("extract nan.nrrd -o a.ply", 3, {"nan.nrrd", "finite"});
    EXPECT_FALSE(fs::exists(folder / "a.ply"));
}

TEST_F(Command, goesOnWithSomeNonFiniteVoxelsAndCountsThem)
{
    std::vector<float> values;
    for (int z = 0; z < 16; ++z)
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x)
                values.push_back(static_cast<float>(6 - std::hypot(x - 7.5, y - 7.5, z - 7.5)));
    values[16 * 16 * 8 + 16 * 8 + 12] = std::nanf("");
    values[16 * 16 * 8 + 16 * 2 + 7] = HUGE_VALF;
    writeNrrd("holes.nrrd", {16, 16, 16}, values);
    const Outcome outcome = run("extract holes.nrrd --isovalue 0 --closed --json -o a.ply");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
    EXPECT_GT(Json::parse(outcome.output)["sanitised_samples"], 0);
    EXPECT_NE(outcome.errors.find("not finite"), std::string::npos);
    EXPECT_TRUE(PlyMesh(folder / "a.ply").openEdges(false).empty());
    EXPECT_EQ(Json::parse(run("info holes.nrrd --json").output)["volume"]["non_finite_voxels"], 2);
}

TEST_F(Command, refusesWorkOverItsMemoryLimitBeforeItBegins)
{
    expectFailure(
        "extract " + shipped("silicium_104x40x40_u8.nrrd") +
            " --level 60 --memory-limit 0.01 -o a.ply",
        6,
        {"--memory-limit"});
    expectFailure(
        "extract proc:gyroid --level 40 --memory-limit 0.05 -o a.ply", 6, {"--memory-limit"});
    // the usual limit, and what is far over it: foretold rather than found out
    for (const char* source : {"proc:sphere", "proc:gyroid", "proc:terrain"})
        expectFailure(
            "extract " + std::string(source) + " --level 60 -o a.ply",
            6,
            {"would need about", "8192 MiB", "choose level"});
    EXPECT_FALSE(fs::exists(folder / "a.ply"));
}

TEST_F(Command, extractsNoMoreTrianglesThanAskedForAndTellsWhatThatCosts)
{
    for (const std::string detail :
         {"--level 9", "--max-error 0.002", "--eye 3,0.5,0.5 --pixel-error 0.2"}) {
        const Outcome outcome =
            run("extract proc:torus " + detail + " --max-triangles 1500 --json -o a.ply");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
        const Json json = Json::parse(outcome.output);
        EXPECT_LE(json["triangles"], 1500) << detail;
        EXPECT_GT(json["triangles"], 300) << detail;
        EXPECT_EQ(PlyMesh(folder / "a.ply").triangles.size(), json["triangles"]);
        EXPECT_GT(json["coarser"], 1.0) << detail;
        EXPECT_EQ(json["settings"]["max_triangles"], 1500);
        EXPECT_NE(outcome.errors.find("note: at most 1,500 triangles: "), std::string::npos)
            << outcome.errors;
    }
    const Json whole = Json::parse(
        run("extract proc:torus --level 6 --max-triangles 1000000 --json -o a.ply").output);
    EXPECT_EQ(whole["coarser"], 1.0);
    EXPECT_EQ(whole["settings"]["level"], 6);
    expectFailure("extract proc:torus --max-triangles 1 -o b.ply", 6, {"--max-triangles"});
    expectFailure("extract proc:torus --max-triangles 0 -o b.ply", 2, {"--max-triangles"});
    EXPECT_FALSE(fs::exists(folder / "b.ply"));
}

TEST_F(Command, closesAVolumeThatReachesItsBorderOnRequestAndElseEndsThere)
{
    for (const std::string name : {"nucleon_41x41x41_u8.nrrd"}) // does not vanish at its border
        for (const bool closed : {false, true}) {
            const Outcome outcome =
                run("extract " + shipped(name) + (closed ? " --closed" : "") +
                    " --isovalue 1 --json -o a.ply");
            ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
            const Json json = Json::parse(outcome.output);
            const PlyMesh mesh(folder / "a.ply");
            EXPECT_EQ(json["triangles"], mesh.triangles.size());
            EXPECT_EQ(json["vertices"], mesh.vertices.size());
            EXPECT_GT(mesh.triangles.size(), 1000U);
            EXPECT_EQ(json["settings"]["axis_step"], 1.0) << "native spacing";
            const auto open = mesh.openEdges(false);
            if (closed) {
                EXPECT_TRUE(open.empty());
                EXPECT_TRUE(mesh.openEdges(true).empty());
                continue;
            }
            const Json info =
                Json::parse(run("info " + shipped(name) + " --json").output)["world_box"];
            ASSERT_GT(open.size(), 100U);
            for (const auto& edge : open)
                for (const std::uint32_t v : edge) {
                    double toBorder = HUGE_VAL;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        for (const char* side : {"min", "max"})
                            toBorder = std::min(
                                toBorder,
                                std::abs(mesh.vertices[v][axis] - double(info[side][axis])));
                    EXPECT_LE(toBorder, 1.0);
                }
        }
}

/// Real volumes: one anisotropic, one a level set, where a folder with them is named.
TEST_F(Command, tellsWhatAnElevationRasterHoldsAndExtractsIt)
{
    const std::string raster = "'" ISOFRONT_DATA "/elevation/mount-washington.tif'";
    const Json info = Json::parse(run("info " + raster + " --json").output);
    const Json& elevation = info.at("elevation");
    EXPECT_EQ(elevation.at("format"), "GeoTIFF");
    EXPECT_EQ(elevation.at("posts"), Json({1025, 1025}));
    EXPECT_EQ(elevation.at("sample_type"), "int16");
    EXPECT_EQ(elevation.at("height_range"), Json({145.0, 1908.0}));
    EXPECT_EQ(elevation.at("voids_filled"), 0);
    EXPECT_NEAR(elevation.at("centre").at("latitude").get<double>(), 44.5, 1e-9);
    EXPECT_NEAR(elevation.at("spacing")[0].get<double>(), 66.166, 0.001);
    for (const char* key : {"centre", "summit", "orientation", "memory_bytes", "notes"})
        EXPECT_TRUE(elevation.contains(key)) << key;

    const Json open =
        Json::parse(run("extract " + raster + " --spacing 300 -o open.ply --json").output);
    EXPECT_GT(open.at("triangles"), 100'000);
    EXPECT_EQ(open.at("sanitised_samples"), 0);
    EXPECT_LT(open.at("bounds").at("max")[2].get<double>(), 1908 + 5);
    const Json closed = Json::parse(
        run("extract " + raster + " --spacing 300 --closed -o block.ply --json").output);
    // Open, it is the ground without the block's floor; of walls no more than a lattice step.
    const auto floorOf = [](const Json& json) {
        return json.at("bounds").at("min")[2].get<double>();
    };
    EXPECT_LT(floorOf(closed), 145 - 400);
    EXPECT_GT(floorOf(open), 145 - 350);

    expectFailure("info " + raster + " --pixel-size 0,5", 2, {"--pixel-size"});
    expectFailure("info " + raster + " --height-scale 0", 2, {"--height-scale"});
    write("flat.png", "no picture");
    expectFailure("info flat.png --pixel-size 30", 3, {"flat.png", "PNG"});
    expectFailure("info none.hgt", 4, {"none.hgt", "no such file"});
}

TEST_F(Command, closesRealVolumes)
{
    const char* data = std::getenv("ISOFRONT_TEST_DATA");
    if (data == nullptr)
        GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder with volumes";
    const std::array<std::array<std::string, 2>, 3> cases{
        {{"cranium_ct_256x256x108_i16.nrrd", "--isovalue 300"},
         {"skull_64x64x64_f32.nrrd", "--isovalue 2.9"},
         {"armadillo_levelset_200.vdb", ""}}};
    for (const auto& [name, options] : cases) {
        const Outcome outcome =
            run("extract '" + std::string(data) + "/volumes/" + name + "' " + options +
                " --closed --json -o a.ply");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
        const PlyMesh mesh(folder / "a.ply");
        EXPECT_GT(mesh.triangles.size(), 10000U) << name;
        EXPECT_TRUE(mesh.openEdges(false).empty()) << name;
        EXPECT_TRUE(mesh.openEdges(true).empty()) << name;
    }
}
#endif

TEST_F(Command, printsOneJsonObjectAndNothingElse)
{
    const Outcome outcome = run("extract proc:torus --level 6 --json -o a.glb");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.errors;
    const Json json = Json::parse(outcome.output);
    for (const char* key :
         {"triangles",
          "vertices",
          "cells",
          "cells_skipped",
          "samples",
          "sanitised_samples",
          "bounds",
          "seconds",
          "peak_rss_bytes",
          "threads",
          "settings"})
        EXPECT_TRUE(json.contains(key)) << key;
    for (const char* key :
         {"total", "load", "sample", "contour", "smooth", "simplify", "normals", "write"})
        EXPECT_TRUE(json["seconds"].contains(key)) << key;
    EXPECT_GT(json["cells_skipped"], 0);
    const Json sources = Json::parse(run("info proc: --json").output)["procedural"];
    EXPECT_GE(sources.size(), 6U);
}

TEST_F(Command, writesTheSameBytesOnAnyNumberOfThreads)
{
    for (const std::string options :
         {"",
          "--quality plain",
          "--quality best",
          "--smooth 2 --reproject --simplify 0.1 --align --vertices balanced --normals four"}) {
        for (const int threads : {1, 2, 8})
            ASSERT_EQ(
                run("extract proc:gyroid --level 7 " + options + " --threads " +
                    std::to_string(threads) + " -o " + std::to_string(threads) + ".ply")
                    .exitCode,
                0);
        EXPECT_EQ(contentsOf(folder / "1.ply"), contentsOf(folder / "2.ply"));
        EXPECT_EQ(contentsOf(folder / "1.ply"), contentsOf(folder / "8.ply"));
    }
}

TEST_F(Command, makesFewerTrianglesAndStillAClosedMesh)
{
    const auto triangles = [&](const std::string& options) {
        const Outcome outcome = run("extract proc:torus --level 9 --json -o a.ply " + options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        const PlyMesh mesh(folder / "a.ply");
        EXPECT_TRUE(mesh.openEdges(false).empty());
        EXPECT_TRUE(mesh.openEdges(true).empty());
        const Json json = Json::parse(outcome.output);
        EXPECT_EQ(json["settings"]["simplify"] > 0, json["seconds"]["simplify"] > 0);
        const Json& settings = json["settings"];
        EXPECT_EQ(
            settings["smooth"] > 0 || settings["align"] == true, json["seconds"]["smooth"] > 0);
        return mesh.triangles.size();
    };
    const std::size_t all = triangles("");
    EXPECT_EQ(triangles("--smooth 2"), all);
    EXPECT_EQ(triangles("--quality plain"), all);
    EXPECT_LT(triangles("--simplify 0.1"), all / 2);
}

TEST_F(Command, takesAWordForTheQualityOfTrianglesAndOptionsBeforeIt)
{
    const auto settings = [&](const std::string& options) {
        const Outcome outcome = run("extract proc:torus --level 6 --json -o a.ply " + options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        return Json::parse(outcome.output)["settings"];
    };
    const auto bytes = [&](const std::string& options) {
        EXPECT_EQ(run("extract proc:torus --level 6 -o a.stl " + options).exitCode, 0);
        return contentsOf(folder / "a.stl");
    };
    EXPECT_EQ(settings("")["quality"], "good") << "an export is worth some time";
    EXPECT_EQ(settings("")["align"], true);
    EXPECT_EQ(settings("")["vertices"], "surface");
    EXPECT_EQ(settings("--no-align")["align"], false);
    EXPECT_EQ(settings("--quality plain --align")["align"], true);
    const Json best = settings("--quality best --no-reproject --simplify 0");
    EXPECT_EQ(best["quality"], "best");
    EXPECT_EQ(best["smooth"], 1);
    EXPECT_EQ(best["reproject"], false);
    EXPECT_EQ(best["simplify"], 0);
    EXPECT_EQ(best["vertices"], "balanced");
    const std::string good = bytes("");
    const std::string plain = bytes("--quality plain");
    EXPECT_NE(good, plain);
    EXPECT_EQ(bytes("--no-align --no-reproject --smooth 0"), plain);
    EXPECT_EQ(bytes("--quality plain --smooth 1 --reproject --align"), good);
    EXPECT_EQ(
        bytes("--quality best"),
        bytes("--smooth 1 --reproject --simplify 0.02 --align --vertices balanced"));
    writeNrrd("cube.nrrd", {8, 8, 8}, std::vector<float>(512, 1.0F));
    const Json voxels =
        Json::parse(run("extract cube.nrrd --isovalue 0 --closed --json -o a.ply").output);
    EXPECT_EQ(voxels["settings"]["quality"], "plain") << "voxels aren't smooth";
    expectFailure("extract proc:torus -o a.ply --quality fine", 2, {"--quality", "best"});
}

TEST_F(Command, extractsAViewersDetailAndAnErrorBound)
{
    const Json near = Json::parse(
        run("extract proc:sphere --eye 1.3,0,0 --pixel-error 2 --size 400x300 --json -o a.ply")
            .output);
    EXPECT_GT(near["triangles"], 1000);
    EXPECT_TRUE(PlyMesh(folder / "a.ply").openEdges(false).empty());
    const Json bound =
        Json::parse(run("extract proc:sphere --max-error 0.001 --json -o b.ply").output);
    EXPECT_LE(bound["estimated_error"]["max"], 0.001);
    double worst = 0;
    for (const auto& v : PlyMesh(folder / "b.ply").vertices)
        worst = std::max(worst, std::abs(std::hypot(v[0], v[1], v[2]) - 1.0));
    EXPECT_LT(worst, 0.001);
}

TEST_F(Command, failsIfStandardOutputTakesNothing)
{
    for (const std::string arguments : {"info proc:", "info proc: --json", "info proc:sphere"}) {
        const int status =
            std::system(("'" ISOFRONT_BINARY "' " + arguments + " >/dev/full 2>/dev/null").c_str());
        EXPECT_EQ(WEXITSTATUS(status), 4) << arguments;
    }
}

TEST_F(Command, makesAValidFileOfAnEmptySurfaceAndWarns)
{
    for (const char* extension : {"ply", "glb", "obj", "stl"}) {
        const Outcome outcome =
            run(std::string("extract proc:sphere --isovalue 1e9 -o a.") + extension);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        EXPECT_NE(outcome.errors.find("warning"), std::string::npos) << extension;
        EXPECT_TRUE(fs::exists(folder / (std::string("a.") + extension)));
    }
}

TEST_F(Command, extractsAPlaceOfInterestFinerThanTheViewerNeedsIt)
{
    const auto trianglesNear = [&](const std::string& options) {
        const Outcome outcome =
            run("extract proc:sphere --eye 6,0,0 --pixel-error 4 --size 400x300 --json -o a.ply " +
                options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        const PlyMesh mesh(folder / "a.ply");
        EXPECT_TRUE(mesh.openEdges(false).empty());
        std::array<std::size_t, 2> count{}; // inside the place, and on the other side of the ball
        for (const auto& t : mesh.triangles) {
            const auto& v = mesh.vertices[t[0]];
            count[0] += std::hypot(v[0], v[1], v[2] - 1) < 0.25 ? 1U : 0U;
            count[1] += v[2] < -0.5 ? 1U : 0U;
        }
        return count;
    };
    const auto without = trianglesNear("");
    const auto with = trianglesNear("--focus 0,0,1,0.25,0.002 --focus 0,1,0,0.1,0.01");
    EXPECT_GT(with[0], 10 * without[0]);
    // Conforming cells carry some of it further, but not to the other side: there, on sixteen times
    // the area, are fewer triangles than in the place.
    EXPECT_LT(with[1], with[0]);
    EXPECT_GT(trianglesNear("--world-error 0.004")[1], 10 * without[1]);
}

TEST_F(Command, warnsWhereTheFinestLevelDoesNotReachTheErrorAskedFor)
{
    const std::string extract =
        "extract " + shipped("nucleon_41x41x41_u8.nrrd") + " --isovalue 140 --json -o a.ply ";
    const Outcome tooFine = run(extract + "--max-error 1e-9");
    ASSERT_EQ(tooFine.exitCode, 0) << tooFine.errors;
    const Json report = Json::parse(tooFine.output);
    EXPECT_GT(report["estimated_error"]["max"], 1e-9);
    ASSERT_EQ(report["warnings"].size(), 1U);
    EXPECT_NE(report["warnings"][0].get<std::string>().find("--max-error"), std::string::npos);
    EXPECT_NE(tooFine.errors.find("not reached"), std::string::npos);

    const Json reached =
        Json::parse(run("extract proc:sphere --max-error 0.01 --json -o a.ply").output);
    EXPECT_LE(reached["estimated_error"]["max"], 0.01);
    EXPECT_TRUE(reached["warnings"].empty());
}

TEST_F(Command, refusesPlacesAndCeilingsThatMakeNoSense)
{
    for (const char* focus :
         {"1,2,3", "0,0,0,1,0", "0,0,0,-1,1", "0,0,0,1,nan", "0,0,0,1,1,1", "0,0,0,1,1,", "a"})
        expectFailure(
            std::string("extract proc:sphere --eye 3,0,0 -o a.ply --focus ") + focus,
            2,
            {"--focus", focus, "X,Y,Z,R,E"});
    expectFailure("extract proc:sphere -o a.ply --focus 0,0,0,1,1", 2, {"--focus", "--eye"});
    expectFailure(
        "extract proc:sphere --eye 3,0,0 -o a.ply --world-error -1", 2, {"--world-error"});
#ifdef ISOFRONT_WITH_VULKAN
    for (const char* command : {"render proc:sphere -o a.png ", "fly proc:sphere --out f "}) {
        expectFailure(std::string(command) + "--focus 1,2", 2, {"--focus", "1,2"});
        expectFailure(std::string(command) + "--world-error inf", 2, {"--world-error"});
        expectFailure(std::string(command) + "--max-cells 5", 2, {"--max-cells", "6"});
        expectFailure(std::string(command) + "--max-triangles -3", 2, {"--max-triangles"});
        for (const char* size : {"12", "1QiB", "-1GiB", "nan", "lots", "2GB", "1e30"})
            expectFailure(
                std::string(command) + "--max-memory " + size, 2, {"--max-memory", size, "MiB"});
    }
    EXPECT_FALSE(fs::exists(folder / "f"));
#endif
}

#ifdef ISOFRONT_WITH_VULKAN
TEST_F(Command, saysThatThereIsNoDevice)
{
    expectFailure("render proc:sphere -o a.png --device 'no such device'", 5, {"no such device"});
    expectFailure(
        "fly --frames 1 --size 64x36 --out f",
        5,
        {"Vulkan"},
        "VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent");
    expectFailure("fly --preset alpin --frames 1", 2, {"alpin", "canyon"});
    expectFailure("fly --frames 1 --hand-over 2", 2, {"--hand-over", "--far-voxels"});
    expectFailure("render proc:sphere -o a.png --size 0x5", 2, {"0x5"});
}

TEST_F(Command, drawsAVolumeAndFliesOverATerrain)
{
    const Outcome drawn = run(
        "render " + shipped("fuel_68x68x68_u8.nrrd") + " --closed --size 160x120 --json -o a.png",
        "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.errors;
    EXPECT_GT(Json::parse(drawn.output)["triangles_drawn"], 500);
    EXPECT_EQ(contentsOf(folder / "a.png").substr(1, 3), "PNG");

    const Outcome flown =
        run("fly --frames 3 --size 160x90 --pixel-error 8 --lattice 8 --fade 0.1 --measure-popping "
            "--out flight --json",
            "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(flown.exitCode, 0) << flown.errors;
    EXPECT_EQ(Json::parse(flown.output)["frames"], 3);
    for (const char* name : {"report.json", "report.html", "contact-sheet.png"})
        EXPECT_TRUE(fs::exists(folder / "flight" / name)) << name;
    const Json report = Json::parse(contentsOf(folder / "flight" / "report.json"));
    EXPECT_EQ(report["frames"].size(), 3U);
    EXPECT_GT(report["frames"][0]["triangles"], 100);
    EXPECT_TRUE(report["frames"][2]["largest_pop"].is_number());
    EXPECT_EQ(report["settings"]["others"]["fade_seconds"], "0.1");
}

TEST_F(Command, keepsItsCeilingsAndTellsWhatTheyCost)
{
    const auto drawn = [&](const std::string& options) {
        const Outcome outcome =
            run("render proc:gyroid --size 160x120 --pixel-error 0.25 --json -o a.png " + options,
                "ISOFRONT_DEVICE=cpu");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.errors;
        return Json::parse(outcome.output);
    };
    const Json free = drawn("");
    EXPECT_EQ(free["effective_pixel_error"], 0.25);
    EXPECT_TRUE(free["settings"]["max_cells"].is_null());
    for (const auto& [option, setting, key] :
         {std::array{"--max-cells", "max_cells", "cells"},
          std::array{"--max-triangles", "max_triangles", "triangles"},
          std::array{"--max-memory", "max_memory_bytes", "surface_bytes"}}) {
        const std::size_t most = free[key].get<std::size_t>() / 3;
        const Json bounded = drawn(std::string(option) + " " + std::to_string(most));
        EXPECT_LE(bounded[key], most) << option;
        EXPECT_GT(bounded["triangles"], 100) << option;
        EXPECT_GT(bounded["effective_pixel_error"], 0.25) << option;
        EXPECT_EQ(bounded["settings"][setting], most);
    }
    const Json focused = drawn("--focus 0,0,0,0.2,0.001");
    EXPECT_GT(focused["triangles"], free["triangles"]);
    EXPECT_EQ(focused["settings"]["focus"][0]["radius"], 0.2);

    const Outcome flown =
        run("fly --frames 3 --size 160x90 --pixel-error 4 --lattice 4 --max-triangles 20000 "
            "--out flight --json",
            "ISOFRONT_DEVICE=cpu");
    ASSERT_EQ(flown.exitCode, 0) << flown.errors;
    const double effective = Json::parse(flown.output)["effective_pixel_error_max"];
    EXPECT_GT(effective, 4.0);
    const Json report = Json::parse(contentsOf(folder / "flight" / "report.json"));
    EXPECT_EQ(report["settings"]["others"]["max_triangles"], "20000");
    EXPECT_EQ(report["summary"]["effective_pixel_error_max"], effective);
    for (const Json& frame : report["frames"]) {
        EXPECT_LE(frame["triangles"], 20000);
        EXPECT_LE(frame["effective_pixel_error"], effective);
    }
}
#endif

} // namespace
} // namespace isofront::cli

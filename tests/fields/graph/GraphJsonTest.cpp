#include "../FieldChecks.h"
#include "PresetTexts.h"
#include "support/TemporaryFolder.h"

#include <isofront/fields/GraphJson.h>
#include <isofront/fields/Shapes.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace isofront::fields::graph {
namespace {

using namespace test;

/// A preset around some nodes, of which the result is 'a'.
std::string around(const std::string& nodes)
{
    return R"({"isofrontGraph": 1, "name": "n", "description": "d",
               "box": {"centre": [1, 2, 3], "edge": 10}, "nodes": {)" +
           nodes + R"(}, "result": "a"})";
}

std::string errorOf(const std::string& text)
{
    const core::Result<Preset> preset = parsePreset(text, "test.json");
    EXPECT_FALSE(preset.has_value()) << text;
    if (preset)
        return {};
    EXPECT_EQ(preset.error().code, core::ErrorCode::badData);
    EXPECT_EQ(preset.error().message.find("test.json: "), 0U) << preset.error().message;
    EXPECT_EQ(preset.error().message.find('\n'), std::string::npos) << preset.error().message;
    return preset.error().message;
}

// ---- What is written in JSON is what is written in C++ ------------------------------------------

struct Same {
    const char* name;
    const char* json;
    Node node;
};
void PrintTo(const Same& same, std::ostream* stream)
{
    *stream << same.name;
}

const OctaveSettings kHills{
    .wavelength = 9, .octaves = 3, .amplitude = 2, .plane = true, .seed = 5};

const OctaveSettings kRidges{
    .kind = NoiseKind::simplex,
    .fractal = FractalKind::ridged,
    .wavelength = 9,
    .octaves = 3,
    .amplitude = 2,
    .carry = 3,
    .plane = true,
    .seed = 5};

std::vector<Same> examples()
{
    const Node x = position(Axis::x);
    const Node z = position(Axis::z);
    const Node hills = noise(kHills);
    const OctaveSettings layers[2] = {
        {.wavelength = 4, .octaves = 2, .seed = 8},
        {.wavelength = 7, .octaves = 1, .amplitude = 0.5, .stretch = 3, .seed = 9}};
    const std::vector<CurvePoint> points{{-2, 1}, {0, 0}, {3, 4}};
    return {
        {"position", R"("a": {"type": "position", "axis": "x"})", x},
        {"distance", R"("a": {"type": "distance", "from": [1, -2, 0.5]})", distance(1, -2, 0.5)},
        {"fractal",
         R"("a": {"type": "noise", "wavelength": 9, "octaves": 3, "amplitude": 2, "plane": true, "seed": 5})",
         hills},
        {"fractalWithAllItHas",
         R"("a": {"type": "noise", "wavelength": 6, "octaves": 4, "amplitude": 1.5, "lacunarity": 1.9,
                  "gain": 0.6, "stretch": 2, "filtered": false, "seed": 6})",
         noise(
             {.wavelength = 6,
              .octaves = 4,
              .amplitude = 1.5,
              .lacunarity = 1.9,
              .gain = 0.6,
              .stretch = 2,
              .filtered = false,
              .seed = 6})},
        {"ridges",
         R"("a": {"type": "noise", "kind": "simplex", "fractal": "ridged", "wavelength": 9, "octaves": 3, "amplitude": 2, "plane": true,
                  "carry": 3, "seed": 5})",
         noise(kRidges)},
        {"filterWeight",
         R"("a": {"type": "multiply", "inputs": [{"type": "filterWeight", "wavelength": 3}, 2]})",
         filterWeight(3) * 2.0},
        {"addOfMany",
         R"("a": {"type": "add", "inputs": ["x", {"type": "position", "axis": "z"}, 3, "x"]},
            "x": {"type": "position", "axis": "x"})",
         x + z + 3.0 + x},
        {"subtract",
         R"("a": {"type": "subtract", "inputs": [1, {"type": "position", "axis": "x"}]})",
         1.0 - x},
        {"absSquareSqrt",
         R"("a": {"type": "sqrt", "input": {"type": "abs", "input": {"type": "square",
                  "input": {"type": "position", "axis": "x"}}}})",
         sqrt(abs(square(x)))},
        {"minMax",
         R"("a": {"type": "min", "inputs": [{"type": "max", "inputs": ["x", 1]}, "z"]},
            "x": {"type": "position", "axis": "x"}, "z": {"type": "position", "axis": "z"})",
         min(max(x, 1.0), z)},
        {"smoothMinMax",
         R"("a": {"type": "smoothMin", "width": 2, "inputs": [
                  {"type": "smoothMax", "width": 3, "inputs": ["x", 1]}, "z"]},
            "x": {"type": "position", "axis": "x"}, "z": {"type": "position", "axis": "z"})",
         smoothMin(smoothMax(x, 1.0, 3), z, 2)},
        {"clampAndStep",
         R"("a": {"type": "smoothStep", "begin": -1, "end": 2,
                  "input": {"type": "clamp", "low": -3, "high": 1.5, "input": {"type": "position", "axis": "x"}}})",
         smoothStep(clamp(x, -3, 1.5), -1, 2)},
        {"mix",
         R"("a": {"type": "mix", "from": "x", "to": 7, "by": {"type": "position", "axis": "z"}},
            "x": {"type": "position", "axis": "x"})",
         mix(x, 7.0, z)},
        {"curve",
         R"("a": {"type": "curve", "points": [[-2, 1], [0, 0], [3, 4]],
                  "input": {"type": "position", "axis": "x"}})",
         curve(x, points)},
        {"warp",
         R"("a": {"type": "warp", "input": "h", "y": "h", "z": 2, "stretch": 1.5},
            "h": {"type": "noise", "wavelength": 9, "octaves": 3, "amplitude": 2, "plane": true, "seed": 5})",
         warp(hills, 0.0, hills, 2.0, 1.5)},
        {"placed",
         R"("a": {"type": "placed", "at": [3, 2, 1], "scale": 2, "input":
            {"type": "noise", "wavelength": 9, "octaves": 3, "amplitude": 2, "plane": true, "seed": 5}})",
         placed(hills, 3, 2, 1, 2)},
        {"detail",
         R"("a": {"type": "detail", "input": {"type": "position", "axis": "x"}, "strength": 0.5, "reserve": 2,
                  "layers": [{"wavelength": 4, "octaves": 2, "seed": 8},
                             {"wavelength": 7, "amplitude": 0.5, "stretch": 3, "seed": 9}]})",
         detail(x, layers, 0.5, 2)},
        {"tunnels",
         R"("a": {"type": "tunnels", "input": {"type": "position", "axis": "x"}, "wavelength": 9,
                  "radius": 2, "radiusVariation": 0.5, "depth": 6, "stretch": 2, "rounding": 1, "seed": 4})",
         tunnels(
             x,
             {.wavelength = 9,
              .radius = 2,
              .radiusVariation = 0.5,
              .depth = 6,
              .stretch = 2,
              .rounding = 1,
              .seed = 4})},
    };
}

class GraphJsonNodes : public testing::TestWithParam<Same> {};
INSTANTIATE_TEST_SUITE_P(
    All, GraphJsonNodes, testing::ValuesIn(examples()), [](const auto& instance) {
        return std::string(instance.param.name);
    });

TEST_P(GraphJsonNodes, areThoseOfTheProgrammingInterface)
{
    const core::Result<Preset> preset = parsePreset(around(GetParam().json), "test.json");
    ASSERT_TRUE(preset.has_value()) << preset.error().message;
    const std::shared_ptr<const Field> read = graphField(preset->surface, {.seed = 3});
    const std::shared_ptr<const Field> written = graphField(GetParam().node, {.seed = 3});
    Random random(91);
    const Points points = randomPoints(random, {glm::dvec3(-9), glm::dvec3(9)}, 3, 1000);
    EXPECT_EQ(
        differingBits(valuesOf(*read, points.batch()), valuesOf(*written, points.batch())), 0U);
}

TEST(GraphJson, readsWhatIsAroundTheNodes)
{
    const core::Result<Preset> preset = parsePreset(
        R"({"isofrontGraph": 1, "name": "hill", "description": "A hill",
            "box": {"centre": [1, 2, 3], "edge": 10},
            "flight": {"start": [4, 5], "lookAt": [6, 7], "clearance": 8},
            "nodes": {"z": {"type": "position", "axis": "z"}}, "result": "z"})",
        "test.json");
    ASSERT_TRUE(preset.has_value()) << preset.error().message;
    EXPECT_EQ(preset->name, "hill");
    EXPECT_EQ(preset->description, "A hill");
    EXPECT_EQ(preset->box.low, glm::dvec3(-4, -3, -2));
    EXPECT_EQ(preset->box.high, glm::dvec3(6, 7, 8));
    EXPECT_EQ(preset->start, glm::dvec2(4, 5));
    EXPECT_EQ(preset->lookAt, glm::dvec2(6, 7));
    EXPECT_EQ(preset->clearance, 8);
}

TEST(GraphJson, drawsNoiseFromTheNameWhereNoSeedIsGiven)
{
    const auto values = [](const std::string& name) {
        const core::Result<Preset> preset = parsePreset(
            around(
                R"("a": {"type": "add", "inputs": [0, ")" + name + R"("]}, ")" + name +
                R"(": {"type": "noise", "wavelength": 3})"),
            "test.json");
        EXPECT_TRUE(preset.has_value());
        Random random(92);
        const Points points = randomPoints(random, preset->box, 0, 300);
        return valuesOf(*graphField(preset->surface), points.batch());
    };
    EXPECT_EQ(differingBits(values("hills"), values("hills")), 0U);
    EXPECT_GT(differingBits(values("hills"), values("rocks")), 280U);
}

// ---- Errors -------------------------------------------------------------------------------------

TEST(GraphJson, namesTheNodeAndTheKeyOfAMistake)
{
    struct Case {
        const char* nodes;
        std::vector<const char*> parts;
    };
    const std::vector<Case> cases{
        {R"("a": {"type": "noize"})", {"'a'", "'noize'", "did you mean 'noise'", "tunnels"}},
        {R"("a": {"wavelength": 3})", {"'a'", "'type'", "missing"}},
        {R"("a": {"type": "noise"})", {"'a'", "'wavelength'", "missing"}},
        {R"("a": {"type": "noise", "wavelength": 3, "octavs": 2})",
         {"'a'", "'octavs'", "did you mean 'octaves'"}},
        {R"("a": {"type": "noise", "wavelength": -3})", {"'a'", "'wavelength'", "-3"}},
        {R"("a": {"type": "noise", "wavelength": "3"})", {"'a'", "'wavelength'", "number"}},
        {R"("a": {"type": "noise", "wavelength": 3, "octaves": 2.5})", {"'octaves'", "whole"}},
        {R"("a": {"type": "noise", "wavelength": 3, "octaves": 33})", {"'octaves'", "32"}},
        {R"("a": {"type": "noise", "wavelength": 1e99})", {"'wavelength'", "1e+99"}},
        {R"("a": {"type": "noise", "wavelength": 3, "plane": 1})", {"'plane'", "true or false"}},
        {R"("a": {"type": "abs", "input": "hils"}, "hills": {"type": "noise", "wavelength": 3})",
         {"'a'", "'input'", "isn't there", "did you mean 'hills'"}},
        {R"("a": {"type": "min", "inputs": [1, {"type": "abs", "input": "b"}]})",
         {"'a.inputs.1'", "'input'", "isn't there", "'b'"}},
        {R"("a": {"type": "abs", "input": true})", {"'a'", "'input'"}},
        {R"("a": {"type": "abs"})", {"'a'", "'input'", "missing"}},
        {R"("a": {"type": "abs", "input": "a"})", {"'a'", "'a' needs 'a'"}},
        {R"("a": {"type": "abs", "input": "b"}, "b": {"type": "abs", "input": "c"},
            "c": {"type": "abs", "input": "b"})",
         {"the node 'c'", "'b' needs 'c' needs 'b'"}},
        {R"("a": {"type": "add", "inputs": [1]})", {"'a'", "'inputs'", "two"}},
        {R"("a": {"type": "add", "inputs": [1, {"type": "position", "axis": "w"}]})",
         {"'a.inputs.1'", "'axis'"}},
        {R"("a": {"type": "smoothStep", "input": 1, "begin": 2, "end": 2})", {"'a'", "'end'"}},
        {R"("a": {"type": "clamp", "input": 1, "low": 2, "high": 1})", {"'a'", "'high'"}},
        {R"("a": {"type": "curve", "input": 1, "points": [[0, 1], [0, 2]]})",
         {"'a'", "'points'", "rising"}},
        {R"("a": {"type": "curve", "input": 1, "points": []})", {"'a'", "'points'"}},
        {R"("a": {"type": "detail", "input": 1, "layers": [{"wavelength": 3, "x": 1}]})",
         {"'a.layers.0'", "'x'"}},
        {R"("a": {"type": "position", "axis": "x"}, "b": {"type": "position", "axis": "y"})",
         {"'b'", "not used"}},
        {R"("a": {"type": "position", "axis": "x"}, "a": {"type": "position", "axis": "y"})",
         {"'a'", "twice"}},
        {R"("a": 3)", {"'a'", "object"}},
        {"", {"'nodes'"}},
    };
    for (const Case& c : cases) {
        const std::string message = errorOf(around(c.nodes));
        for (const char* part : c.parts)
            EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
    }
}

TEST(GraphJson, saysWhereASlipOfTheSyntaxIsAndWhatWouldDo)
{
    struct Case {
        const char* text;
        std::vector<const char*> parts;
    };
    const std::vector<Case> cases{
        {"", {"line 1, column 1", "the text ends", "a preset, in braces"}},
        {"\n  [", {"line 2, column 4", "the text ends", "a value, or ']'"}},
        {"{\n  \"a\": 1\n  \"b\": 2}", {"line 3, column 3", "'\"b\"'", "a comma and a name"}},
        {"{\n\"a\" 1}", {"line 2, column 5", "'1'", "a colon and a value for 'a'"}},
        {"{\"a\": }", {"line 1, column 7", "'}'", "where a value for 'a'"}},
        {"{\"a\": 1,\n}", {"line 2, column 1", "remove the comma"}},
        {"{\"a\": [1, 2,]}", {"line 1, column 13", "remove the comma"}},
        {"{\"a\": [1 2]}", {"line 1, column 10", "'2'", "a comma and a value, or ']'"}},
        {"{\"a\": [1, , 2]}", {"line 1, column 11", "','", "where a value should"}},
        {"{\"a\": [1", {"line 1, column 9", "the text ends", "a comma and a value, or ']'"}},
        {"{a: 1}", {"line 1, column 2", "'a'", "a name in double quotes"}},
        {"{'a': 1}", {"line 1, column 2", "texts have double quotes"}},
        {"{\"a\": 1 // one\n}", {"line 1, column 9", "no comments"}},
        {"{\"a\": NaN}", {"line 1, column 7", "'NaN'", "numbers are written"}},
        {"{\"a\": -Infinity}", {"line 1, column 7", "numbers are written"}},
        {"{\"a\": yes}", {"line 1, column 7", "words but true and false"}},
        {"{\"a\": 01}", {"line 1, column 8", "'1'", "a comma and a name"}},
        {"{\"a\": -0.5e+3 1}", {"line 1, column 15", "'1'", "a comma and a name"}},
        {"{\"a\": 1.}", {"line 1, column 7", "'1.'", "numbers are written"}},
        {"{\"a\": [1e999]}", {"line 1, column 8", "'1e999'", "too large"}},
        {"{\"a\": \"x\ny\"}", {"line 1, column 9", "within a text"}},
        {"{\"a\": \"C:\\maps\"}", {"line 1, column 11", "two backslashes"}},
        {"{\"a\": \"\xff\"}", {"line 1, column 8", "UTF-8"}},
        {"\xef\xbb\xbf[1,]", {"column 7", "remove the comma"}},
        {"{} {}", {"line 1, column 4", "nothing more"}},
        {"{\"a\": 1,\n \"a\": 2}", {"line 2, column 2", "'a' is there twice"}},
        {"\xff\xfe", {"line 1, column 1", "a preset"}},
    };
    for (const Case& c : cases) {
        const std::string message = errorOf(c.text);
        for (const char* part : c.parts)
            EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
        // In our words, not in those of a library.
        for (const char* word : {"json.exception", "parse error", "literal", "while parsing"})
            EXPECT_EQ(message.find(word), std::string::npos) << message;
    }
}

TEST(GraphJson, showsNobodysTextAsMoreThanOneShortLine)
{
    const std::string endless(100000, 'x');
    for (const std::string& text :
         {std::string("no\\nise"), std::string("\\u0000\\u001b[31m"), endless}) {
        for (const std::string& nodes :
             {R"("a": {"type": ")" + text + R"("})",
              R"("a": {"type": "abs", "input": ")" + text + R"("})",
              R"("a": {"type": "noise", "wavelength": 1, "kind": ")" + text + R"("})",
              R"("a": {"type": "noise", "wavelength": 1, ")" + text + R"(": 2})",
              R"("a": {"type": "position", "axis": "x"}, ")" + text + R"(": {"type": "noise"})"}) {
            const std::string message = errorOf(around(nodes));
            EXPECT_LT(message.size(), 700U) << message.substr(0, 200);
            EXPECT_EQ(std::ranges::count_if(message, [](char c) { return c >= 0 && c < ' '; }), 0)
                << message;
        }
    }
    std::string text = around(R"("a": {"type": "position", "axis": "x"})");
    text.replace(text.find("\"n\""), 3, "\"two\\nlines\"");
    EXPECT_NE(errorOf(text).find("'name' must be one line"), std::string::npos);
}

TEST(GraphJson, refusesWhatIsNoPreset)
{
    for (const char* text :
         {"",
          "{",
          "[]",
          "3",
          "null",
          "\xff\xfe",
          "{}",
          R"({"isofrontGraph": 2})",
          R"({"isofrontGraph": 1})",
          R"({"isofrontGraph": 1, "name": 3})"})
        EXPECT_FALSE(errorOf(text).empty()) << text;
    const std::string box = R"("box": {"centre": [1, 2, 3], "edge": 10})";
    std::string text = around(R"("a": {"type": "position", "axis": "x"})");
    for (
        const char* wrong :
        {R"("box": {"centre": [1, 2], "edge": 10})",
         R"("box": {"centre": [1, 2, 3], "edge": 0})",
         R"("box": {"centre": [1, 2, 3]})",
         R"("box": {"centre": [1, 2e9, 3], "edge": 10})",
         R"("flight": {"start": [1, 2], "lookAt": [1, 2]}, "box": {"centre": [1, 2, 3], "edge": 10})",
         R"("flight": {"start": [1, 99], "lookAt": [1, 2]}, "box": {"centre": [1, 2, 3], "edge": 10})",
         R"("box": 3)",
         R"("bax": {"centre": [1, 2, 3], "edge": 10})"}) {
        std::string changed = text;
        changed.replace(changed.find(box), box.size(), wrong);
        EXPECT_FALSE(errorOf(changed).empty()) << wrong;
    }
    EXPECT_TRUE(parsePreset(text, "test.json").has_value());
}

TEST(GraphJson, refusesWhatWouldTakeTooMuch)
{
    // Brackets within brackets, a chain of nodes, and warps within warps: 2^40 nodes.
    EXPECT_NE(errorOf(std::string(100000, '[')).find("nested"), std::string::npos);
    std::string chain = R"("a": {"type": "abs", "input": "n0"})";
    for (int i = 0; i < 1000; ++i)
        chain += R"(, "n)" + std::to_string(i) + R"(": {"type": "abs", "input": "n)" +
                 std::to_string(i + 1) + R"("})";
    chain += R"(, "n1000": {"type": "position", "axis": "x"})";
    EXPECT_NE(errorOf(around(chain)).find("chain"), std::string::npos);
    std::string warps = R"("a": {"type": "abs", "input": "n0"})";
    for (int i = 0; i < 40; ++i) {
        const std::string next = R"("n)" + std::to_string(i + 1) + '"';
        warps += R"(, "n)" + std::to_string(i) + R"(": {"type": "add", "inputs": [)" +
                 R"({"type": "warp", "x": 1, "input": )" + next +
                 R"(}, {"type": "warp", "x": 2, "input": )" + next + "}]}";
    }
    warps += R"(, "n40": {"type": "noise", "wavelength": 3})";
    EXPECT_NE(errorOf(around(warps)).find("more than 4096 nodes"), std::string::npos);
    EXPECT_NE(errorOf(std::string(2000000, ' ')).find("1 MiB"), std::string::npos);
    // Half a million sums within one another; and as many as there may be.
    const auto sums = [](std::size_t count) {
        std::string nodes = R"("a": {"type": "add", "inputs": ["x")";
        for (std::size_t i = 0; i < count; ++i)
            nodes += ",1";
        return nodes + R"(]}, "x": {"type": "position", "axis": "x"})";
    };
    EXPECT_NE(errorOf(around(sums(500000))).find("more than 2000 nodes"), std::string::npos);
    const core::Result<Preset> most = parsePreset(around(sums(1998)), "test.json");
    ASSERT_TRUE(most.has_value()) << most.error().message;
    EXPECT_EQ(valueAt(*graphField(most->surface), 5, 0, 0), 2003.0F);
}

TEST(GraphJson, readsNoMoreOfAFileThanAPresetHas)
{
    const tests::TemporaryFolder folder;
    const std::filesystem::path path = folder.file("large.json", "{");
    std::filesystem::resize_file(path, 100'000'000);
    const core::Result<Preset> preset = readPreset(path.string());
    ASSERT_FALSE(preset.has_value());
    EXPECT_EQ(preset.error().code, core::ErrorCode::badData);
    EXPECT_NE(preset.error().message.find("1 MiB"), std::string::npos);
    const core::Result<Preset> none = readPreset(path.parent_path().string());
    ASSERT_FALSE(none.has_value());
    EXPECT_EQ(none.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(none.error().message.find("it is no file"), std::string::npos);
}

// ---- Files that a preset names ------------------------------------------------------------------

std::string withFiles(const std::string& a)
{
    return around(R"("a": {"type": "add", "inputs": [)" + a + "]}");
}

TEST(GraphJson, asksForTheFilesThatItsNodesName)
{
    std::vector<FileRequest> requests;
    const FileLoader load = [&](const FileRequest& request) {
        requests.push_back(request);
        return core::Result<std::shared_ptr<const Field>>(
            sphere(glm::dvec3(0), double(requests.size())));
    };
    const core::Result<Preset> preset = parsePreset(
        withFiles(
            R"({"type": "elevation", "file": "a.hgt"},
               {"type": "elevation", "file": "b.png", "pixelSize": 30, "heightScale": 0.1, "noData": -1},
               {"type": "volume", "file": "../scans/c.nrrd"},
               {"type": "volume", "file": "../scans/c.nrrd", "isovalue": 7},
               {"type": "volume", "file": "/d.vdb", "grid": "density"},
               {"type": "volume", "file": "a.hgt"},
               {"type": "elevation", "file": "a.hgt"})"),
        "test.json",
        {"maps", load});
    ASSERT_TRUE(preset.has_value()) << preset.error().message;
    // The last one is the first again.
    ASSERT_EQ(requests.size(), 6U);
    EXPECT_EQ(requests[0].path, "maps/a.hgt");
    EXPECT_EQ(requests[0].kind, FileRequest::Kind::elevation);
    EXPECT_FALSE(requests[0].pixelSize || requests[0].heightScale || requests[0].noData);
    EXPECT_EQ(requests[1].pixelSize, 30);
    EXPECT_EQ(requests[1].heightScale, 0.1);
    EXPECT_EQ(requests[1].noData, -1);
    EXPECT_EQ(requests[2].kind, FileRequest::Kind::volume);
    EXPECT_EQ(requests[2].path, "maps/../scans/c.nrrd");
    EXPECT_FALSE(requests[2].isovalue.has_value());
    EXPECT_EQ(requests[3].isovalue, 7);
    EXPECT_EQ(requests[4].path, "/d.vdb");
    EXPECT_EQ(requests[4].grid, "density");
    EXPECT_EQ(requests[5].kind, FileRequest::Kind::volume);
    EXPECT_EQ(requests[5].path, "maps/a.hgt");
    // Balls of radius 1 to 6, and the first once more.
    EXPECT_EQ(valueAt(*fieldOf(*preset), 0, 0, 0), 22.0F);
}

TEST(GraphJson, passesOnWhyAFileCannotBeRead)
{
    const FileLoader load = [](const FileRequest& request) {
        return core::Result<std::shared_ptr<const Field>>(
            core::failure(core::ErrorCode::inputOutput, request.path + ": there is no such file"));
    };
    const std::string text = withFiles(R"(1, {"type": "elevation", "file": "a.hgt"})");
    const core::Result<Preset> preset = parsePreset(text, "test.json", {"", load});
    ASSERT_FALSE(preset.has_value());
    EXPECT_EQ(preset.error().code, core::ErrorCode::inputOutput);
    EXPECT_EQ(
        preset.error().message, "test.json: the node 'a.inputs.1': a.hgt: there is no such file");
    EXPECT_NE(errorOf(text).find("files can't be read"), std::string::npos);
    for (const char* wrong :
         {R"(1, {"type": "elevation"})",
          R"(1, {"type": "elevation", "file": ""})",
          R"(1, {"type": "elevation", "file": "a\u0000b"})",
          R"(1, {"type": "elevation", "file": "a.hgt", "pixelSize": 0})",
          R"(1, {"type": "elevation", "file": "a.hgt", "isovalue": 1})",
          R"(1, {"type": "volume", "file": "a.vdb", "isovalue": "1"})",
          R"(1, {"type": "volume", "file": "a.vdb", "grid": 3})"})
        EXPECT_NE(errorOf(withFiles(wrong)).find("'a.inputs.1'"), std::string::npos) << wrong;
}

// ---- Materials ----------------------------------------------------------------------------------

std::string withMaterials(const std::string& list)
{
    std::string text = around(R"("a": {"type": "position", "axis": "x"})");
    return text.substr(0, text.size() - 1) + R"(, "materials": [)" + list + "]}";
}

TEST(GraphJson, givesEveryPlaceTheFirstMaterialThatIsThere)
{
    const core::Result<Preset> preset = parsePreset(
        withMaterials(
            R"({"name": "snow", "colour": "#fffefd", "where": {"type": "subtract", "inputs": ["a", 2]}},
               {"name": "grass", "colour": "#103000", "where": {"type": "position", "axis": "y"}},
               {"name": "rock", "colour": "#0A0b0C"})"),
        "test.json");
    ASSERT_TRUE(preset.has_value()) << preset.error().message;
    ASSERT_EQ(preset->materials.size(), 3U);
    EXPECT_EQ(preset->materials[1].name, "grass");
    const std::shared_ptr<const Field> field = fieldOf(*preset);
    EXPECT_TRUE(field->hasAttributes());
    const std::vector<double> x{2, 1.9, 2.1, 1, 1};
    const std::vector<double> y{-1, 0, 1, -0.1, 5};
    const std::vector<double> z(5, 0.0);
    std::vector<std::uint32_t> words(5, 99);
    field->attributes({x, y, z}, words);
    const std::uint32_t snow = 0x01fdfeffU;
    const std::uint32_t grass = 0x02003010U;
    const std::uint32_t rock = 0x030c0b0aU;
    EXPECT_EQ(words, (std::vector<std::uint32_t>{snow, grass, snow, rock, grass}));
    EXPECT_FALSE(graphField(preset->surface)->hasAttributes());
}

TEST(GraphJson, namesTheMaterialOfAMistake)
{
    struct Case {
        const char* list;
        std::vector<const char*> parts;
    };
    const std::vector<Case> cases{
        {"", {"'materials'", "1 to 255"}},
        {"3", {"'materials.0'", "object"}},
        {R"({"name": "a"})", {"'materials.0'", "'colour'"}},
        {R"({"name": "a", "colour": "red"})", {"'materials.0'", "#8a7b6c"}},
        {R"({"name": "a", "colour": "#12345g"})", {"'materials.0'", "#8a7b6c"}},
        {R"({"name": "a", "colour": "#-12345"})", {"'materials.0'", "#8a7b6c"}},
        {R"({"name": "a", "colour": "#123456"}, {"name": "b", "colour": "#123456"})",
         {"'materials.0'", "'where'", "missing"}},
        {R"({"name": "a", "colour": "#123456", "where": "a"})",
         {"'materials.0'", "remove 'where'"}},
        {R"({"name": "a", "colour": "#123456", "where": "c"}, {"name": "b", "colour": "#123456"})",
         {"'materials.0'", "'where'", "'c'"}},
        {R"({"name": "a", "colour": "#123456", "where": {"type": "abs"}}, {"name": "b", "colour": "#123456"})",
         {"'materials.0.where'", "'input'"}},
    };
    for (const Case& c : cases) {
        const std::string message = errorOf(withMaterials(c.list));
        for (const char* part : c.parts)
            EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
    }
}

// ---- Files --------------------------------------------------------------------------------------

TEST(GraphJson, saysWhichFileIsMissing)
{
    const core::Result<Preset> preset = readPreset("/no/such/graph.json");
    ASSERT_FALSE(preset.has_value());
    EXPECT_EQ(preset.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(preset.error().message.find("/no/such/graph.json"), std::string::npos);
}

TEST(GraphJson, readsAFileAsItsText)
{
    const tests::TemporaryFolder folder;
    const std::filesystem::path path =
        folder.file("graph.json", around(R"("a": {"type": "position", "axis": "x"})"));
    const core::Result<Preset> preset = readPreset(path.string());
    ASSERT_TRUE(preset.has_value()) << preset.error().message;
    EXPECT_EQ(valueAt(*graphField(preset->surface), 4.5, 0, 0), 4.5F);
}

TEST(GraphJson, neverBreaksOnDamagedPresets)
{
    // Whatever bytes are changed, removed or moved: an error, or a graph that can be evaluated.
    Random random(93);
    std::size_t read = 0;
    std::size_t refused = 0;
    for (const PresetText& original : presetTexts()) {
        for (int trial = 0; trial < 400; ++trial) {
            std::string text(original.json);
            const auto place = [&] {
                return static_cast<std::size_t>(random(0, double(text.size()) - 1));
            };
            for (int k = 0; k <= trial % 3; ++k) {
                const std::size_t at = place();
                const std::size_t length =
                    std::min<std::size_t>(text.size() - at, 1 + random.word() % 12);
                switch (random.word() % 8) {
                case 0:
                    text[at] = static_cast<char>(random.word());
                    break;
                case 1:
                    text.erase(at, length);
                    break;
                case 2:
                    text.insert(place(), text.substr(at, length));
                    break;
                case 3:
                    text[at] = "0123456789.-e{}[]\",:"[random.word() % 20];
                    break;
                default: {
                    // Another number: most of these can still be read.
                    const std::size_t digit = text.find_first_of("0123456789", at);
                    if (digit != std::string::npos)
                        text[digit] = static_cast<char>('0' + random.word() % 10);
                    break;
                }
                }
            }
            const core::Result<Preset> preset = parsePreset(text, "damaged");
            if (!preset) {
                ++refused;
                EXPECT_FALSE(preset.error().message.empty());
                continue;
            }
            ++read;
            const std::shared_ptr<const Field> field = graphField(preset->surface);
            const glm::dvec3 c = preset->box.centre();
            const float value = valueAt(*field, c.x, c.y, c.z, 1);
            const core::Interval bounds = field->bounds({c, c}, {0, 1});
            EXPECT_TRUE(!std::isfinite(value) || bounds.contains(double(value)));
        }
    }
    EXPECT_GT(read, 50U);
    EXPECT_GT(refused, 500U);
}

} // namespace
} // namespace isofront::fields::graph

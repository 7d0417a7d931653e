#include "isofront/fields/Procedural.h"

#include "PresetTexts.h"

#include <isofront/fields/Combine.h>
#include <isofront/fields/GraphJson.h>
#include <isofront/fields/Julia.h>
#include <isofront/fields/Shapes.h>
#include <isofront/fields/Terrain.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string_view>

namespace isofront::fields {

namespace {

using core::ErrorCode;

// Every parameter with its value: checked, so that the makers below can simply read them.
class Arguments {
public:
    std::map<std::string, double> numbers;
    std::map<std::string, std::string> words;
    graph::FileLoader load; ///< of the files that presets name

    [[nodiscard]] double operator[](const std::string& name) const { return numbers.at(name); }
};

struct Maker {
    ProceduralDescription description;
    std::function<core::Result<ProceduralSource>(const Arguments&)> make;
};

ProceduralParameter number(
    const char* name, const char* description, const char* defaultValue, double least, double most)
{
    return {name, description, defaultValue, least, most, false, {}, {}};
}

ProceduralParameter wholeNumber(
    const char* name, const char* description, const char* defaultValue, double least, double most)
{
    return {name, description, defaultValue, least, most, true, {}, {}};
}

core::Box cubeAround(double half)
{
    return {glm::dvec3(-half), glm::dvec3(half)};
}

/// A shape about the origin, seen from a distance that shows the whole domain.
ProceduralSource shapeSource(std::shared_ptr<const Field> field, double half)
{
    return {
        std::move(field),
        cubeAround(half),
        0.0,
        {},
        glm::dvec3(1.5, -2.6, 1.3) * half,
        glm::dvec3(0)};
}

// ---- Terrain ------------------------------------------------------------------------------------

// Wide of any surface, so that the eye of a flight never starts within rock.
double clearHeight(const Field& field, const TerrainPreset& preset, const glm::dvec2& place)
{
    // As many steps for any box: 4 m for one of 16 km.
    const double edge = preset.box.size().z;
    const auto groundAt = [&](const glm::dvec2& at) {
        return surfaceHeight(field, preset.box, at.x, at.y, edge / 4096);
    };
    double ground = groundAt(place);
    // Land that floats may hang above as well as below: fly above what is around.
    const double bottom = preset.box.low.z;
    float lowest = 0;
    field.sample({{&place.x, 1}, {&place.y, 1}, {&bottom, 1}}, {&lowest, 1});
    if (lowest < 0)
        for (const double reach : {edge / 24, edge / 12})
            for (const glm::dvec2 way :
                 {glm::dvec2(1, 0),
                  glm::dvec2(1, 1),
                  glm::dvec2(0, 1),
                  glm::dvec2(-1, 1),
                  glm::dvec2(-1, 0),
                  glm::dvec2(-1, -1),
                  glm::dvec2(0, -1),
                  glm::dvec2(1, -1)})
                ground = std::max(ground, groundAt(place + reach * way));
    return (ground > bottom ? ground : preset.box.centre().z) + preset.clearance;
}

core::Result<ProceduralSource> makeTerrainSource(const Arguments& arguments)
{
    const core::Result<TerrainPreset> made =
        terrainPreset(arguments.words.at("preset"), arguments.load);
    if (!made)
        return tl::unexpected<core::Error>(made.error());
    const TerrainPreset& preset = *made;
    const std::shared_ptr<const Field> field =
        terrain(preset, static_cast<std::uint64_t>(arguments["seed"]), arguments["filter"]);
    return ProceduralSource{
        field,
        preset.box,
        0.0,
        preset.description,
        {preset.start.x, preset.start.y, clearHeight(*field, preset, preset.start)},
        {preset.lookAt.x, preset.lookAt.y, clearHeight(*field, preset, preset.lookAt)}};
}

ProceduralParameter seedParameter(const char* description)
{
    return wholeNumber("seed", description, "1", 0, 0x1p53);
}

ProceduralParameter filterParameter()
{
    return number("filter", "filter strength kappa; 0 turns filtering off", "1", 0, 16);
}

ProceduralDescription describeTerrain()
{
    ProceduralParameter preset{"preset", "kind of terrain", "alpine", 0, 0, false, {}, ".json"};
    for (const TerrainPreset& known : terrainPresets())
        preset.choices.push_back(known.name);
    return {
        "terrain",
        "a landscape of 16 km with overhangs, arches and caves; metres, z up",
        {preset, seedParameter("another landscape for each number"), filterParameter()}};
}

// ---- Graphs -------------------------------------------------------------------------------------

core::Result<graph::Preset>
graphPreset(const std::string& nameOrPath, const graph::FileLoader& load)
{
    for (const PresetText& text : presetTexts())
        if (text.name == nameOrPath)
            return graph::parsePreset(text.json, nameOrPath);
    return graph::readPreset(nameOrPath, load);
}

core::Result<ProceduralSource> makeGraphSource(const Arguments& arguments)
{
    const core::Result<graph::Preset> preset =
        graphPreset(arguments.words.at("file"), arguments.load);
    if (!preset)
        return tl::unexpected<core::Error>(preset.error());
    const glm::dvec3 centre = preset->box.centre();
    return ProceduralSource{
        graph::fieldOf(
            *preset,
            {.seed = static_cast<std::uint64_t>(arguments["seed"]),
             .filterStrength = arguments["filter"]}),
        preset->box,
        0.0,
        preset->description,
        centre + glm::dvec3(0.75, -1.3, 0.65) * preset->box.size().x,
        centre};
}

ProceduralDescription describeGraph()
{
    return {
        "graph",
        "a graph of nodes from a file in JSON",
        {{"file",
          "the graph",
          std::string(kExamplePreset),
          0,
          0,
          false,
          {std::string(kExamplePreset)},
          ".json"},
         seedParameter("other noise for each number"),
         filterParameter()}};
}

// ---- Noise --------------------------------------------------------------------------------------

ProceduralParameter
word(const char* name, const char* description, std::vector<std::string> choices, std::size_t first)
{
    const std::string defaultValue = choices[first];
    return {name, description, defaultValue, 0, 0, false, std::move(choices), ""};
}

const std::vector<std::string> kKinds{"value", "gradient", "simplex", "cellular", "border"};
const std::vector<std::string> kFractals{"brownian", "ridged", "billow"};

template <typename Enum>
Enum numbered(const std::vector<std::string>& words, const std::string& word)
{
    return static_cast<Enum>(std::find(words.begin(), words.end(), word) - words.begin());
}

/// Noise in a ball, or as the height of a landscape.
core::Result<ProceduralSource> makeNoiseSource(const Arguments& arguments)
{
    constexpr double kRadius = 4;
    const bool plane = arguments["plane"] != 0;
    const graph::Node octaves = graph::noise(
        {.kind = numbered<NoiseKind>(kKinds, arguments.words.at("kind")),
         .fractal = numbered<FractalKind>(kFractals, arguments.words.at("fractal")),
         .wavelength = arguments["wavelength"],
         .octaves = static_cast<int>(arguments["octaves"]),
         .lacunarity = arguments["lacunarity"],
         .gain = arguments["gain"],
         .plane = plane});
    const graph::Node surface =
        plane ? octaves - graph::position(graph::Axis::z)
              : min(octaves - arguments["level"], kRadius - graph::distance(0, 0, 0));
    return shapeSource(
        graph::graphField(
            surface,
            {.seed = static_cast<std::uint64_t>(arguments["seed"]),
             .filterStrength = arguments["filter"]}),
        1.25 * kRadius);
}

ProceduralDescription describeNoise()
{
    return {
        "noise",
        "noise as a solid in a ball of radius 4, or as a landscape",
        {word("kind", "of an octave", kKinds, 1),
         word("fractal", "how octaves are put together", kFractals, 0),
         number("wavelength", "of the first octave", "2", 0.01, 100),
         wholeNumber("octaves", "how many", "3", 1, 32),
         number("lacunarity", "frequency of an octave over the one before", "2.03", 1, 16),
         number("gain", "amplitude of an octave over the one before", "0.5", 0, 1),
         number("level", "solid is where the noise is above", "0", -4, 4),
         wholeNumber("plane", "1 makes a landscape", "0", 0, 1),
         seedParameter("other noise for each number"),
         filterParameter()}};
}

// ---- Shapes -------------------------------------------------------------------------------------

std::vector<Maker> makers()
{
    std::vector<Maker> all;
    all.push_back({describeTerrain(), makeTerrainSource});
    all.push_back({describeGraph(), makeGraphSource});
    all.push_back({describeNoise(), makeNoiseSource});
    all.push_back(
        {{"sphere",
          "a ball about the origin, coloured by place",
          {number("radius", "of the ball", "1", 1e-6, 1e9)}},
         [](const Arguments& a) {
             const glm::dvec3 reach(a["radius"]);
             return shapeSource(
                 colouredByPlace(sphere(glm::dvec3(0), a["radius"]), {-reach, reach}),
                 1.25 * a["radius"]);
         }});
    all.push_back(
        {{"torus",
          "a torus about the z axis",
          {number("ring", "radius of the circle in the middle of the tube", "0.75", 1e-6, 1e9),
           number("tube", "radius of the tube", "0.3", 1e-6, 1e9)}},
         [](const Arguments& a) {
             return shapeSource(
                 torus(glm::dvec3(0), a["ring"], a["tube"]), 1.25 * (a["ring"] + a["tube"]));
         }});
    all.push_back(
        {{"box",
          "a box about the origin",
          {number("x", "edge along x", "1.5", 1e-6, 1e9),
           number("y", "edge along y", "1.2", 1e-6, 1e9),
           number("z", "edge along z", "0.9", 1e-6, 1e9)}},
         [](const Arguments& a) {
             const glm::dvec3 half = 0.5 * glm::dvec3(a["x"], a["y"], a["z"]);
             return shapeSource(solidBox({-half, half}), 1.3 * std::max({half.x, half.y, half.z}));
         }});
    all.push_back(
        {{"plane",
          "the half space below a plane through the origin",
          {number("x", "of the plane's normal", "0.1", -1e9, 1e9),
           number("y", "of the plane's normal", "0.2", -1e9, 1e9),
           number("z", "of the plane's normal", "1", 1e-6, 1e9)}},
         [](const Arguments& a) {
             return shapeSource(plane(glm::dvec3(0), {a["x"], a["y"], a["z"]}), 1.0);
         }});
    all.push_back(
        {{"gyroid",
          "Schoen's gyroid in a ball of radius 1",
          {number("periods", "across the domain", "4", 0.01, 1e4),
           wholeNumber("clip", "1 cuts it to the ball, 0 fills the domain", "1", 0, 1)}},
         [](const Arguments& a) {
             const double half = 1.25;
             std::shared_ptr<const Field> field = gyroid(2 * half / a["periods"]);
             if (a["clip"] != 0)
                 field = intersectionOf(field, sphere(glm::dvec3(0), 1.0));
             return shapeSource(field, half);
         }});
    all.push_back(
        {{"julia",
          "a slice of the quaternion Julia set of q^2 + c",
          {number("cr", "real part of c", "-0.2", -1, 1),
           number("ci", "i part of c", "0.68", -1, 1),
           number("cj", "j part of c", "0", -1, 1),
           number("ck", "k part of c", "0", -1, 1),
           number("slice", "k coordinate of the slice", "0", -2, 2),
           wholeNumber("iterations", "steps: more shows finer branches", "12", 1, 40)}},
         [](const Arguments& a) {
             return shapeSource(
                 julia(
                     {.c = {a["cr"], a["ci"], a["cj"], a["ck"]},
                      .slice = a["slice"],
                      .iterations = static_cast<int>(a["iterations"])}),
                 2.0);
         }});
    return all;
}

const std::vector<Maker>& allMakers()
{
    static const std::vector<Maker> all = makers();
    return all;
}

// ---- Reading parameters -------------------------------------------------------------------------

template <typename Items, typename Name>
std::string listed(const Items& items, const Name& name)
{
    std::string list;
    for (const auto& item : items)
        list += (list.empty() ? "" : ", ") + name(item);
    return list;
}

/// 12.5 rather than 12.500000.
std::string shortest(double value)
{
    char text[32];
    const std::to_chars_result end = std::to_chars(text, text + sizeof(text), value);
    return {text, end.ptr};
}

/// What a value must be, as the end of a sentence.
std::string expected(const ProceduralParameter& parameter)
{
    if (!parameter.choices.empty())
        return "give one of " + listed(parameter.choices, [](const std::string& c) { return c; }) +
               (parameter.fileSuffix.empty()
                    ? ""
                    : ", or the path of a " + parameter.fileSuffix + " file");
    return std::string("give a ") + (parameter.whole ? "whole " : "") + "number from " +
           shortest(parameter.least) + " to " + shortest(parameter.most);
}

bool readInto(Arguments& arguments, const ProceduralParameter& parameter, const std::string& text)
{
    if (!parameter.choices.empty()) {
        arguments.words[parameter.name] = text;
        return (!parameter.fileSuffix.empty() && text.ends_with(parameter.fileSuffix)) ||
               std::find(parameter.choices.begin(), parameter.choices.end(), text) !=
                   parameter.choices.end();
    }
    double value = 0;
    const char* end = text.data() + text.size();
    const std::from_chars_result read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc() || read.ptr != end || !std::isfinite(value))
        return false;
    arguments.numbers[parameter.name] = value;
    return value >= parameter.least && value <= parameter.most &&
           (!parameter.whole || value == std::floor(value));
}

std::map<std::string, std::string>
inOneWay(const Arguments& arguments, const std::vector<ProceduralParameter>& parameters)
{
    std::map<std::string, std::string> written;
    for (const ProceduralParameter& parameter : parameters) {
        const std::string& name = parameter.name;
        if (parameter.choices.empty())
            written[name] = shortest(arguments[name] + 0.0); // without a sign at 0
        else
            written[name] = std::filesystem::path(arguments.words.at(name)).filename().string();
    }
    return written;
}

} // namespace

const std::vector<ProceduralDescription>& proceduralSources()
{
    static const std::vector<ProceduralDescription> descriptions = [] {
        std::vector<ProceduralDescription> all;
        for (const Maker& maker : allMakers())
            all.push_back(maker.description);
        return all;
    }();
    return descriptions;
}

core::Result<ProceduralSource> makeProcedural(
    const std::string& name,
    const std::map<std::string, std::string>& parameters,
    const graph::FileLoader& load)
{
    const auto maker =
        std::find_if(allMakers().begin(), allMakers().end(), [&](const Maker& candidate) {
            return candidate.description.name == name;
        });
    if (maker == allMakers().end())
        return core::failure(
            ErrorCode::usage,
            "there is no procedural source '" + name + "'; choose one of " +
                listed(proceduralSources(), [](const auto& source) { return source.name; }));

    const ProceduralDescription& description = maker->description;
    for (const auto& [key, value] : parameters) {
        const bool known = std::any_of(
            description.parameters.begin(),
            description.parameters.end(),
            [&, &wanted = key](const ProceduralParameter& p) { return p.name == wanted; });
        if (!known)
            return core::failure(
                ErrorCode::usage,
                "the source '" + name + "' has no parameter '" + key + "'; it has " +
                    listed(description.parameters, [](const auto& p) { return p.name; }));
    }

    Arguments arguments;
    arguments.load = load;
    for (const ProceduralParameter& parameter : description.parameters) {
        const auto given = parameters.find(parameter.name);
        const std::string& text =
            given == parameters.end() ? parameter.defaultValue : given->second;
        if (!readInto(arguments, parameter, text))
            return core::failure(
                ErrorCode::usage,
                "'" + text + "' won't do for the parameter '" + parameter.name +
                    "' of the source '" + name + "'; " + expected(parameter));
    }
    core::Result<ProceduralSource> source = maker->make(arguments);
    if (source)
        source->parameters = inOneWay(arguments, description.parameters);
    if (source && source->description.empty())
        source->description = description.description;
    return source;
}

} // namespace isofront::fields

#include "isofront/fields/GraphJson.h"

#include "graph/JsonObject.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace isofront::fields::graph {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;
constexpr std::size_t kMostObjects = 2000;
constexpr int kDeepest = 400;
constexpr int kVersion = 1;

// Lengths from a micrometre to beyond the Earth's orbit, and what they can be factors of.
constexpr double kShortest = 1e-6;
constexpr double kLongest = 1e12;

/// The same number for the same text, on every machine (FNV-1a).
std::uint64_t hashOf(std::string_view text)
{
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return hash;
}

Json parsed(std::string_view text)
{
    if (text.size() > kMostBytes)
        throw Problem{"it is longer than 1 MiB; a preset is a few kilobytes"};
    // The library keeps the last of two equal keys; a writer of presets wants to know.
    std::vector<std::set<std::string>> keys;
    const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
        if (depth > 100)
            throw Problem{"its brackets are nested deeper than 100"};
        if (event == Json::parse_event_t::object_start)
            keys.emplace_back();
        else if (event == Json::parse_event_t::object_end)
            keys.pop_back();
        else if (
            event == Json::parse_event_t::key &&
            !keys.back().insert(value.get<std::string>()).second)
            throw Problem{"the key '" + value.get<std::string>() + "' is there twice; remove one"};
        return true;
    };
    try {
        return Json::parse(text, watch);
    } catch (const Json::exception& e) {
        std::string why = e.what();
        std::replace(why.begin(), why.end(), '\n', ' ');
        throw Problem{"it is not JSON: " + why};
    }
}

/// Makes the nodes of a document, each once.
class Maker {
public:
    explicit Maker(const Json& nodes) : _nodes(nodes)
    {
        if (!nodes.is_object() || nodes.empty())
            throw Problem{"'nodes' must be an object with a node for each name"};
    }

    Node named(const std::string& name)
    {
        const auto known = _made.find(name);
        if (known != _made.end())
            return known->second;
        const auto node = _nodes.find(name);
        if (node == _nodes.end())
            throw Problem{"there is no node '" + name + "'"};
        if (!_open.insert(name).second)
            throw Problem{"the node '" + name + "' needs itself; break the circle"};
        Node result = made(*node, name);
        _open.erase(name);
        return _made.emplace(name, result).first->second;
    }

    /// A name nobody uses is most likely a slip of the pen.
    void checkAllUsed() const
    {
        for (const auto& item : _nodes.items())
            if (!_made.contains(item.key()))
                throw Problem{"the node '" + item.key() + "' is not used; connect it or remove it"};
    }

private:
    using Make = Node (Maker::*)(JsonObject&);

    static const std::map<std::string, Make>& types()
    {
        static const std::map<std::string, Make> all{
            {"position", &Maker::position},
            {"distance", &Maker::distance},
            {"noise", &Maker::noise},
            {"filterWeight", &Maker::filterWeight},
            {"add", &Maker::add},
            {"subtract", &Maker::subtract},
            {"multiply", &Maker::multiply},
            {"abs", &Maker::abs},
            {"square", &Maker::square},
            {"sqrt", &Maker::sqrt},
            {"min", &Maker::min},
            {"max", &Maker::max},
            {"smoothMin", &Maker::smoothMin},
            {"smoothMax", &Maker::smoothMax},
            {"clamp", &Maker::clamp},
            {"smoothStep", &Maker::smoothStep},
            {"mix", &Maker::mix},
            {"curve", &Maker::curve},
            {"warp", &Maker::warp},
            {"placed", &Maker::placed},
            {"detail", &Maker::detail},
            {"tunnels", &Maker::tunnels},
        };
        return all;
    }

    Node made(const Json& value, const std::string& where)
    {
        if (++_objects > kMostObjects)
            throw Problem{"it has more than " + std::to_string(kMostObjects) + " nodes"};
        if (++_depth > kDeepest)
            throw Problem{
                "nodes need one another in a chain longer than " + std::to_string(kDeepest)};
        JsonObject object(value, "the node '" + where + "'");
        _paths.push_back(where);
        const std::string type = object.text("type");
        const auto make = types().find(type);
        if (make == types().end()) {
            std::string names;
            for (const auto& [name, unused] : types())
                names += (names.empty() ? "" : ", ") + name;
            object.fail("there is no type '" + type + "'; choose one of " + names);
        }
        Node node = (this->*make->second)(object);
        object.finish();
        _paths.pop_back();
        --_depth;
        return node;
    }

    Node resolved(JsonObject& object, const Json& value, const std::string& key)
    {
        if (value.is_number())
            return object.checked(value, key, -kLongest, kLongest);
        if (value.is_string())
            return named(value.get<std::string>());
        if (value.is_object())
            return made(value, _paths.back() + "." + key);
        object.fail("'" + key + "' must be the name of a node, a node, or a number");
    }

    Node input(JsonObject& object, const std::string& key)
    {
        return resolved(object, object.required(key), key);
    }
    Node input(JsonObject& object, const std::string& key, double otherwise)
    {
        const Json* value = object.optional(key);
        return value == nullptr ? Node(otherwise) : resolved(object, *value, key);
    }

    /// Two or more inputs, joined from the first to the last.
    template <typename Join>
    Node joined(JsonObject& object, const Join& join)
    {
        const Json& list = object.required("inputs");
        if (!list.is_array() || list.size() < 2)
            object.fail("'inputs' must be a list of two or more");
        Node result = resolved(object, list[0], "inputs.0");
        for (std::size_t i = 1; i < list.size(); ++i)
            result = join(result, resolved(object, list[i], "inputs." + std::to_string(i)));
        return result;
    }

    /// The node's own, or one drawn from its name.
    std::uint64_t seedOf(JsonObject& object, const std::string& suffix = "")
    {
        if (object.optional("seed") == nullptr)
            return hashOf(_paths.back() + suffix);
        return static_cast<std::uint64_t>(object.whole("seed", 0, 0x1p53, 0));
    }

    OctaveSettings octaves(JsonObject& object, const std::string& suffix = "")
    {
        OctaveSettings settings;
        settings.kind = static_cast<NoiseKind>(
            object.choice("kind", {"value", "gradient", "simplex", "cellular", "border"}, 1));
        settings.wavelength = object.number("wavelength", kShortest, kLongest);
        settings.octaves = static_cast<int>(object.whole("octaves", 0, 32, 1));
        settings.amplitude = object.number("amplitude", -kLongest, kLongest, 1.0);
        settings.lacunarity = object.number("lacunarity", 1, 16, settings.lacunarity);
        settings.gain = object.number("gain", -4, 4, settings.gain);
        settings.stretch = object.number("stretch", 1e-3, 1e3, settings.stretch);
        settings.filtered = object.flag("filtered", true);
        settings.seed = seedOf(object, suffix);
        return settings;
    }
    // ---- One for each type ----------------------------------------------------------------------

    Node position(JsonObject& object)
    {
        object.required("axis");
        return graph::position(static_cast<Axis>(object.choice("axis", {"x", "y", "z"}, 0)));
    }
    Node distance(JsonObject& object)
    {
        const std::vector<double> from = object.numbers("from", 3, kLongest);
        return graph::distance(from[0], from[1], from[2]);
    }
    Node noise(JsonObject& object)
    {
        const auto fractal =
            static_cast<FractalKind>(object.choice("fractal", {"brownian", "ridged", "billow"}, 0));
        const bool plane = object.flag("plane", false);
        const double carry = object.number("carry", 0, 1e3, 4.0);
        OctaveSettings settings = octaves(object);
        settings.fractal = fractal;
        settings.plane = plane;
        settings.carry = carry;
        return graph::noise(settings);
    }
    Node filterWeight(JsonObject& object)
    {
        return graph::filterWeight(object.number("wavelength", kShortest, kLongest));
    }

    Node add(JsonObject& object)
    {
        return joined(object, [](const Node& a, const Node& b) { return a + b; });
    }
    Node subtract(JsonObject& object)
    {
        return joined(object, [](const Node& a, const Node& b) { return a - b; });
    }
    Node multiply(JsonObject& object)
    {
        return joined(object, [](const Node& a, const Node& b) { return a * b; });
    }
    Node abs(JsonObject& object) { return graph::abs(input(object, "input")); }
    Node square(JsonObject& object) { return graph::square(input(object, "input")); }
    Node sqrt(JsonObject& object) { return graph::sqrt(input(object, "input")); }

    Node min(JsonObject& object)
    {
        return joined(object, [](const Node& a, const Node& b) { return graph::min(a, b); });
    }
    Node max(JsonObject& object)
    {
        return joined(object, [](const Node& a, const Node& b) { return graph::max(a, b); });
    }
    Node smoothMin(JsonObject& object)
    {
        const double width = object.number("width", kShortest, kLongest);
        return joined(object, [width](const Node& a, const Node& b) {
            return graph::smoothMin(a, b, width);
        });
    }
    Node smoothMax(JsonObject& object)
    {
        const double width = object.number("width", kShortest, kLongest);
        return joined(object, [width](const Node& a, const Node& b) {
            return graph::smoothMax(a, b, width);
        });
    }
    Node clamp(JsonObject& object)
    {
        const double low = object.number("low", -kLongest, kLongest);
        const double high = object.number("high", low, kLongest);
        return graph::clamp(input(object, "input"), low, high);
    }
    Node smoothStep(JsonObject& object)
    {
        const double begin = object.number("begin", -kLongest, kLongest);
        const double end = object.number("end", -kLongest, kLongest);
        // The slope of the step has to be a number too.
        if (!(end - begin >= 1e-6 * std::max({1e-6, std::abs(begin), std::abs(end)})))
            object.fail("'end' must lie above 'begin'");
        return graph::smoothStep(input(object, "input"), begin, end);
    }
    Node mix(JsonObject& object)
    {
        const Node a = input(object, "from");
        const Node b = input(object, "to");
        return graph::mix(a, b, input(object, "by"));
    }
    Node curve(JsonObject& object)
    {
        const Json& list = object.required("points");
        if (!list.is_array() || list.empty() || list.size() > 64)
            object.fail("'points' must be a list of 1 to 64 pairs [at, value]");
        std::vector<CurvePoint> points;
        for (const Json& pair : list) {
            if (!pair.is_array() || pair.size() != 2)
                object.fail("'points' must be a list of pairs [at, value]");
            const CurvePoint point{
                object.checked(pair[0], "points", -kLongest, kLongest),
                object.checked(pair[1], "points", -kLongest, kLongest)};
            // So far apart that the slope between them is a number too.
            if (!points.empty() &&
                !(point.at - points.back().at >=
                  1e-6 * std::max({1e-6, std::abs(point.at), std::abs(points.back().at)})))
                object.fail("'points' must be in rising order");
            points.push_back(point);
        }
        return graph::curve(input(object, "input"), points);
    }

    Node warp(JsonObject& object)
    {
        const Node x = input(object, "x", 0.0);
        const Node y = input(object, "y", 0.0);
        const Node z = input(object, "z", 0.0);
        const double stretch = object.number("stretch", 1e-3, 1e3, 1.0);
        return graph::warp(input(object, "input"), x, y, z, stretch);
    }
    Node placed(JsonObject& object)
    {
        const std::vector<double> at = object.numbers("at", 3, kLongest);
        const double scale = object.number("scale", 1e-6, 1e6, 1.0);
        return graph::placed(input(object, "input"), at[0], at[1], at[2], scale);
    }

    Node detail(JsonObject& object)
    {
        const Json& list = object.required("layers");
        if (!list.is_array() || list.empty() || list.size() > 16)
            object.fail("'layers' must be a list of 1 to 16 sets of octaves");
        std::vector<OctaveSettings> layers;
        for (const Json& layer : list) {
            const std::string suffix = ".layers." + std::to_string(layers.size());
            JsonObject settings(layer, "the node '" + _paths.back() + suffix + "'");
            layers.push_back(octaves(settings, suffix));
            settings.finish();
        }
        const Node strength = input(object, "strength", 1.0);
        const double reserve = object.number("reserve", 0, kLongest, 0.0);
        return graph::detail(input(object, "input"), layers, strength, reserve);
    }
    Node tunnels(JsonObject& object)
    {
        TunnelSettings settings;
        settings.wavelength = object.number("wavelength", kShortest, kLongest);
        settings.radius = object.number("radius", kShortest, kLongest);
        settings.radiusVariation =
            object.number("radiusVariation", 0, 10, settings.radiusVariation);
        settings.depth = object.number("depth", 0, kLongest);
        settings.stretch = object.number("stretch", 1e-3, 1e3, settings.stretch);
        settings.rounding = object.number("rounding", kShortest, kLongest, 0.3 * settings.radius);
        settings.seed = seedOf(object);
        return graph::tunnels(input(object, "input"), settings);
    }

    const Json& _nodes;
    std::map<std::string, Node> _made;
    std::set<std::string> _open;
    std::vector<std::string> _paths;
    std::size_t _objects = 0;
    int _depth = 0;
};

Preset presetOf(std::string_view text)
{
    const Json document = parsed(text);
    JsonObject top(document, "the preset");
    const auto version = static_cast<int>(top.whole("isofrontGraph", 0, 1e9));
    if (version != kVersion)
        top.fail(
            "it is written for version " + std::to_string(version) +
            " of the format; this program reads version " + std::to_string(kVersion));

    Preset preset;
    preset.name = top.text("name");
    preset.description = top.text("description");

    JsonObject box(top.required("box"), "the preset's box");
    const std::vector<double> centre = box.numbers("centre", 3, kLongest);
    const double edge = box.number("edge", kShortest, kLongest);
    box.finish();
    const glm::dvec3 middle(centre[0], centre[1], centre[2]);
    preset.box = {middle - 0.5 * edge, middle + 0.5 * edge};
    preset.lookAt = {middle.x, middle.y};
    preset.start = {middle.x, middle.y - 0.35 * edge};
    preset.clearance = edge / 50;

    if (const Json* given = top.optional("flight")) {
        JsonObject flight(*given, "the preset's flight");
        const std::vector<double> start = flight.numbers("start", 2, kLongest);
        const std::vector<double> lookAt = flight.numbers("lookAt", 2, kLongest);
        preset.start = {start[0], start[1]};
        preset.lookAt = {lookAt[0], lookAt[1]};
        preset.clearance = flight.number("clearance", 0, kLongest, preset.clearance);
        flight.finish();
        if (preset.start == preset.lookAt)
            flight.fail("'start' and 'lookAt' must be two places");
    }

    Maker maker(top.required("nodes"));
    preset.surface = maker.named(top.text("result"));
    maker.checkAllUsed();
    top.finish();
    if (!fits(preset.surface))
        top.fail(
            "it has more than " + std::to_string(kMostNodes) +
            " nodes; a node counts once for each warp that it is used in");
    return preset;
}

} // namespace

core::Result<Preset> parsePreset(std::string_view text, const std::string& what)
{
    try {
        return presetOf(text);
    } catch (const Problem& problem) {
        return core::failure(core::ErrorCode::badData, what + ": " + problem.message);
    }
}

core::Result<Preset> readPreset(const std::string& path)
{
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code))
        return core::failure(
            core::ErrorCode::inputOutput, path + ": there is no such file; give a graph in JSON");
    if (std::filesystem::file_size(path, code) > kMostBytes)
        return core::failure(
            core::ErrorCode::badData,
            path + ": it is longer than 1 MiB; a preset is a few kilobytes");
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    if (!file)
        return core::failure(
            core::ErrorCode::inputOutput, path + ": can't be read; check its permissions");
    return parsePreset(text.str(), path);
}

} // namespace isofront::fields::graph

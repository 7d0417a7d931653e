#include "graph/JsonNodes.h"

#include "graph/JsonObject.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

namespace isofront::fields::graph {

namespace {

constexpr std::size_t kMostNodesInFile = 2000;
constexpr int kDeepest = 400;
constexpr std::size_t kLongestPath = 200;
/// Of the values of files.
constexpr double kLargestValue = 1e30;

/// The same number for the same text, on every machine (FNV-1a).
std::uint64_t hashOf(std::string_view text)
{
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return hash;
}

std::optional<double>
optionalNumber(JsonObject& object, const std::string& key, double least, double most)
{
    if (object.optional(key) == nullptr)
        return std::nullopt;
    return object.number(key, least, most);
}

} // namespace

JsonNodes::JsonNodes(const Json& nodes, const PresetFiles& files) : _nodes(nodes), _files(files)
{
    if (!nodes.is_object() || nodes.empty())
        throw Problem{"'nodes' must be an object with a node for each name"};
}

Node JsonNodes::input(JsonObject& object, const std::string& key, const std::string& where)
{
    _paths.push_back(where);
    Node node = input(object, key);
    _paths.pop_back();
    return node;
}

void JsonNodes::checkAllUsed() const
{
    for (const auto& item : _nodes.items())
        if (!_made.contains(item.key()))
            throw Problem{
                "the node " + inQuotes(item.key()) + " is not used; connect it or remove it"};
}

std::vector<std::string> JsonNodes::names() const
{
    std::vector<std::string> all;
    for (const auto& item : _nodes.items())
        all.push_back(item.key());
    return all;
}

Node JsonNodes::named(JsonObject& object, const std::string& key, const std::string& name)
{
    const auto known = _made.find(name);
    if (known != _made.end())
        return known->second;
    const auto node = _nodes.find(name);
    if (node == _nodes.end())
        object.fail(
            inQuotes(key) + " names a node that isn't there, " + inQuotes(name) +
            suggestion(name, names()));
    const auto open = std::find(_open.begin(), _open.end(), name);
    if (open != _open.end()) {
        constexpr std::ptrdiff_t kMostShown = 6;
        std::string circle;
        for (auto it = open; it != _open.end() && it - open < kMostShown; ++it)
            circle += inQuotes(*it) + " needs ";
        if (_open.end() - open > kMostShown)
            circle += "... needs ";
        object.fail(
            inQuotes(key) + " closes a circle: " + circle + inQuotes(name) +
            "; break it somewhere");
    }
    _open.push_back(name);
    Node result = made(*node, name);
    _open.pop_back();
    return _made.emplace(name, result).first->second;
}

const std::map<std::string, JsonNodes::Make>& JsonNodes::types()
{
    static const std::map<std::string, Make> all{
        {"position", &JsonNodes::position},
        {"distance", &JsonNodes::distance},
        {"noise", &JsonNodes::noise},
        {"filterWeight", &JsonNodes::filterWeight},
        {"elevation", &JsonNodes::elevation},
        {"volume", &JsonNodes::volume},
        {"add", &JsonNodes::add},
        {"subtract", &JsonNodes::subtract},
        {"multiply", &JsonNodes::multiply},
        {"abs", &JsonNodes::abs},
        {"square", &JsonNodes::square},
        {"sqrt", &JsonNodes::sqrt},
        {"min", &JsonNodes::min},
        {"max", &JsonNodes::max},
        {"smoothMin", &JsonNodes::smoothMin},
        {"smoothMax", &JsonNodes::smoothMax},
        {"clamp", &JsonNodes::clamp},
        {"smoothStep", &JsonNodes::smoothStep},
        {"mix", &JsonNodes::mix},
        {"curve", &JsonNodes::curve},
        {"warp", &JsonNodes::warp},
        {"placed", &JsonNodes::placed},
        {"detail", &JsonNodes::detail},
        {"tunnels", &JsonNodes::tunnels},
    };
    return all;
}

/// Joins count too: evaluation goes through a chain of them step within step.
void JsonNodes::count(const JsonObject& object)
{
    if (++_count > kMostNodesInFile)
        object.fail(
            "up to here there are more than " + std::to_string(kMostNodesInFile) +
            " nodes and joins; use fewer");
}

Node JsonNodes::made(const Json& value, const std::string& where)
{
    JsonObject object(value, "the node " + inQuotes(where, kLongestPath));
    count(object);
    if (++_depth > kDeepest)
        object.fail(
            "nodes need one another in a chain longer than " + std::to_string(kDeepest) +
            "; join some of them side by side");
    _paths.push_back(where);
    const std::string type = object.text("type");
    const auto make = types().find(type);
    if (make == types().end()) {
        std::vector<std::string> all;
        for (const auto& known : types())
            all.push_back(known.first);
        object.fail(
            "there is no type " + inQuotes(type) + suggestion(type, all) + "; types are " +
            listed(all));
    }
    Node node = (this->*make->second)(object);
    object.finish();
    _paths.pop_back();
    --_depth;
    return node;
}

Node JsonNodes::resolved(JsonObject& object, const Json& value, const std::string& key)
{
    if (value.is_number())
        return object.checked(value, key, -kLongest, kLongest);
    if (value.is_string())
        return named(object, key, value.get<std::string>());
    if (value.is_object())
        return made(value, _paths.back() + "." + key);
    object.fail("'" + key + "' must be the name of a node, a node, or a number");
}

Node JsonNodes::input(JsonObject& object, const std::string& key)
{
    return resolved(object, object.required(key), key);
}
Node JsonNodes::input(JsonObject& object, const std::string& key, double otherwise)
{
    const Json* value = object.optional(key);
    return value == nullptr ? Node(otherwise) : resolved(object, *value, key);
}

/// Two or more inputs, joined from the first to the last.
template <typename Join>
Node JsonNodes::joined(JsonObject& object, const Join& join)
{
    const Json& list = object.required("inputs");
    if (!list.is_array() || list.size() < 2)
        object.fail("'inputs' must be a list of two or more");
    Node result = resolved(object, list[0], "inputs.0");
    for (std::size_t i = 1; i < list.size(); ++i) {
        count(object);
        result = join(result, resolved(object, list[i], "inputs." + std::to_string(i)));
    }
    return result;
}

/// The node's own, or one drawn from its name.
std::uint64_t JsonNodes::seedOf(JsonObject& object, const std::string& suffix)
{
    if (object.optional("seed") == nullptr)
        return hashOf(_paths.back() + suffix);
    return static_cast<std::uint64_t>(object.whole("seed", 0, 0x1p53, 0));
}

OctaveSettings JsonNodes::octaves(JsonObject& object, const std::string& suffix)
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

/// A field from a file. A file that is named twice is loaded once.
Node JsonNodes::loaded(JsonObject& object, FileRequest request)
{
    const std::string file = object.text("file");
    if (file.empty() || file.find('\0') != std::string::npos)
        object.fail("'file' must be the path of a file, as seen from the preset");
    request.path = (std::filesystem::path(_files.folder) / file).string();
    // What it is read as, and the options, tell two requests for one file apart.
    std::string key = request.kind == FileRequest::Kind::volume ? "volume" : "elevation";
    key += '\0' + request.path + '\0' + request.grid;
    for (const std::optional<double>& option :
         {request.isovalue, request.pixelSize, request.heightScale, request.noData})
        key += '\0' + (option ? std::to_string(std::bit_cast<std::uint64_t>(*option)) : "");
    std::shared_ptr<const Field>& field = _loaded[key];
    if (field == nullptr) {
        if (!_files.load)
            object.fail("files can't be read from here; load the preset with what reads files");
        core::Result<std::shared_ptr<const Field>> read = _files.load(request);
        if (!read)
            throw Problem{object.what() + ": " + read.error().message, read.error().code};
        field = std::move(*read);
    }
    return source(field);
}

// ---- One for each type --------------------------------------------------------------------------

Node JsonNodes::position(JsonObject& object)
{
    object.required("axis");
    return graph::position(static_cast<Axis>(object.choice("axis", {"x", "y", "z"}, 0)));
}
Node JsonNodes::distance(JsonObject& object)
{
    const std::vector<double> from = object.numbers("from", 3, kLongest);
    return graph::distance(from[0], from[1], from[2]);
}
Node JsonNodes::noise(JsonObject& object)
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
Node JsonNodes::filterWeight(JsonObject& object)
{
    return graph::filterWeight(object.number("wavelength", kShortest, kLongest));
}

Node JsonNodes::elevation(JsonObject& object)
{
    FileRequest request{.kind = FileRequest::Kind::elevation};
    request.pixelSize = optionalNumber(object, "pixelSize", kShortest, kLongest);
    request.heightScale = optionalNumber(object, "heightScale", -kLongest, kLongest);
    request.noData = optionalNumber(object, "noData", -kLargestValue, kLargestValue);
    return loaded(object, std::move(request));
}
Node JsonNodes::volume(JsonObject& object)
{
    FileRequest request{.kind = FileRequest::Kind::volume};
    request.isovalue = optionalNumber(object, "isovalue", -kLargestValue, kLargestValue);
    if (object.optional("grid") != nullptr)
        request.grid = object.line("grid");
    return loaded(object, std::move(request));
}

Node JsonNodes::add(JsonObject& object)
{
    return joined(object, [](const Node& a, const Node& b) { return a + b; });
}
Node JsonNodes::subtract(JsonObject& object)
{
    return joined(object, [](const Node& a, const Node& b) { return a - b; });
}
Node JsonNodes::multiply(JsonObject& object)
{
    return joined(object, [](const Node& a, const Node& b) { return a * b; });
}
Node JsonNodes::abs(JsonObject& object)
{
    return graph::abs(input(object, "input"));
}
Node JsonNodes::square(JsonObject& object)
{
    return graph::square(input(object, "input"));
}
Node JsonNodes::sqrt(JsonObject& object)
{
    return graph::sqrt(input(object, "input"));
}

Node JsonNodes::min(JsonObject& object)
{
    return joined(object, [](const Node& a, const Node& b) { return graph::min(a, b); });
}
Node JsonNodes::max(JsonObject& object)
{
    return joined(object, [](const Node& a, const Node& b) { return graph::max(a, b); });
}
Node JsonNodes::smoothMin(JsonObject& object)
{
    const double width = object.number("width", kShortest, kLongest);
    return joined(
        object, [width](const Node& a, const Node& b) { return graph::smoothMin(a, b, width); });
}
Node JsonNodes::smoothMax(JsonObject& object)
{
    const double width = object.number("width", kShortest, kLongest);
    return joined(
        object, [width](const Node& a, const Node& b) { return graph::smoothMax(a, b, width); });
}
Node JsonNodes::clamp(JsonObject& object)
{
    const double low = object.number("low", -kLongest, kLongest);
    const double high = object.number("high", low, kLongest);
    return graph::clamp(input(object, "input"), low, high);
}
Node JsonNodes::smoothStep(JsonObject& object)
{
    const double begin = object.number("begin", -kLongest, kLongest);
    const double end = object.number("end", -kLongest, kLongest);
    // The slope of the step has to be a number too.
    if (!(end - begin >= 1e-6 * std::max({1e-6, std::abs(begin), std::abs(end)})))
        object.fail("'end' must lie above 'begin'");
    return graph::smoothStep(input(object, "input"), begin, end);
}
Node JsonNodes::mix(JsonObject& object)
{
    const Node a = input(object, "from");
    const Node b = input(object, "to");
    return graph::mix(a, b, input(object, "by"));
}
Node JsonNodes::curve(JsonObject& object)
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

Node JsonNodes::warp(JsonObject& object)
{
    const Node x = input(object, "x", 0.0);
    const Node y = input(object, "y", 0.0);
    const Node z = input(object, "z", 0.0);
    const double stretch = object.number("stretch", 1e-3, 1e3, 1.0);
    return graph::warp(input(object, "input"), x, y, z, stretch);
}
Node JsonNodes::placed(JsonObject& object)
{
    const std::vector<double> at = object.numbers("at", 3, kLongest);
    const double scale = object.number("scale", 1e-6, 1e6, 1.0);
    return graph::placed(input(object, "input"), at[0], at[1], at[2], scale);
}

Node JsonNodes::detail(JsonObject& object)
{
    const Json& list = object.required("layers");
    if (!list.is_array() || list.empty() || list.size() > 16)
        object.fail("'layers' must be a list of 1 to 16 sets of octaves");
    std::vector<OctaveSettings> layers;
    for (const Json& layer : list) {
        const std::string suffix = ".layers." + std::to_string(layers.size());
        JsonObject settings(layer, "the node " + inQuotes(_paths.back() + suffix, kLongestPath));
        layers.push_back(octaves(settings, suffix));
        settings.finish();
    }
    const Node strength = input(object, "strength", 1.0);
    const double reserve = object.number("reserve", 0, kLongest, 0.0);
    return graph::detail(input(object, "input"), layers, strength, reserve);
}
Node JsonNodes::tunnels(JsonObject& object)
{
    TunnelSettings settings;
    settings.wavelength = object.number("wavelength", kShortest, kLongest);
    settings.radius = object.number("radius", kShortest, kLongest);
    settings.radiusVariation = object.number("radiusVariation", 0, 10, settings.radiusVariation);
    settings.depth = object.number("depth", 0, kLongest);
    settings.stretch = object.number("stretch", 1e-3, 1e3, settings.stretch);
    settings.rounding = object.number("rounding", kShortest, kLongest, 0.3 * settings.radius);
    settings.seed = seedOf(object);
    return graph::tunnels(input(object, "input"), settings);
}

} // namespace isofront::fields::graph

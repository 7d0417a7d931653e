#include "isofront/fields/GraphJson.h"

#include "graph/JsonNodes.h"
#include "graph/JsonObject.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <utility>

namespace isofront::fields::graph {

namespace {

constexpr int kVersion = 1;

/// A cube in which doubles can tell places apart.
core::Box boxOf(JsonObject& object)
{
    constexpr double kLeastShare = 1e-6;
    const std::vector<double> centre = object.numbers("centre", 3, kLongest);
    const double edge = object.number("edge", kShortest, kLongest);
    object.finish();
    const glm::dvec3 middle(centre[0], centre[1], centre[2]);
    const double far = std::max({std::abs(middle.x), std::abs(middle.y), std::abs(middle.z)});
    if (edge < kLeastShare * far)
        object.fail(
            "'edge' is too short for a 'centre' so far out; it must be a millionth of that");
    return {middle - 0.5 * edge, middle + 0.5 * edge};
}

void readFlight(JsonObject& object, Preset& preset)
{
    const auto place = [&](const char* key) {
        const std::vector<double> at = object.numbers(key, 2, kLongest);
        const core::Box& box = preset.box;
        if (!(at[0] >= box.low.x && at[0] <= box.high.x && at[1] >= box.low.y &&
              at[1] <= box.high.y))
            object.fail(inQuotes(key) + " lies outside the preset's box");
        return glm::dvec2(at[0], at[1]);
    };
    preset.start = place("start");
    preset.lookAt = place("lookAt");
    preset.clearance = object.number("clearance", 0, kLongest, preset.clearance);
    object.finish();
    if (preset.start == preset.lookAt)
        object.fail("'start' and 'lookAt' must be two places");
}

/// "#f0e8d0" as 0xBBGGRR.
std::uint32_t colourOf(JsonObject& object)
{
    const std::string text = object.text("colour");
    std::uint32_t rgb = 0;
    const char* end = text.data() + text.size();
    const bool hasForm = text.size() == 7 && text[0] == '#' && text[1] != '-';
    const auto read = hasForm ? std::from_chars(text.data() + 1, end, rgb, 16)
                              : std::from_chars_result{text.data(), std::errc::invalid_argument};
    if (read.ec != std::errc() || read.ptr != end)
        object.fail("'colour' must be like \"#8a7b6c\": red, green and blue, two digits each");
    return (rgb & 0xffU) << 16U | (rgb & 0xff00U) | rgb >> 16U;
}

std::vector<Material> materialsOf(const Json& list, JsonNodes& nodes)
{
    if (!list.is_array() || list.empty() || list.size() > kMostMaterials)
        throw Problem{
            "'materials' must be a list of 1 to " + std::to_string(kMostMaterials) + " objects"};
    std::vector<Material> materials;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const std::string where = "materials." + std::to_string(i);
        JsonObject object(list[i], "the material '" + where + "'");
        Material material{object.line("name"), colourOf(object), std::nullopt};
        const bool isLast = i + 1 == list.size();
        if (!isLast)
            material.where = nodes.input(object, "where", where);
        else if (object.optional("where") != nullptr)
            object.fail("the last material is where no other is; remove 'where'");
        object.finish();
        materials.push_back(std::move(material));
    }
    return materials;
}

Preset presetOf(std::string_view text, const PresetFiles& files)
{
    const Json document = parsedJson(text);
    JsonObject top(document, "the preset");
    const auto version = static_cast<int>(top.whole("isofrontGraph", 0, 1e9));
    if (version != kVersion)
        top.fail(
            "it is written for version " + std::to_string(version) +
            " of the format; this program reads version " + std::to_string(kVersion));

    Preset preset;
    preset.name = top.line("name");
    preset.description = top.line("description");

    JsonObject box(top.required("box"), "the preset's box");
    preset.box = boxOf(box);
    const glm::dvec3 middle = preset.box.centre();
    const double edge = preset.box.size().x;
    preset.lookAt = {middle.x, middle.y};
    preset.start = {middle.x, middle.y - 0.35 * edge};
    preset.clearance = edge / 50;
    if (const Json* given = top.optional("flight")) {
        JsonObject flight(*given, "the preset's flight");
        readFlight(flight, preset);
    }

    JsonNodes nodes(top.required("nodes"), files);
    if (!top.required("result").is_string())
        top.fail("'result' must be the name of a node");
    preset.surface = nodes.input(top, "result", "result");
    if (const Json* list = top.optional("materials"))
        preset.materials = materialsOf(*list, nodes);
    nodes.checkAllUsed();
    top.finish();
    bool isFit = fits(preset.surface);
    for (const Material& material : preset.materials)
        isFit = isFit && (!material.where || fits(*material.where));
    if (!isFit)
        top.fail(
            "it has more than " + std::to_string(kMostNodes) +
            " nodes; a node counts once for each warp that it is used in");
    return preset;
}

} // namespace

core::Result<Preset>
parsePreset(std::string_view text, const std::string& what, const PresetFiles& files)
{
    try {
        return presetOf(text, files);
    } catch (const Problem& problem) {
        return core::failure(problem.code, what + ": " + problem.message);
    }
}

core::Result<Preset> readPreset(const std::string& path, const FileLoader& load)
{
    std::error_code code;
    const std::filesystem::file_status status = std::filesystem::status(path, code);
    if (!std::filesystem::exists(status))
        return core::failure(
            core::ErrorCode::inputOutput, path + ": there is no such file; give a graph in JSON");
    if (!std::filesystem::is_regular_file(status))
        return core::failure(
            core::ErrorCode::inputOutput, path + ": it is no file; give a graph in JSON");
    // One byte more than a preset may have is enough to see that it is too long.
    std::string text(kMostBytes + 1, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!file.is_open() || file.bad())
        return core::failure(
            core::ErrorCode::inputOutput, path + ": can't be read; check its permissions");
    text.resize(static_cast<std::size_t>(file.gcount()));
    return parsePreset(text, path, {std::filesystem::path(path).parent_path().string(), load});
}

std::shared_ptr<const Field> fieldOf(const Preset& preset, const GraphSettings& settings)
{
    return graphField(preset.surface, settings, preset.materials);
}

} // namespace isofront::fields::graph

#include "SceneRecord.h"

#include "../api/Message.h"

#include <isofront/volume/MeshLevelSet.h>

#include <cmath>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1; ///< of the file of a record
constexpr std::size_t kLongestText = 200;

const char* nameOf(SceneOrigin::Kind kind)
{
    switch (kind) {
    case SceneOrigin::Kind::procedural:
        return "procedural";
    case SceneOrigin::Kind::file:
        return "file";
    case SceneOrigin::Kind::upload:
        return "upload";
    }
    return "";
}

const char* nameOf(SceneRecord::State state)
{
    switch (state) {
    case SceneRecord::State::preparing:
        return "preparing";
    case SceneRecord::State::ready:
        return "ready";
    case SceneRecord::State::failed:
        return "failed";
    }
    return "";
}

Json toJson(const glm::dvec3& v)
{
    return {v.x, v.y, v.z};
}

glm::dvec3 vectorOf(const Json& json)
{
    return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json toJson(const SceneDescription& description)
{
    Json json;
    json["kind"] = description.kind;
    json["text"] = description.text;
    json["bounds"] = {toJson(description.bounds.low), toJson(description.bounds.high)};
    json["isovalue"] = description.isovalue;
    json["value_range"] = {description.values.low, description.values.high};
    json["histogram"] = description.values.counts;
    json["view"] = {
        {"eye", toJson(description.eye)},
        {"target", toJson(description.target)},
        {"up", toJson(description.up)}};
    json["terrain"] = description.isTerrain;
    json["memory_bytes"] = description.memoryBytes;
    json["notes"] = description.notes;
    return json;
}

SceneDescription descriptionOf(const Json& json)
{
    SceneDescription description;
    description.kind = json.at("kind").get<std::string>();
    description.text = json.at("text").get<std::string>();
    description.bounds = {vectorOf(json.at("bounds").at(0)), vectorOf(json.at("bounds").at(1))};
    description.isovalue = json.at("isovalue").get<double>();
    description.values.low = json.at("value_range").at(0).get<double>();
    description.values.high = json.at("value_range").at(1).get<double>();
    description.values.counts =
        json.at("histogram").get<std::array<std::uint64_t, Histogram::kBins>>();
    description.eye = vectorOf(json.at("view").at("eye"));
    description.target = vectorOf(json.at("view").at("target"));
    description.up = vectorOf(json.at("view").at("up"));
    description.isTerrain = json.at("terrain").get<bool>();
    description.memoryBytes = json.at("memory_bytes").get<std::uint64_t>();
    description.notes = json.at("notes").get<std::vector<std::string>>();
    return description;
}

core::Interval rangeOf(std::span<const float> values)
{
    core::Interval range{1, -1};
    for (const float value : values) {
        if (!std::isfinite(value))
            continue;
        if (range.low > range.high)
            range = {static_cast<double>(value), static_cast<double>(value)};
        range.low = std::min(range.low, static_cast<double>(value));
        range.high = std::max(range.high, static_cast<double>(value));
    }
    return range.low > range.high ? core::Interval{0, 0} : range;
}

Histogram sampled(const sources::Source& source)
{
    constexpr std::int64_t kPoints = 64;
    const core::Box box = source.field->dataBox().value_or(source.domain.fieldBox());
    const glm::dvec3 size = box.size();
    const double spacing = std::max({size.x, size.y, size.z}) / static_cast<double>(kPoints);
    fields::SampleGrid grid;
    grid.spacing = spacing > 0 ? spacing : 1;
    grid.origin = box.low;
    grid.radius = 0.5 * grid.spacing;
    for (glm::length_t axis = 0; axis < 3; ++axis)
        grid.count[axis] = std::clamp<std::int64_t>(
            static_cast<std::int64_t>(size[axis] / grid.spacing), 1, kPoints);
    std::vector<float> values(grid.size());
    source.field->sampleGrid(grid, values);
    if (source.negated)
        for (float& value : values)
            value = -value;
    const core::Interval range = rangeOf(values);
    Histogram histogram;
    histogram.low = range.low;
    histogram.high = range.high;
    const double scale = range.high > range.low
                             ? static_cast<double>(Histogram::kBins) / (range.high - range.low)
                             : 0;
    for (const float value : values)
        if (std::isfinite(value)) {
            const auto bin =
                static_cast<std::size_t>((static_cast<double>(value) - range.low) * scale);
            ++histogram.counts[std::min(bin, Histogram::kBins - 1)];
        }
    return histogram;
}

} // namespace

nlohmann::ordered_json toJson(const SceneRecord& record, bool isWhole)
{
    Json json;
    json["id"] = record.id;
    json["name"] = record.name;
    json["created"] = record.created;
    json["origin"] = nameOf(record.origin.kind);
    json["source"] = record.origin.text;
    json["state"] = nameOf(record.state);
    if (record.state == SceneRecord::State::failed)
        json["failure"] = record.failure;
    if (record.description && !isWhole)
        json["kind"] = record.description->kind;
    if (record.description && isWhole)
        json["description"] = toJson(*record.description);
    if (isWhole)
        json["options"] = optionsToJson(record.origin.options);
    json["stored_bytes"] = record.storedBytes;
    return json;
}

std::string toText(const SceneRecord& record)
{
    Json json = toJson(record, true);
    json["version"] = kVersion;
    json["attempts"] = record.attempts;
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

core::Result<SceneRecord> parseRecord(const std::string& text)
{
    try {
        const Json json = Json::parse(text);
        if (json.at("version") != kVersion)
            return core::failure(
                core::ErrorCode::badData, "written by another version of the service");
        SceneRecord record;
        record.id = json.at("id").get<std::string>();
        record.name = json.at("name").get<std::string>();
        record.created = json.at("created").get<std::string>();
        const auto origin = json.at("origin").get<std::string>();
        record.origin.kind = origin == "upload" ? SceneOrigin::Kind::upload
                             : origin == "file" ? SceneOrigin::Kind::file
                                                : SceneOrigin::Kind::procedural;
        record.origin.text = json.at("source").get<std::string>();
        auto options = parseOptions(json.at("options"));
        if (!options)
            return tl::unexpected(options.error());
        record.origin.options = std::move(*options);
        record.storedBytes = json.at("stored_bytes").get<std::uint64_t>();
        const auto state = json.at("state").get<std::string>();
        record.state = state == "ready"    ? SceneRecord::State::ready
                       : state == "failed" ? SceneRecord::State::failed
                                           : SceneRecord::State::preparing;
        record.failure = json.value("failure", "");
        record.attempts = json.at("attempts").get<std::uint32_t>();
        if (json.contains("description"))
            record.description = descriptionOf(json.at("description"));
        else if (record.state == SceneRecord::State::ready)
            record.state = SceneRecord::State::preparing;
        return record;
    } catch (const Json::exception& error) {
        return core::failure(
            core::ErrorCode::badData, std::string("not a record of a scene: ") + error.what());
    }
}

core::Result<sources::SourceOptions> parseOptions(const Json& json)
{
    sources::SourceOptions options;
    const auto refused = [](const std::string& name, const std::string& expected) {
        return core::failure(
            core::ErrorCode::usage, "options: '" + name + "' is to be " + expected);
    };
    if (!json.is_object())
        return core::failure(core::ErrorCode::usage, "options: not an object");
    const auto numbers = [](const Json& value, std::size_t count) {
        bool isGood = value.is_array() && value.size() == count;
        for (std::size_t i = 0; isGood && i < count; ++i)
            isGood = value[i].is_number() && value[i].get<double>() > 0;
        return isGood;
    };
    for (const auto& [name, value] : json.items()) {
        if (name == "grid" || name == "series" || name == "raw" || name == "detail") {
            if (!value.is_string() || value.get_ref<const std::string&>().size() > kLongestText ||
                !isPlainText(value.get_ref<const std::string&>()))
                return refused(name, "a text of up to 200 bytes without control characters");
            std::string& text = name == "grid"     ? options.grid
                                : name == "series" ? options.series
                                : name == "raw"    ? options.rawLayout
                                                   : options.detail;
            text = value.get<std::string>();
        } else if (name == "voxel_size") {
            if (!numbers(value, 3))
                return refused(name, "three positive numbers");
            options.voxelSize = vectorOf(value);
        } else if (name == "pixel_size") {
            if (!numbers(value, 2))
                return refused(name, "two positive numbers");
            options.pixelSize = {value[0].get<double>(), value[1].get<double>()};
        } else if (name == "height_scale" || name == "no_data") {
            if (!value.is_number())
                return refused(name, "a number");
            (name == "no_data" ? options.noData : options.heightScale) = value.get<double>();
        } else if (name == "mesh_resolution") {
            using volume::LevelSetOptions;
            const double number = value.is_number() ? value.get<double>() : 0;
            if (!(number >= LevelSetOptions::kLeastResolution) ||
                !(number <= LevelSetOptions::kMostResolution) || number != std::floor(number))
                return refused(
                    name,
                    "a whole number from " + std::to_string(LevelSetOptions::kLeastResolution) +
                        " to " + std::to_string(LevelSetOptions::kMostResolution));
            options.meshResolution = static_cast<int>(number);
        } else if (name == "mesh_reach") {
            if (!value.is_number() || !(value.get<double>() > 0))
                return refused(name, "a positive number");
            options.meshReach = value.get<double>();
        } else {
            return core::failure(
                core::ErrorCode::usage,
                "options: there is no '" + name +
                    "': there are grid, series, raw, detail, voxel_size, pixel_size, "
                    "height_scale, no_data, mesh_resolution, mesh_reach");
        }
    }
    return options;
}

Json optionsToJson(const sources::SourceOptions& options)
{
    Json json = Json::object();
    if (!options.grid.empty())
        json["grid"] = options.grid;
    if (!options.series.empty())
        json["series"] = options.series;
    if (!options.rawLayout.empty())
        json["raw"] = options.rawLayout;
    if (options.detail != "none")
        json["detail"] = options.detail;
    if (options.voxelSize)
        json["voxel_size"] = toJson(*options.voxelSize);
    if (options.pixelSize)
        json["pixel_size"] = {options.pixelSize->x, options.pixelSize->y};
    if (options.heightScale)
        json["height_scale"] = *options.heightScale;
    if (options.noData)
        json["no_data"] = *options.noData;
    if (options.meshResolution != sources::SourceOptions{}.meshResolution)
        json["mesh_resolution"] = options.meshResolution;
    if (options.meshReach)
        json["mesh_reach"] = *options.meshReach;
    return json;
}

SceneDescription describe(const sources::Source& source)
{
    SceneDescription description;
    const bool isMesh = source.volume && source.volume->info.format == volume::VolumeFormat::mesh;
    description.kind = isMesh             ? "mesh"
                       : source.volume    ? "volume"
                       : source.elevation ? "elevation"
                                          : "procedural";
    description.text = source.description;
    description.bounds = source.worldBox;
    description.isovalue = source.defaultIsovalue;
    if (source.volume) {
        const volume::ValueSummary& values = source.volume->info.values;
        description.values = {values.low, values.high, values.histogram};
        description.memoryBytes = source.volume->info.memoryBytes;
    } else {
        description.values = sampled(source);
        if (source.elevation)
            description.memoryBytes = source.elevation->info.memoryBytes;
    }
    description.eye = source.eye;
    description.target = source.target;
    description.up = source.up;
    description.isTerrain = source.isTerrain;
    description.notes = source.notes;
    return description;
}

} // namespace isofront::server

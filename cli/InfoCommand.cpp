#include "Arguments.h"
#include "Console.h"
#include "SourceArguments.h"

#include <isofront/fields/Procedural.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

namespace isofront::cli {

namespace {

using Json = nlohmann::ordered_json;

struct InfoArguments {
    std::string source;
    SourceArguments input;
    bool json = false;
    bool quiet = false;
};

Json vectorJson(const glm::dvec3& v)
{
    return {v.x, v.y, v.z};
}

Json proceduralJson(const fields::ProceduralDescription& source)
{
    Json json;
    json["name"] = source.name;
    json["description"] = source.description;
    json["parameters"] = Json::array();
    for (const auto& parameter : source.parameters) {
        Json p;
        p["name"] = parameter.name;
        p["description"] = parameter.description;
        p["default"] = parameter.defaultValue;
        if (!parameter.choices.empty())
            p["choices"] = parameter.choices;
        else
            p["range"] = {parameter.least, parameter.most};
        if (!parameter.fileSuffix.empty())
            p["fileSuffix"] = parameter.fileSuffix;
        json["parameters"].push_back(p);
    }
    return json;
}

int listProcedural(bool asJson)
{
    if (asJson) {
        Json json;
        json["procedural"] = Json::array();
        for (const auto& source : fields::proceduralSources())
            json["procedural"].push_back(proceduralJson(source));
        print(json);
        return 0;
    }
    for (const auto& source : fields::proceduralSources()) {
        std::printf("proc:%s - %s\n", source.name.c_str(), source.description.c_str());
        for (const auto& parameter : source.parameters) {
            std::string values;
            for (const std::string& choice : parameter.choices)
                values += (values.empty() ? "" : ", ") + choice;
            if (!parameter.fileSuffix.empty())
                values += ", or a " + parameter.fileSuffix + " file";
            if (values.empty()) {
                char range[96];
                std::snprintf(range, sizeof range, "%g to %g", parameter.least, parameter.most);
                values = range;
            }
            std::printf(
                "    %s=%s  %s (%s)\n",
                parameter.name.c_str(),
                parameter.defaultValue.c_str(),
                parameter.description.c_str(),
                values.c_str());
        }
    }
    return 0;
}

Json volumeJson(const volume::LoadedVolume& loaded)
{
    const volume::VolumeInfo& info = loaded.info;
    Json json;
    json["format"] = volume::nameOf(info.format);
    json["dimensions"] = {info.dimensions.x, info.dimensions.y, info.dimensions.z};
    json["voxel_type"] = volume::nameOf(info.voxelType);
    json["spacing"] = vectorJson(info.spacing);
    json["origin"] = vectorJson(info.origin);
    json["direction"] = {
        vectorJson(info.direction[0]),
        vectorJson(info.direction[1]),
        vectorJson(info.direction[2])};
    json["value_range"] = {info.values.low, info.values.high};
    json["non_finite_voxels"] = info.values.nonFiniteCount;
    json["suggested_isovalue"] = info.suggestedIsovalue;
    json["negated"] = loaded.negated;
    json["orientation"] = info.orientation;
    json["memory_bytes"] = info.memoryBytes;
    if (!info.gridNames.empty()) {
        json["grid"] = info.gridName;
        json["grids"] = info.gridNames;
    }
    json["histogram"] = info.values.histogram;
    json["notes"] = info.notes;
    return json;
}

void printVolume(const Source& source, const volume::LoadedVolume& loaded)
{
    const volume::VolumeInfo& info = loaded.info;
    const auto text = [](const glm::dvec3& v) {
        char buffer[128];
        std::snprintf(buffer, sizeof buffer, "%.6g %.6g %.6g", v.x, v.y, v.z);
        return std::string(buffer);
    };
    std::printf("%s: %s\n", source.name.c_str(), source.description.c_str());
    std::printf(
        "  voxels       %d x %d x %d %s\n",
        info.dimensions.x,
        info.dimensions.y,
        info.dimensions.z,
        std::string(volume::nameOf(info.voxelType)).c_str());
    std::printf("  spacing      %s\n", text(info.spacing).c_str());
    std::printf("  origin       %s\n", text(info.origin).c_str());
    std::printf(
        "  world box    %s to %s\n",
        text(source.worldBox.low).c_str(),
        text(source.worldBox.high).c_str());
    std::printf("  values       %.6g to %.6g\n", info.values.low, info.values.high);
    if (info.values.nonFiniteCount > 0)
        std::printf("  not finite   %s voxels\n", grouped(info.values.nonFiniteCount).c_str());
    std::printf("  isovalue     %.6g suggested\n", info.suggestedIsovalue);
    std::printf("  orientation  %s\n", info.orientation.c_str());
    if (!info.gridNames.empty()) {
        std::string names;
        for (const std::string& name : info.gridNames)
            names += (names.empty() ? "" : ", ") + name;
        std::printf("  grid         %s (of: %s)\n", info.gridName.c_str(), names.c_str());
    }
    std::printf("  in memory    %s bytes\n", grouped(info.memoryBytes).c_str());
    for (const std::string& note : info.notes)
        std::printf("  note         %s\n", note.c_str());
}

Json elevationJson(const elevation::LoadedElevation& loaded)
{
    const elevation::ElevationInfo& info = loaded.info;
    Json json;
    json["format"] = elevation::nameOf(info.format);
    json["posts"] = {info.columns, info.rows};
    json["sample_type"] = raster::nameOf(info.sampleType);
    json["spacing"] = {info.spacing.x, info.spacing.y};
    json["centre"] =
        info.centre
            ? Json{{"latitude", info.centre->latitude}, {"longitude", info.centre->longitude}}
            : Json(nullptr);
    json["height_range"] = {info.lowest, info.highest};
    json["summit"] = {info.summit.x, info.summit.y, info.highest};
    json["voids_filled"] = info.voids;
    json["orientation"] = info.orientation;
    json["memory_bytes"] = info.memoryBytes;
    json["notes"] = info.notes;
    return json;
}

void printElevation(const Source& source, const elevation::LoadedElevation& loaded)
{
    const elevation::ElevationInfo& info = loaded.info;
    const glm::dvec3 size = loaded.dataBox.size();
    std::printf("%s: %s\n", source.name.c_str(), source.description.c_str());
    std::printf(
        "  posts        %d x %d %s\n",
        info.columns,
        info.rows,
        std::string(raster::nameOf(info.sampleType)).c_str());
    std::printf("  spacing      %.6g %.6g m\n", info.spacing.x, info.spacing.y);
    std::printf("  extent       %.6g x %.6g m\n", size.x, size.y);
    if (info.centre)
        std::printf(
            "  centre       %.6f %s, %.6f %s\n",
            std::abs(info.centre->latitude),
            info.centre->latitude < 0 ? "S" : "N",
            std::abs(info.centre->longitude),
            info.centre->longitude < 0 ? "W" : "E");
    std::printf("  heights      %.6g to %.6g m\n", info.lowest, info.highest);
    std::printf("  summit       %.6g %.6g\n", info.summit.x, info.summit.y);
    std::printf("  voids        %s filled\n", grouped(info.voids).c_str());
    std::printf("  orientation  %s\n", info.orientation.c_str());
    std::printf("  in memory    %s bytes\n", grouped(info.memoryBytes).c_str());
    for (const std::string& note : info.notes)
        std::printf("  note         %s\n", note.c_str());
}

int info(const InfoArguments& arguments)
{
    if (arguments.source == "proc:")
        return listProcedural(arguments.json);
    const auto source = openSource(arguments.source, arguments.input, interruptions());
    if (!source)
        return report(source.error());

    if (arguments.json) {
        Json json;
        json["source"] = source->name;
        json["description"] = source->description;
        json["world_box"] = {
            {"min", vectorJson(source->worldBox.low)}, {"max", vectorJson(source->worldBox.high)}};
        if (source->volume)
            json["volume"] = volumeJson(*source->volume);
        else if (source->elevation)
            json["elevation"] = elevationJson(*source->elevation);
        else
            json["isovalue"] = source->defaultIsovalue;
        print(json);
        return 0;
    }
    if (source->volume) {
        printVolume(*source, *source->volume);
        return 0;
    }
    if (source->elevation) {
        printElevation(*source, *source->elevation);
        return 0;
    }
    std::printf("%s: %s\n", source->name.c_str(), source->description.c_str());
    std::printf(
        "  domain    %g %g %g, edge %g\n",
        source->domain.origin.x,
        source->domain.origin.y,
        source->domain.origin.z,
        source->domain.edge);
    std::printf("  isovalue  %g\n", source->defaultIsovalue);
    return 0;
}

} // namespace

Action addInfo(CLI::App& app)
{
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App* command = app.add_subcommand(
        "info", "Tell what a source holds; 'info proc:' lists procedural sources");
    addSource(*command, arguments->source)->required();
    addSourceArguments(*command, arguments->input);
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "as in the other commands; info is quiet");
    return [arguments] { return info(*arguments); };
}

} // namespace isofront::cli

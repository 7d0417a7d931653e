#include "Arguments.h"
#include "Console.h"
#include "ModelReports.h"
#include "RayQuery.h"
#include "SourceArguments.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/fields/Procedural.h>
#include <isofront/voxels/ChunkStore.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace isofront::cli {

namespace {

using Json = nlohmann::ordered_json;

struct InfoArguments {
    std::string source;
    SourceArguments input;
    bool check = false;
    std::string ray;            ///< empty: none
    std::uint32_t rayLevel = 0; ///< of detail
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

std::string textOf(const glm::dvec3& v)
{
    char buffer[128];
    std::snprintf(buffer, sizeof buffer, "%.6g %.6g %.6g", v.x, v.y, v.z);
    return buffer;
}

void printVolume(const Source& source, const volume::LoadedVolume& loaded)
{
    const volume::VolumeInfo& info = loaded.info;
    std::printf("%s: %s\n", source.name.c_str(), source.description.c_str());
    std::printf(
        "  voxels       %d x %d x %d %s\n",
        info.dimensions.x,
        info.dimensions.y,
        info.dimensions.z,
        std::string(volume::nameOf(info.voxelType)).c_str());
    std::printf("  spacing      %s\n", textOf(info.spacing).c_str());
    std::printf("  origin       %s\n", textOf(info.origin).c_str());
    std::printf(
        "  world box    %s to %s\n",
        textOf(source.worldBox.low).c_str(),
        textOf(source.worldBox.high).c_str());
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

int infoOfMesh(const InfoArguments& arguments)
{
    const auto options = sourceOptions(arguments.input, interruptions());
    if (!options)
        return report(options.error());
    const auto model = exchange::readModel(arguments.source, options->memoryLimit);
    if (!model)
        return report(model.error());
    const voxels::ModelReport found = voxels::inspect(*model);
    if (arguments.json) {
        Json json;
        json["source"] = arguments.source;
        json["description"] = "mesh";
        json["world_box"] = boxJson(found.bounds);
        json["mesh"] = meshJson(*model, found);
        print(json);
        return 0;
    }
    std::printf("%s: mesh\n", arguments.source.c_str());
    std::printf("  vertices     %s\n", grouped(model->positions.size()).c_str());
    std::printf("  triangles    %s\n", grouped(found.triangles).c_str());
    std::printf("  colours      %s\n", model->isColoured() ? "yes" : "none");
    if (!model->textures.empty())
        std::printf("  textures     %zu\n", model->textures.size());
    if (!found.bounds.isEmpty())
        std::printf(
            "  world box    %s to %s\n",
            textOf(found.bounds.low).c_str(),
            textOf(found.bounds.high).c_str());
    for (const std::vector<std::string>& notes : {model->notes, found.notes()})
        for (const std::string& note : notes)
            std::printf("  note         %s\n", note.c_str());
    return 0;
}

/// Sentences that name chunks which the directory has and the store hasn't; none if the directory
/// can't be read.
std::vector<std::string>
missingChunks(const voxels::ChunkStore& store, const std::vector<voxels::ChunkKey>& keys)
{
    std::vector<std::string> missing;
    const auto directory = store.directory();
    if (!directory)
        return missing;
    const std::set<voxels::ChunkKey> there(keys.begin(), keys.end());
    for (const voxels::ChunkEntry& entry : *directory)
        if (!there.contains(entry.key))
            missing.push_back(store.place() + ": " + nameOf(entry.key) + " is missing");
    return missing;
}

/// What reading all chunks of a model tells.
struct CheckedChunks {
    std::vector<std::uint64_t> voxels; ///< by level
    std::vector<std::string> damaged;  ///< in sentences that name them
};

CheckedChunks
checkChunks(const voxels::ChunkStore& store, const std::vector<voxels::ChunkKey>& keys)
{
    CheckedChunks checked;
    checked.voxels.resize(store.model().lattice.levels);
    const std::stop_token stop = interruptions();
    for (const voxels::ChunkKey& key : keys) {
        if (stop.stop_requested())
            break;
        const auto chunk = store.get(key);
        if (!chunk)
            checked.damaged.push_back(chunk.error().message);
        else if (*chunk && key.level < checked.voxels.size())
            checked.voxels[key.level] += (*chunk)->voxels.size();
    }
    const std::vector<std::string> missing = missingChunks(store, keys);
    checked.damaged.insert(checked.damaged.end(), missing.begin(), missing.end());
    const voxels::StoredModel& model = store.model();
    const std::uint64_t all =
        std::accumulate(checked.voxels.begin(), checked.voxels.end(), std::uint64_t{0});
    if (checked.damaged.empty() && (keys.size() != model.chunks || all != model.allVoxels))
        checked.damaged.push_back(
            "chunks are missing: there are " + std::to_string(keys.size()) + " with " +
            std::to_string(all) + " voxels, of " + std::to_string(model.chunks) + " with " +
            std::to_string(model.allVoxels));
    return checked;
}

int infoOfStore(const InfoArguments& arguments)
{
    const auto store = voxels::openAnyStore(arguments.source);
    if (!store)
        return report(store.error());
    const voxels::StoredModel& model = (*store)->model();
    const auto box = voxels::worldBox(**store);
    if (!box && !arguments.check)
        return report(box.error());
    const std::vector<voxels::ChunkKey> keys = (*store)->keys();
    std::vector<std::uint64_t> chunks(model.lattice.levels);
    for (const voxels::ChunkKey& key : keys)
        if (key.level < chunks.size())
            ++chunks[key.level];
    const std::size_t missing = missingChunks(**store, keys).size();
    CheckedChunks checked;
    if (arguments.check) {
        checked = checkChunks(**store, keys);
        if (interruptions().stop_requested())
            return report({core::ErrorCode::interrupted, "interrupted"});
    }
    voxels::Ray ray;
    std::optional<voxels::VoxelHit> hit;
    if (!arguments.ray.empty()) {
        const auto parsed = parseRay(arguments.ray);
        if (!parsed)
            return report(parsed.error());
        ray = *parsed;
        const auto cast = castRay(**store, ray, arguments.rayLevel);
        if (!cast)
            return report(cast.error());
        hit = *cast;
    }
    const std::uint64_t bytes = bytesOnDisk(arguments.source);
    const bool isFolder = std::filesystem::is_directory(arguments.source);

    if (arguments.json) {
        Json json;
        json["source"] = arguments.source;
        json["description"] = "voxel model";
        json["world_box"] = box ? boxJson(*box) : Json(nullptr);
        json["model"] = modelJson(model);
        json["model"]["format"] = isFolder ? "folder" : "lmdb";
        json["model"]["bytes"] = bytes;
        json["model"]["chunks_by_level"] = chunks;
        json["model"]["chunks_missing"] = missing;
        if (arguments.check) {
            json["model"]["voxels_by_level"] = checked.voxels;
            json["model"]["damaged"] = checked.damaged;
        }
        if (!arguments.ray.empty())
            json["hit"] = hitJson(hit, ray);
        print(json);
    } else {
        std::printf(
            "%s: voxel model in %s\n",
            arguments.source.c_str(),
            isFolder ? "a folder" : "an LMDB file");
        std::printf("  made from    %s\n", model.name.c_str());
        if (model.source)
            std::printf(
                "  source       %s, %s bytes\n",
                model.source->path.c_str(),
                grouped(model.source->bytes).c_str());
        std::printf(
            "  resolution   %u voxels of edge %.6g, %s\n",
            model.lattice.resolution,
            model.lattice.edge,
            model.separability == voxels::Separability::six ? "six-separating" : "conservative");
        if (box && !box->isEmpty())
            std::printf(
                "  world box    %s to %s\n", textOf(box->low).c_str(), textOf(box->high).c_str());
        std::printf("  colours      %s\n", model.coloured ? "yes" : "none");
        std::printf(
            "  voxels       %s, %s of all levels\n",
            grouped(model.voxels).c_str(),
            grouped(model.allVoxels).c_str());
        for (std::size_t level = 0; level < chunks.size(); ++level)
            std::printf(
                "  level %-2zu     %s chunks%s\n",
                level,
                grouped(chunks[level]).c_str(),
                arguments.check ? (", " + grouped(checked.voxels[level]) + " voxels").c_str() : "");
        std::printf("  on disk      %s bytes\n", grouped(bytes).c_str());
        if (missing > 0 && !arguments.check)
            std::printf(
                "  missing      %s chunk%s; coarser ones are shown there (--check names %s)\n",
                grouped(missing).c_str(),
                missing == 1 ? "" : "s",
                missing == 1 ? "it" : "them");
        if (!arguments.ray.empty())
            std::printf("  ray          %s\n", hitText(hit, ray).c_str());
        for (const std::string& damage : checked.damaged)
            std::printf("  damaged      %s\n", damage.c_str());
    }
    if (!checked.damaged.empty())
        return report(
            {core::ErrorCode::badData,
             checked.damaged.front() +
                 (checked.damaged.size() > 1
                      ? ", and " + std::to_string(checked.damaged.size() - 1) + " more"
                      : std::string()) +
                 "; voxelise it again"});
    return 0;
}

int info(const InfoArguments& arguments)
{
    if (arguments.source == "proc:")
        return listProcedural(arguments.json);
    const bool isStore = voxels::isStore(arguments.source);
    if (arguments.check && !isStore)
        return report(
            {core::ErrorCode::usage,
             "--check is for voxel models, and " + arguments.source + " is none"});
    if (!arguments.ray.empty() && !isStore)
        return report(
            {core::ErrorCode::usage,
             "--ray is for voxel models, and " + arguments.source + " is none"});
    if (isStore)
        return infoOfStore(arguments);
    if (exchange::isModelName(arguments.source))
        return infoOfMesh(arguments);
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
    CLI::Option* const source = addSource(*command, arguments->source)->required();
    source->description(
        source->get_description() + ";\nor a mesh: .glb .gltf .ply .obj .stl, gzipped or not; or a "
                                    "voxel model that 'voxelize' wrote");
    addSourceArguments(*command, arguments->input);
    command->add_flag(
        "--check", arguments->check, "read all chunks of a voxel model, and name damaged ones");
    CLI::Option* const ray = command->add_option(
        "--ray", arguments->ray, "X,Y,Z,DX,DY,DZ: the first voxel of a voxel model on this ray");
    command->add_option("--ray-level", arguments->rayLevel, "the level of detail that --ray meets")
        ->capture_default_str()
        ->needs(ray);
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "as in the other commands; info is quiet");
    return [arguments] { return info(*arguments); };
}

} // namespace isofront::cli

#include "isofront/sources/Source.h"

#include "GraphFiles.h"

#include <isofront/core/Hash.h>
#include <isofront/elevation/Landscape.h>
#include <isofront/exchange/ModelFile.h>
#include <isofront/fields/Procedural.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/volume/MeshLevelSet.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/TriangleModel.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

namespace isofront::sources {

namespace {

constexpr std::string_view kProcedural = "proc:";
/// Detail of a landscape goes on below its posts, down to a thousandth of their distance.
constexpr int kLevelsOfDetail = 30;

/// Looks at the front and a little down, from where a box fills the view. Scans lie with z up and
/// their front towards -y; level sets are models, which have y up and their front towards z.
void lookAt(Source& source, bool isModel)
{
    const glm::dvec3 centre = source.worldBox.centre();
    const double reach = 0.9 * glm::length(source.worldBox.size());
    source.target = centre;
    source.eye =
        centre +
        reach * glm::normalize(isModel ? glm::dvec3(0.45, 0.4, 1.0) : glm::dvec3(0.45, -1.0, 0.4));
    if (isModel)
        source.up = {0, 1, 0};
}

core::Box worldBoxOf(const core::Box& box, const core::Affine& map)
{
    core::Box world;
    for (unsigned corner = 0; corner < 8; ++corner)
        world.include(map.point(
            {(corner & 1U) != 0 ? box.high.x : box.low.x,
             (corner & 2U) != 0 ? box.high.y : box.low.y,
             (corner & 4U) != 0 ? box.high.z : box.low.z}));
    return world;
}

/// Of a file or folder, with or without a slash at its end.
std::string fileNameOf(const std::string& text)
{
    const std::filesystem::path path(text);
    return (path.has_filename() ? path : path.parent_path()).filename().string();
}

core::Result<Source> openProcedural(const std::string& text, const SourceOptions& options)
{
    const std::string spec = text.substr(kProcedural.size());
    const std::size_t question = spec.find('?');
    const std::string name = spec.substr(0, question);
    std::map<std::string, std::string> parameters;
    if (question != std::string::npos) {
        std::size_t begin = question + 1;
        while (begin <= spec.size()) {
            const std::size_t end = std::min(spec.find('&', begin), spec.size());
            const std::string pair = spec.substr(begin, end - begin);
            const std::size_t equals = pair.find('=');
            if (equals == std::string::npos || equals == 0)
                return core::failure(
                    core::ErrorCode::usage,
                    text + ": parameters are written ?key=value&key=value, not '" + pair + "'");
            if (!parameters.emplace(pair.substr(0, equals), pair.substr(equals + 1)).second)
                return core::failure(
                    core::ErrorCode::usage,
                    text + ": parameter '" + pair.substr(0, equals) + "' is given twice");
            begin = end + 1;
        }
    }
    auto made = fields::makeProcedural(
        name, parameters, graphFileLoader(options.memoryLimit, options.stop));
    if (!made)
        return tl::unexpected<core::Error>(made.error().within(text));

    Source source;
    source.name = text;
    source.identity = std::string(kProcedural) + name;
    for (const auto& [key, value] : made->parameters)
        source.identity +=
            (source.identity.find('?') == std::string::npos ? "?" : "&") + key + "=" + value;
    source.description = made->description;
    source.field = made->field;
    source.domain = {made->domain.low, made->domain.size().x};
    source.isProcedural = true;
    source.isTerrain = name == "terrain";
    source.terrainKind = parameters.contains("preset") ? parameters.at("preset") : "";
    source.defaultIsovalue = made->isovalue;
    source.worldBox = made->domain;
    source.eye = made->eye;
    source.target = made->target;
    return source;
}

/// A volume as a source, all but its identity and description.
Source sourceOf(const std::string& text, volume::LoadedVolume loaded, bool isModel)
{
    Source source;
    source.name = text;
    source.field = loaded.field;
    source.domain = {loaded.domainOrigin, loaded.domainEdge, loaded.worldFromIndex};
    source.defaultIsovalue = loaded.info.suggestedIsovalue;
    source.negated = loaded.negated;
    source.voxel = 1.0;
    source.worldBox = worldBoxOf(loaded.dataBox, loaded.worldFromIndex);
    lookAt(source, isModel);
    source.notes = loaded.info.notes;
    source.volume = std::move(loaded);
    return source;
}

core::Result<Source> openVolume(const std::string& text, const SourceOptions& options)
{
    auto loaded = volume::loadVolume(
        text,
        {.memoryLimit = options.memoryLimit,
         .gridName = options.grid,
         .series = options.series,
         .rawLayout = options.rawLayout,
         .voxelSize = options.voxelSize,
         .stop = options.stop});
    if (!loaded)
        return tl::unexpected<core::Error>(loaded.error());

    const bool isLevelSet = loaded->info.format == volume::VolumeFormat::vdb && loaded->negated;
    Source source = sourceOf(text, std::move(*loaded), isLevelSet);
    const volume::VolumeInfo& info = source.volume->info;
    source.identity = fileNameOf(text);
    if (!info.gridName.empty())
        source.identity += "?grid=" + info.gridName;
    source.description = std::string(volume::nameOf(info.format)) + " volume";
    return source;
}

core::Result<Source> openMesh(const std::string& text, const SourceOptions& options)
{
    const auto model = exchange::readModel(
        text,
        options.memoryLimit,
        options.readsOtherFiles ? exchange::OtherFiles::read : exchange::OtherFiles::ignore);
    if (!model)
        return tl::unexpected<core::Error>(model.error());
    const voxels::ModelReport report = voxels::inspect(*model);
    volume::LevelSetOptions levelSet{
        .resolution = options.meshResolution,
        .reach = options.meshReach,
        .isSolid = report.openEdges == 0,
        .memoryLimit = options.memoryLimit,
        .stop = options.stop};
    auto loaded = volume::levelSetOf({model->positions, model->triangles}, levelSet);
    if (!loaded)
        return tl::unexpected<core::Error>(loaded.error().within(text));

    Source source = sourceOf(text, std::move(*loaded), true);
    source.identity = fileNameOf(text) + "?resolution=" + std::to_string(options.meshResolution);
    source.description = "distance from a mesh";
    const auto note = [&](std::uint64_t count, const char* what) {
        if (count > 0)
            source.notes.push_back(std::to_string(count) + " " + what);
    };
    note(report.outOfRange, "triangles name positions that are not there, and are left out");
    note(report.notFinite, "triangles have corners that are not finite numbers, and are left out");
    note(
        report.openEdges,
        "edges belong to one triangle only, so the mesh encloses nothing: a shell of three voxels "
        "around its triangles is solid");
    source.notes.insert(source.notes.begin(), model->notes.begin(), model->notes.end());
    return source;
}

/// Looks at the summit from the side where there is more ground.
void lookAtSummit(Source& source, const elevation::LoadedElevation& loaded)
{
    const elevation::ElevationInfo& info = loaded.info;
    const glm::dvec3 size = loaded.dataBox.size();
    const double away = std::min(0.35 * std::min(size.x, size.y), 7000.0);
    glm::dvec2 towards = -info.summit; // the raster's middle
    if (glm::length(towards) < 0.1 * away)
        towards = {0.6, -0.8};
    const glm::dvec2 place = info.summit + away * glm::normalize(towards);
    source.target = {info.summit, info.highest - 0.05 * away};
    source.eye = {place, info.highest + 0.15 * away};
}

core::Result<Source> openElevation(const std::string& text, const SourceOptions& options)
{
    auto loaded = elevation::loadElevation(
        text,
        {.memoryLimit = options.memoryLimit,
         .pixelSize = options.pixelSize,
         .heightScale = options.heightScale,
         .noData = options.noData,
         .stop = options.stop});
    if (!loaded)
        return tl::unexpected<core::Error>(loaded.error());

    Source source;
    source.name = text;
    source.identity = fileNameOf(text) + "?detail=" + options.detail;
    source.description = std::string(elevation::nameOf(loaded->info.format)) + " elevation raster";
    source.field = loaded->field;
    if (options.detail != "none") {
        auto detailed = elevation::landscape(*loaded, {.preset = options.detail});
        if (!detailed)
            return tl::unexpected<core::Error>(detailed.error().within("--detail"));
        source.field = std::move(*detailed);
        source.levelsBelowVoxel = kLevelsOfDetail;
    }
    source.isTerrain = true;
    source.voxel = std::min(loaded->info.spacing.x, loaded->info.spacing.y);
    source.worldBox = loaded->dataBox;
    // A power of two of posts, so that a lattice step can be just the distance of two posts.
    const glm::dvec3 size = loaded->dataBox.size();
    double edge = 2 * *source.voxel;
    while (edge < std::max({size.x, size.y, size.z}))
        edge *= 2;
    source.domain = {loaded->dataBox.centre() - 0.5 * edge, edge};
    lookAtSummit(source, *loaded);
    source.notes = loaded->info.notes;
    source.elevation = std::move(*loaded);
    return source;
}

} // namespace

std::uint64_t checksumOf(const Source& source)
{
    constexpr std::size_t kPlaces = 12; // along each axis
    const core::Box box = source.volume ? source.volume->dataBox : source.worldBox;
    std::vector<double> x;
    std::vector<double> y;
    std::vector<double> z;
    for (std::size_t i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
        // off the middle, where shapes are alike
        const glm::dvec3 at =
            (glm::dvec3(i % kPlaces, i / kPlaces % kPlaces, i / (kPlaces * kPlaces)) + 0.375) /
            double{kPlaces};
        const glm::dvec3 place = box.low + at * box.size();
        x.push_back(place.x);
        y.push_back(place.y);
        z.push_back(place.z);
    }
    std::vector<float> values(x.size());
    source.field->sample({x, y, z}, values);
    std::uint64_t hash = 0;
    for (const float value : values)
        hash =
            core::hashCombined(hash, std::isnan(value) ? 1 : std::bit_cast<std::uint32_t>(value));
    const core::Affine& map = source.domain.worldFromField;
    for (const glm::dvec3& vector :
         {box.low, box.high, map.linear[0], map.linear[1], map.linear[2], map.translation})
        for (glm::length_t axis = 0; axis < 3; ++axis)
            hash = core::hashCombined(hash, std::bit_cast<std::uint64_t>(vector[axis]));
    return hash;
}

int levelForStep(double share, int latticeSize)
{
    int level = 0;
    while (level < hierarchy::kMaxLevel - 2 &&
           hierarchy::axisStep(level, latticeSize) > share * (1 + 1e-9))
        level += 3;
    return level;
}

core::Result<Source> openSource(const std::string& text, const SourceOptions& options)
{
    if (text.empty())
        return core::failure(
            core::ErrorCode::usage, "SOURCE is empty: give a volume file or proc:NAME");
    if (text.starts_with(kProcedural))
        return openProcedural(text, options);
    std::error_code ignored;
    if (!std::filesystem::exists(text, ignored))
        return core::failure(
            core::ErrorCode::inputOutput, text + ": there is no such file; check the path");
    if (exchange::isModelName(text))
        return openMesh(text, options);
    if (voxels::isStore(text))
        return core::failure(
            core::ErrorCode::usage,
            text + ": only 'isofront render', 'fly' and 'info' take a model of voxels");
    if (elevation::isElevationName(text) && !volume::isVolume(text))
        return openElevation(text, options);
    return openVolume(text, options);
}

} // namespace isofront::sources

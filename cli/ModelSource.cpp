#include "ModelSource.h"

#include "Console.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/voxels/ModelSource.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <stop_token>
#include <utility>

namespace isofront::cli {

void SourceChoice::addTo(CLI::App& command)
{
    CLI::Option* const from = command.add_option(
        kSourceOption,
        file,
        "voxel models: the mesh file that it was made from, if it isn't where it was");
    command
        .add_flag(
            kNoSourceOption,
            isOff,
            "voxel models: show voxels even where they are too large, not the mesh")
        ->excludes(from);
}

core::Result<ShownSource> sourceOf(
    const ShownModel& model,
    const std::filesystem::path& path,
    const SourceChoice& choice,
    std::uint64_t memoryLimit)
{
    const auto& kept = model.store->model().source;
    if (!kept && !choice.file.empty())
        return core::failure(
            core::ErrorCode::usage,
            "--source " + choice.file + ": " + path.string() +
                " doesn't know what it was made from; voxelise the mesh again");
    if (!kept || choice.isOff)
        return ShownSource();
    ShownSource source;
    source.file = choice.file.empty() ? voxels::placeOfSource(*kept, path)
                                      : std::filesystem::path(choice.file);
    // what was named must be it; what lies where it was is only hoped for
    if (!choice.file.empty())
        if (const auto sound = voxels::checkSource(*kept, source.file); !sound)
            return core::failure(sound.error().code, "--source " + sound.error().message);
    source.read = [kept = *kept, file = source.file, memoryLimit](
                      const std::stop_token& stop) -> core::Result<voxels::TriangleModel> {
        if (const auto sound = voxels::checkSource(kept, file, stop); !sound)
            return tl::unexpected(sound.error());
        return exchange::readModel(file, memoryLimit);
    };
    return source;
}

bool needsSource(const ShownModel& model, const hierarchy::View& view, double voxelPixels)
{
    const glm::dvec3 nearest = glm::clamp(view.eye, model.box.low, model.box.high);
    const double edge = model.store->model().lattice.edge;
    return edge * view.pixelsPerUnit() > voxelPixels * glm::distance(nearest, view.eye);
}

std::string sourceNote(const render::HybridFrame& frame)
{
    if (frame.sourceError)
        return "note: " + frame.sourceError->message +
               "; voxels are shown in its place, as large as they are (see " +
               (frame.sourceError->code == core::ErrorCode::resourceLimit ? "--memory-limit"
                                                                          : kSourceOption) +
               ")";
    if (frame.sourceIsFull)
        return "note: the device's memory for meshes holds " + grouped(frame.sourceBytes >> 20U) +
               " MiB of the source; the rest is shown as voxels";
    return {};
}

nlohmann::ordered_json sourceJson(const ShownSource& source, const render::HybridFrame& frame)
{
    if (!source.read)
        return nullptr;
    nlohmann::ordered_json json;
    json["file"] = source.file.string();
    json["triangles_drawn"] = frame.drawn.triangles;
    json["bytes"] = frame.sourceBytes;
    json["host_bytes"] = frame.sourceHostBytes;
    json["is_full"] = frame.sourceIsFull;
    json["error"] =
        frame.sourceError ? nlohmann::ordered_json(frame.sourceError->message) : nullptr;
    return json;
}

} // namespace isofront::cli

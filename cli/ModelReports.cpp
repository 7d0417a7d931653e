#include "ModelReports.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

namespace isofront::cli {

using Json = nlohmann::ordered_json;

Json boxJson(const core::Box& box)
{
    if (box.isEmpty())
        return nullptr;
    return {
        {"min", {box.low.x, box.low.y, box.low.z}}, {"max", {box.high.x, box.high.y, box.high.z}}};
}

Json meshJson(const voxels::TriangleModel& model, const voxels::ModelReport& report)
{
    Json json;
    json["vertices"] = model.positions.size();
    json["triangles"] = report.triangles;
    json["coloured"] = model.isColoured();
    json["textures"] = model.textures.size();
    json["out_of_range"] = report.outOfRange;
    json["not_finite"] = report.notFinite;
    json["degenerate"] = report.degenerate;
    json["open_edges"] = report.openEdges;
    json["non_manifold_edges"] = report.nonManifoldEdges;
    json["turned_edges"] = report.turnedEdges;
    std::vector<std::string> notes = model.notes;
    std::ranges::copy(report.notes(), std::back_inserter(notes));
    json["notes"] = notes;
    return json;
}

Json modelJson(const voxels::StoredModel& model)
{
    const voxels::VoxelLattice& lattice = model.lattice;
    Json json;
    json["name"] = model.name;
    json["resolution"] = lattice.resolution;
    json["levels"] = lattice.levels;
    json["voxel_edge"] = lattice.edge;
    json["origin"] = {lattice.origin.x, lattice.origin.y, lattice.origin.z};
    json["voxels"] = model.voxels;
    json["all_voxels"] = model.allVoxels;
    json["chunks"] = model.chunks;
    json["coloured"] = model.coloured;
    json["separability"] = model.separability == voxels::Separability::six ? "six" : "conservative";
    if (model.source)
        json["source"] = {{"path", model.source->path}, {"bytes", model.source->bytes}};
    if (model.field)
        json["field"] = {
            {"source", model.field->source},
            {"isovalue", model.field->isovalue},
            {"filter", model.field->filter},
            {"closed", model.field->closed}};
    return json;
}

std::uint64_t bytesOnDisk(const std::filesystem::path& path)
{
    std::error_code failed;
    if (!std::filesystem::is_directory(path, failed)) {
        const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
        return failed ? 0 : bytes;
    }
    std::uint64_t sum = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path, failed))
        if (entry.is_regular_file(failed))
            sum += entry.file_size(failed);
    return sum;
}

} // namespace isofront::cli

#include "report/FlightReport.h"

#include <isofront/exchange/OutputFile.h>

#include <nlohmann/json.hpp>

#include <cmath>

namespace isofront::cli {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no word for NaN and infinity.
Json number(double value)
{
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json spreadJson(const Spread& spread)
{
    return {
        {"mean", number(spread.mean)},
        {"p50", number(spread.p50)},
        {"p95", number(spread.p95)},
        {"p99", number(spread.p99)},
        {"max", number(spread.max)}};
}

Json namedJson(const std::vector<std::pair<std::string, std::string>>& pairs)
{
    Json json = Json::object();
    for (const auto& [key, value] : pairs)
        json[key] = value;
    return json;
}

Json settingsJson(const FlightSettings& settings)
{
    return {
        {"source", settings.source},
        {"preset", settings.preset},
        {"seed", settings.seed},
        {"width", settings.width},
        {"height", settings.height},
        {"pixel_error", number(settings.pixelError)},
        {"device", settings.device},
        {"threads", settings.threads},
        {"versions", namedJson(settings.versions)},
        {"others", namedJson(settings.others)}};
}

Json summaryJson(const FlightSummary& summary, std::size_t frames)
{
    return {
        {"frames", frames},
        {"seconds", number(summary.seconds)},
        {"cpu_ms", spreadJson(summary.cpuMilliseconds)},
        {"gpu_ms", spreadJson(summary.gpuMilliseconds)},
        {"update_ms", spreadJson(summary.updateMilliseconds)},
        {"largest_pop", spreadJson(summary.largestPop)},
        {"mean_pop", spreadJson(summary.meanPop)},
        {"triangles_mean", number(summary.meanTriangles)},
        {"triangles_max", summary.maxTriangles},
        {"draws_max", summary.maxDraws},
        {"shown_cells_max", summary.maxShownCells},
        {"cells_pending_max", summary.maxCellsPending},
        {"effective_pixel_error_max", number(summary.maxEffectivePixelError)},
        {"cells_extracted", summary.cellsExtracted},
        {"cells_skipped", summary.cellsSkipped},
        {"cells_from_cache", summary.cellsFromCache},
        {"uploaded_bytes", summary.uploadedBytes},
        {"uploaded_bytes_max", summary.maxUploadedBytes},
        {"mesh_bytes_max", summary.maxMeshBytes},
        {"cache_bytes_max", summary.maxCacheBytes},
        {"fading_bytes_max", summary.maxFadingBytes},
        {"device_bytes_max", summary.maxDeviceBytes},
        {"resident_bytes_max", summary.maxResidentBytes},
        {"effective_voxel_pixels_max", number(summary.maxEffectiveVoxelPixels)},
        {"voxels_mean", number(summary.meanVoxels)},
        {"voxels_max", summary.maxVoxels},
        {"missing_chunks_max", summary.maxMissingChunks},
        {"voxel_bytes_max", summary.maxVoxelBytes},
        {"source_bytes_max", summary.maxSourceBytes},
        {"source_host_bytes_max", summary.maxSourceHostBytes}};
}

Json frameJson(const FrameRecord& frame)
{
    return {
        {"time", number(frame.time)},
        {"cpu_ms", number(frame.cpuMilliseconds)},
        {"gpu_ms", number(frame.gpuMilliseconds)},
        {"update_ms", number(frame.updateMilliseconds)},
        {"triangles", frame.triangles},
        {"draws", frame.draws},
        {"shown_cells", frame.shownCells},
        {"cells_extracted", frame.cellsExtracted},
        {"cells_skipped", frame.cellsSkipped},
        {"cells_from_cache", frame.cellsFromCache},
        {"cells_pending", frame.cellsPending},
        {"cells_fading", frame.cellsFading},
        {"effective_pixel_error", number(frame.effectivePixelError)},
        {"uploaded_bytes", frame.uploadedBytes},
        {"mesh_bytes", frame.meshBytes},
        {"cache_bytes", frame.cacheBytes},
        {"fading_bytes", frame.fadingBytes},
        {"device_bytes", frame.deviceBytes},
        {"resident_bytes", frame.residentBytes},
        {"largest_pop", number(frame.largestPop)},
        {"mean_pop", number(frame.meanPop)},
        {"effective_voxel_pixels", number(frame.effectiveVoxelPixels)},
        {"voxels", frame.voxels},
        {"voxel_chunks", frame.voxelChunks},
        {"missing_chunks", frame.missingChunks},
        {"voxel_bytes", frame.voxelBytes},
        {"source_bytes", frame.sourceBytes},
        {"source_host_bytes", frame.sourceHostBytes},
        {"mesh_blocks", frame.meshBlocks},
        {"voxel_blocks", frame.voxelBlocks},
        {"eye", {number(frame.eye.x), number(frame.eye.y), number(frame.eye.z)}}};
}

std::string text(const Json& json, int indent)
{
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

} // namespace

core::Result<std::uint64_t>
writeReportJson(const FlightReport& report, const std::filesystem::path& path)
{
    core::Result<exchange::OutputFile> file = exchange::OutputFile::create(path);
    if (!file)
        return tl::unexpected(file.error());
    // One line a frame: as easy to look through as to parse, and never all in memory.
    file->write("{\n\"format\": \"isofront.flight\",\n\"version\": 1,\n\"settings\": ");
    file->write(text(settingsJson(report.settings), 1));
    file->write(",\n\"summary\": ");
    file->write(text(summaryJson(summarised(report.frames), report.frames.size()), 1));
    file->write(",\n\"frames\": [");
    for (std::size_t i = 0; i < report.frames.size(); ++i) {
        file->write(i == 0 ? "\n" : ",\n");
        file->write(text(frameJson(report.frames[i]), -1));
    }
    file->write("\n]\n}\n");
    return file->commit();
}

} // namespace isofront::cli

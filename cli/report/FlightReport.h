#pragma once

#include <isofront/core/Result.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace isofront::cli {

/// What one frame of a flight cost and showed. A time that was not measured is NaN.
struct FrameRecord {
    double time = 0;               ///< [s] since the flight began
    double cpuMilliseconds = 0;    ///< the whole frame on the processor
    double gpuMilliseconds = 0;    ///< the whole frame on the device, by its timestamps
    double updateMilliseconds = 0; ///< of `cpuMilliseconds`: the surface's update

    std::uint64_t triangles = 0;      ///< drawn
    std::uint64_t draws = 0;          ///< draw commands
    std::uint64_t shownCells = 0;     ///< cells with triangles, in view or not
    std::uint64_t cellsExtracted = 0; ///< since the frame before: sampled and contoured
    std::uint64_t cellsSkipped = 0;   ///< since the frame before: proved empty, never sampled
    std::uint64_t cellsFromCache = 0; ///< since the frame before
    std::uint64_t cellsPending = 0;   ///< wanted, and not there yet
    std::uint64_t cellsFading = 0;    ///< drawn in some of the pixels that they cover only

    // Where voxels show all, or the distance; otherwise 0:
    std::uint64_t voxels = 0;        ///< in the chunks drawn, whole or in part
    std::uint64_t voxelChunks = 0;   ///< drawn
    std::uint64_t missingChunks = 0; ///< that the view needs, and that aren't there yet
    std::uint64_t voxelBytes = 0;    ///< of the chunks on the device
    std::uint64_t meshBlocks = 0;    ///< parts of space with a surface that meshes show ...
    std::uint64_t voxelBlocks = 0;   ///< ... and that voxels show

    // Where a model's source, the mesh that it was made from, is shown close up; otherwise 0:
    std::uint64_t sourceBytes = 0;     ///< of its triangles on the device
    std::uint64_t sourceHostBytes = 0; ///< and on the host, nearly

    /// What the ceilings of the surface left of the error asked for [px]; 0 if nobody told.
    double effectivePixelError = 0;
    /// What the nearest voxels may cover, as far as their cache lets them be so small [px]; 0
    /// without voxels.
    double effectiveVoxelPixels = 0;

    std::uint64_t uploadedBytes = 0; ///< to the device, for this frame
    std::uint64_t meshBytes = 0;     ///< of the shown cells' meshes, or of a model's source
    std::uint64_t cacheBytes = 0;    ///< of meshes kept for later
    std::uint64_t fadingBytes = 0;   ///< of meshes that are shown no longer, but for those fading
    std::uint64_t deviceBytes = 0;   ///< allocated on the device
    std::uint64_t residentBytes = 0; ///< of the process

    /// How much of the picture changed without a movement of the camera; see Popping.
    double largestPop = std::numeric_limits<double>::quiet_NaN();
    double meanPop = std::numeric_limits<double>::quiet_NaN();

    glm::dvec3 eye{0.0}; ///< [world]
};

/// What was flown, and with what.
struct FlightSettings {
    std::string source;
    std::string preset;
    std::uint64_t seed = 0;
    int width = 0;         ///< [px]
    int height = 0;        ///< [px]
    double pixelError = 0; ///< [px]; NaN for a flight without meshes
    std::string device;
    int threads = 0;
    /// Names and versions of what took part: Isofront, the driver, ...
    std::vector<std::pair<std::string, std::string>> versions;
    /// Whatever else decides the numbers.
    std::vector<std::pair<std::string, std::string>> others;
};

struct FlightReport {
    FlightSettings settings;
    std::vector<FrameRecord> frames; ///< in order of time
    /// Files to show in the page, by their path relative to it; empty or missing ones are left out.
    std::filesystem::path video;
    std::filesystem::path contactSheet;
};

/// How a quantity is spread over the frames. Percentiles are by nearest rank: the least value that
/// so many percent of the values don't exceed. All NaN if nothing was measured.
struct Spread {
    double mean = 0, p50 = 0, p95 = 0, p99 = 0, max = 0;
};

/// Of the finite values alone.
Spread spreadOf(std::span<const double> values);

struct FlightSummary {
    Spread cpuMilliseconds, gpuMilliseconds, updateMilliseconds;
    Spread largestPop, meanPop;
    double seconds = 0; ///< from the first frame to the last
    double meanTriangles = 0;
    double maxEffectivePixelError = 0; ///< [px]
    double meanVoxels = 0;
    double maxEffectiveVoxelPixels = 0; ///< [px]
    std::uint64_t maxVoxels = 0, maxMissingChunks = 0, maxVoxelBytes = 0;
    std::uint64_t maxTriangles = 0, maxDraws = 0, maxShownCells = 0, maxCellsPending = 0;
    std::uint64_t cellsExtracted = 0, cellsSkipped = 0, cellsFromCache = 0; ///< in all
    std::uint64_t uploadedBytes = 0;                                        ///< in all
    std::uint64_t maxUploadedBytes = 0;                                     ///< in a frame
    std::uint64_t maxMeshBytes = 0, maxCacheBytes = 0, maxDeviceBytes = 0, maxResidentBytes = 0,
                  maxFadingBytes = 0, maxSourceBytes = 0, maxSourceHostBytes = 0;
};

FlightSummary summarised(std::span<const FrameRecord> frames);

/// Writes report.json, whole or not at all; docs/report-json.md describes it.
/// @return its length [bytes], or an `inputOutput` failure
core::Result<std::uint64_t>
writeReportJson(const FlightReport& report, const std::filesystem::path& path);

/// Writes report.html, whole or not at all: one page with charts, without scripts, that asks the
/// network for nothing. All text is escaped.
/// @return its length [bytes], or an `inputOutput` failure
core::Result<std::uint64_t>
writeReportHtml(const FlightReport& report, const std::filesystem::path& path);

} // namespace isofront::cli

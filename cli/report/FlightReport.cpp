#include "report/FlightReport.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

namespace isofront::cli {

Spread spreadOf(std::span<const double> values)
{
    std::vector<double> sorted;
    sorted.reserve(values.size());
    std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double value) {
        return std::isfinite(value);
    });
    if (sorted.empty()) {
        constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
        return {kNan, kNan, kNan, kNan, kNan};
    }
    std::sort(sorted.begin(), sorted.end());
    const auto percentile = [&sorted](std::size_t percent) {
        const std::size_t rank = (percent * sorted.size() + 99) / 100; // rounded up, from 1
        return sorted[rank - 1];
    };
    double sum = 0;
    for (const double value : sorted)
        sum += value;
    return {
        sum / static_cast<double>(sorted.size()),
        percentile(50),
        percentile(95),
        percentile(99),
        sorted.back()};
}

FlightSummary summarised(std::span<const FrameRecord> frames)
{
    FlightSummary summary;
    const auto spread = [&frames](double FrameRecord::*member) {
        std::vector<double> values;
        values.reserve(frames.size());
        for (const FrameRecord& frame : frames)
            values.push_back(frame.*member);
        return spreadOf(values);
    };
    summary.cpuMilliseconds = spread(&FrameRecord::cpuMilliseconds);
    summary.gpuMilliseconds = spread(&FrameRecord::gpuMilliseconds);
    summary.updateMilliseconds = spread(&FrameRecord::updateMilliseconds);
    summary.largestPop = spread(&FrameRecord::largestPop);
    summary.meanPop = spread(&FrameRecord::meanPop);
    if (frames.empty())
        return summary;

    summary.seconds = frames.back().time - frames.front().time;
    double triangles = 0;
    double voxels = 0;
    for (const FrameRecord& frame : frames) {
        triangles += static_cast<double>(frame.triangles);
        voxels += static_cast<double>(frame.voxels);
        summary.maxVoxels = std::max(summary.maxVoxels, frame.voxels);
        summary.maxMissingChunks = std::max(summary.maxMissingChunks, frame.missingChunks);
        summary.maxVoxelBytes = std::max(summary.maxVoxelBytes, frame.voxelBytes);
        summary.maxTriangles = std::max(summary.maxTriangles, frame.triangles);
        summary.maxDraws = std::max(summary.maxDraws, frame.draws);
        summary.maxShownCells = std::max(summary.maxShownCells, frame.shownCells);
        summary.maxEffectivePixelError =
            std::max(summary.maxEffectivePixelError, frame.effectivePixelError);
        summary.maxEffectiveVoxelPixels =
            std::max(summary.maxEffectiveVoxelPixels, frame.effectiveVoxelPixels);
        summary.maxCellsPending = std::max(summary.maxCellsPending, frame.cellsPending);
        summary.cellsExtracted += frame.cellsExtracted;
        summary.cellsSkipped += frame.cellsSkipped;
        summary.cellsFromCache += frame.cellsFromCache;
        summary.uploadedBytes += frame.uploadedBytes;
        summary.maxUploadedBytes = std::max(summary.maxUploadedBytes, frame.uploadedBytes);
        summary.maxMeshBytes = std::max(summary.maxMeshBytes, frame.meshBytes);
        summary.maxCacheBytes = std::max(summary.maxCacheBytes, frame.cacheBytes);
        summary.maxFadingBytes = std::max(summary.maxFadingBytes, frame.fadingBytes);
        summary.maxSourceBytes = std::max(summary.maxSourceBytes, frame.sourceBytes);
        summary.maxSourceHostBytes = std::max(summary.maxSourceHostBytes, frame.sourceHostBytes);
        summary.maxDeviceBytes = std::max(summary.maxDeviceBytes, frame.deviceBytes);
        summary.maxResidentBytes = std::max(summary.maxResidentBytes, frame.residentBytes);
    }
    summary.meanTriangles = triangles / static_cast<double>(frames.size());
    summary.meanVoxels = voxels / static_cast<double>(frames.size());
    return summary;
}

} // namespace isofront::cli

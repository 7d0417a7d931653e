#pragma once

#include "Console.h"
#include "FlyArguments.h"
#include "Pictures.h"
#include "report/FlightReport.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/HybridScene.h>
#include <isofront/surface/Surface.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

namespace isofront::cli {

inline constexpr double kFramesPerSecond = 30; ///< of a flight

/// What is flown past, ready to be shown, and the way that leads past it.
struct FlightStage {
    Studio studio;
    std::shared_ptr<core::Jobs> jobs;
    std::unique_ptr<surface::Surface> surface; ///< null for a model of voxels
    std::optional<render::HybridScene> scene;  ///< with a value
    std::vector<hierarchy::View> views;        ///< one for each frame
    /// The mesh that a model was made from, where it is to be shown.
    std::optional<std::filesystem::path> sourceFile;
    double voxelPixels = 0; ///< of the largest voxel, as it was asked for [px]; 0 without voxels
    std::uint64_t cacheBytes = 0; ///< for voxels on the device
    FlightSettings settings;      ///< for the report
};

/// Sets the stage for a flight: of a field, with or without voxels in the distance, or of a stored
/// model of voxels alone. What the user should know of it is said to `progress`.
/// Errors: usage for options that make no sense or would change nothing, and all that opening and
/// voxelising say; interrupted.
core::Result<FlightStage>
stageOf(const FlyArguments& arguments, Progress& progress, const std::stop_token& stop);

} // namespace isofront::cli

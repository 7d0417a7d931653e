#pragma once

#include "ModelView.h"
#include "SourceArguments.h"

#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>

#include <cstddef>
#include <vector>

namespace isofront::cli {

struct FlightPlan {
    std::size_t frames = 240;
    double framesPerSecond = 30;
    double speed = 0; ///< [world/s]; 0 chooses one that suits the source
    double fovDegrees = 60;
    int width = 1280; ///< [px]
    int height = 720; ///< [px]
};

/// A view for each frame: over a terrain, a curve that keeps clear of the ground; around anything
/// else, an orbit. Depends on the source and the plan alone.
std::vector<hierarchy::View> flightPath(const Source& source, const FlightPlan& plan);
/// The same for a model of voxels: over one of a terrain, around all else.
/// @return as VoxelRayCaster::create
core::Result<std::vector<hierarchy::View>>
flightPath(const ShownModel& model, const FlightPlan& plan);

} // namespace isofront::cli

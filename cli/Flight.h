#pragma once

#include "SourceArguments.h"

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

} // namespace isofront::cli

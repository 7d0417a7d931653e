#pragma once

#include "../scenes/SceneRegistry.h"
#include "Route.h"

#include <isofront/core/Jobs.h>

namespace isofront::server {

/// Points of a scene's surface: where rays meet it, and how high it is.
Api raysApi(SceneRegistry& scenes, core::Jobs& jobs);

} // namespace isofront::server

#pragma once

#include "../scenes/SceneRegistry.h"
#include "Route.h"

#include <isofront/server/Settings.h>

namespace isofront::server {

/// Scenes, and what they can be made of: `/v1/scenes`, `/v1/uploads`, `/v1/files`, `/v1/formulas`.
Api scenesApi(SceneRegistry& scenes, const Settings& settings);

} // namespace isofront::server

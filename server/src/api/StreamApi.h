#pragma once

#include "../scenes/SceneRegistry.h"
#include "../stream/StreamHub.h"
#include "Route.h"

namespace isofront::server {

/// A scene as a client sees it change: the WebSocket `/v1/scenes/{id}/stream`.
Api streamApi(SceneRegistry& scenes, StreamHub& hub);

} // namespace isofront::server

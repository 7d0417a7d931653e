#pragma once

#include "../scenes/SceneRegistry.h"
#include "Message.h"

#include <memory>
#include <string>

namespace isofront::server {

/// A scene with its field, or the answer to who asks for one that can't be had.
tl::expected<std::shared_ptr<const OpenScene>, Response>
readyScene(SceneRegistry& scenes, const std::string& id);

} // namespace isofront::server

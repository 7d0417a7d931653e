#include "ReadyScene.h"

#include <utility>

namespace isofront::server {

tl::expected<std::shared_ptr<const OpenScene>, Response>
readyScene(SceneRegistry& scenes, const std::string& id)
{
    const auto record = scenes.find(id);
    if (!record)
        return tl::unexpected(problem(404, "there is no scene '" + id + "'"));
    if (record->state == SceneRecord::State::preparing)
        return tl::unexpected(
            problem(503, "the scene is being prepared: try again").with("Retry-After", "1"));
    if (record->state == SceneRecord::State::failed)
        return tl::unexpected(problem(422, "the scene can't be shown: " + record->failure));
    auto scene = scenes.acquire(*record);
    if (!scene)
        return tl::unexpected(problem(scene.error()));
    return std::move(*scene);
}

} // namespace isofront::server

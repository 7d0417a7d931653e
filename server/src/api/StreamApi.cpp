#include "StreamApi.h"

#include "ReadyScene.h"

#include <utility>

namespace isofront::server {
namespace {

tl::expected<std::unique_ptr<Stream>, Response>
openStream(SceneRegistry& scenes, StreamHub& hub, const std::string& id)
{
    auto scene = readyScene(scenes, id);
    if (!scene)
        return tl::unexpected(std::move(scene.error()));
    auto stream = hub.open(std::move(*scene));
    if (!stream)
        return tl::unexpected(problem(stream.error()));
    return std::move(*stream);
}

} // namespace

Api streamApi(SceneRegistry& scenes, StreamHub& hub)
{
    Route stream;
    stream.pattern = "/v1/scenes/{id}/stream";
    stream.name = "streamScene";
    stream.summary = "The surface of a scene at the detail that a view needs, as it changes: a "
                     "WebSocket (subprotocol isofront.v1, see docs/protocol.md).";
    stream.parameters = {{"id", "of the scene", Parameter::Kind::text, true}};
    stream.answers = {
        {101, "binary messages follow"},
        {404, "there is no such scene", "application/problem+json", "Problem"},
        {422, "the scene can't be shown", "application/problem+json", "Problem"},
        {426, "this speaks WebSocket", "application/problem+json", "Problem"},
        {503, "not ready, or too many streams", "application/problem+json", "Problem"}};
    stream.open = [&scenes, &hub](const Request& request) {
        return openStream(scenes, hub, request.parameters.at("id"));
    };
    return {{std::move(stream)}};
}

} // namespace isofront::server

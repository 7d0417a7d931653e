#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace isofront::server {

/// The service's side of a conversation in whole binary messages, with nothing of the transport.
/// What it has to say is decided when there is room to say it, so nothing ever queues up.
///
/// Thread: one at a time, but for what `whenReady` was given, which is called from any.
class Stream {
public:
    Stream() = default;
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    virtual ~Stream() = default;

    /// Takes a message of the client's. One that makes no sense ends the conversation, after a last
    /// message that says why.
    virtual void receive(std::span<const std::byte> message) = 0;
    /// What is to be sent now; nothing if there is nothing, or the client has no room for it.
    virtual std::optional<std::vector<std::byte>> next() = 0;
    /// @param wake  called, from any thread, whenever `next` may have something again; it must
    ///              return at once. Replaced by an empty one before the stream goes.
    virtual void whenReady(std::function<void()> wake) = 0;
    /// Whether nothing more will come, once `next` has nothing.
    [[nodiscard]] virtual bool isOver() const = 0;
};

} // namespace isofront::server

#pragma once

#include "../Service.h"
#include "../stream/Stream.h"
#include "Asio.h"

#include <functional>
#include <memory>

namespace isofront::server {

/// A WebSocket with one client: carries messages between it and a `Stream`, which is only ever
/// asked for the next one when the last has gone.
///
/// Thread: that of the connections.
class Conversation {
public:
    using Request = http::request<http::empty_body>;

    /// @param workers  where the stream works
    static std::shared_ptr<Conversation> make(
        beast::tcp_stream&& socket,
        std::unique_ptr<Stream> stream,
        Service& service,
        net::thread_pool& workers);

    Conversation() = default;
    Conversation(const Conversation&) = delete;
    Conversation& operator=(const Conversation&) = delete;
    virtual ~Conversation() = default;

    /// Shakes hands and carries messages until either side ends.
    virtual net::awaitable<void> carry(Request handshake) = 0;
    /// Tells the client that the service goes away, and ends.
    virtual void end() = 0;
};

} // namespace isofront::server

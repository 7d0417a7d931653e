#pragma once

#include "../Service.h"
#include "Asio.h"
#include "Conversation.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>

namespace isofront::server {

/// One client's connection: reads requests, one after the other, and writes the answers.
///
/// Thread: that of the connections.
class Connection {
public:
    /// What all of them share.
    struct Shared {
        Service& service;
        net::thread_pool& workers;
        std::filesystem::path uploads;
        std::stop_token stop;
        std::set<std::shared_ptr<Connection>> connections;
        bool isEnding = false; ///< each answer is the last on its connection
    };

    Connection(tcp::socket socket, Shared& shared);
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// Until the client or the service has had enough.
    net::awaitable<void> serve();
    /// Says that there are too many.
    net::awaitable<void> turnAway();
    /// Ends after the answer that is under way.
    void end();

private:
    using Parser = http::request_parser<http::buffer_body>;
    using Clock = std::chrono::steady_clock;

    [[nodiscard]] bool isTooSlow(Clock::time_point begin, std::uint64_t bytes) const;
    net::awaitable<bool> awaitRequest();
    net::awaitable<void> exchange();
    net::awaitable<std::optional<Response>>
    readBody(Parser& parser, std::uint64_t limit, Request& request, BodyKind kind);
    net::awaitable<void>
    answer(const Request& request, const Route* route, Clock::time_point begin, Response response);
    net::awaitable<void> write(const Request& request, const Response& response);
    net::awaitable<void> converse(
        const Parser& parser,
        const Request& request,
        const Service::Admission& admission,
        Clock::time_point begin);
    net::awaitable<void> closeGently();
    void expireAfter(double seconds) { _stream.expires_after(milliseconds(seconds)); }

    beast::tcp_stream _stream;
    Shared& _shared;
    Service& _service;
    beast::flat_buffer _buffer;
    std::string _peer;
    std::shared_ptr<Conversation> _conversation;
    unsigned _version = 11;
    bool _isIdle = false;
    bool _isLast = false;   ///< nothing is read after the answer
    bool _isUnread = false; ///< there may be more of a request that wasn't wanted
};

} // namespace isofront::server

#pragma once

#include "../Service.h"

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <memory>

namespace isofront::server {

/// Speaks HTTP/1.1 and WebSocket for a service. One thread of its own waits for all connections;
/// what takes time runs on `Settings::workers` others.
///
/// Thread: one at a time.
class HttpServer {
public:
    /// Listens from now on.
    /// @param uploads  folder in which the bodies of uploads come in
    /// Errors: usage for an address that isn't one, inputOutput if it can't be listened on.
    static core::Result<std::unique_ptr<HttpServer>>
    start(Service& service, const std::filesystem::path& uploads);

    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;
    /// Ends without waiting for anybody.
    ~HttpServer();

    /// The one that was given, or found.
    [[nodiscard]] std::uint16_t port() const;
    /// Takes no more connections, lets what is under way come to its end for
    /// `Settings::drainSeconds`, and ends the rest.
    /// @return whether all came to its end in time
    bool drain();

private:
    struct Implementation;
    explicit HttpServer(std::unique_ptr<Implementation> implementation);

    std::unique_ptr<Implementation> _implementation;
};

} // namespace isofront::server

#pragma once

#include <isofront/core/Result.h>
#include <isofront/server/Settings.h>

#include <cstdint>
#include <memory>
#include <string>

namespace isofront::server {

/// The service, in this process: scenes, and all that clients ask of them.
///
/// Thread: one at a time.
class Server {
public:
    /// Opens what it keeps and listens from now on.
    /// Errors: usage for settings that make no sense together, inputOutput for folders and
    /// addresses that can't be used.
    static core::Result<std::unique_ptr<Server>> start(const Settings& settings);

    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;
    /// Ends without waiting for anybody.
    ~Server();

    [[nodiscard]] std::uint16_t port() const;
    /// Where people find it, as "http://127.0.0.1:8080/".
    [[nodiscard]] std::string address() const;
    /// Takes no more work and lets what is under way come to its end, for
    /// `Settings::drainSeconds` at most.
    /// @return whether all came to its end in time
    bool drain();

private:
    struct Parts;
    explicit Server(std::unique_ptr<Parts> parts);

    std::unique_ptr<Parts> _parts;
};

} // namespace isofront::server

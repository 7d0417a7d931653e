#pragma once

#include "Message.h"
#include "Route.h"

#include <isofront/server/Settings.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {

/// Says who may do what, from where.
///
/// Browsers carry any page's requests to any address that they can reach, a service on this
/// machine included. So requests must call the service by a name that it has (a page elsewhere
/// could let its own name lead here), and those that come from another page's script must be from
/// an origin that was allowed.
///
/// Thread: immutable.
class Guard {
public:
    Guard(const Settings& settings, Tokens tokens);

    /// Nothing if the service is called by one of its names; otherwise the refusal.
    [[nodiscard]] std::optional<Response> refuseHost(const Request& request) const;
    /// Nothing if no script of another page sent this, or one that may; otherwise the refusal.
    [[nodiscard]] std::optional<Response> refuseOrigin(const Request& request) const;
    /// Finds out who asks, from `Authorization: Bearer TOKEN`, or where browsers can't send that,
    /// for WebSockets, from a subprotocol `bearer.TOKEN`.
    /// @return the refusal, if they may not
    std::optional<Response> identify(Request& request, Scope needed) const;

    /// Answers a browser that asks what another page's script may send.
    /// Source: Fetch Standard, "CORS protocol".
    [[nodiscard]] Response preflight(const Request& request, const std::string& methods) const;
    /// Adds what lets another page's script read an answer, if it may.
    void allowReading(const Request& request, Response& response) const;

private:
    [[nodiscard]] bool isOwnName(std::string_view host) const;
    [[nodiscard]] bool isAllowed(std::string_view origin) const;

    std::vector<std::string> _names;
    std::vector<std::string> _origins;
    Tokens _tokens;
    Scopes _anonymous;
};

} // namespace isofront::server

#include "Guard.h"

#include <algorithm>

namespace isofront::server {
namespace {

/// "example.org" of "example.org:8080", "[::1]" of "[::1]:8080".
std::string_view nameIn(std::string_view host)
{
    const std::size_t bracket = host.find(']');
    if (host.starts_with('[') && bracket != std::string_view::npos)
        return host.substr(1, bracket - 1);
    return host.substr(0, std::min(host.find(':'), host.size()));
}

std::string lowered(std::string_view text)
{
    std::string lower;
    for (const char c : text)
        lower += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return lower;
}

bool isAddress(std::string_view host)
{
    return !host.empty() && (host.find(':') != std::string_view::npos ||
                             host.find_first_not_of("0123456789.") == std::string_view::npos);
}

/// A token among the subprotocols of a WebSocket's handshake.
std::string_view tokenInProtocols(std::string_view protocols)
{
    constexpr std::string_view kPrefix = "bearer.";
    for (std::size_t begin = 0; begin < protocols.size();) {
        const std::size_t end = std::min(protocols.find(',', begin), protocols.size());
        std::string_view protocol = protocols.substr(begin, end - begin);
        while (protocol.starts_with(' '))
            protocol.remove_prefix(1);
        while (protocol.ends_with(' '))
            protocol.remove_suffix(1);
        if (protocol.starts_with(kPrefix))
            return protocol.substr(kPrefix.size());
        begin = end + 1;
    }
    return {};
}

} // namespace

Guard::Guard(const Settings& settings, Tokens tokens)
    : _names{"localhost", lowered(settings.host)}, _origins(settings.origins),
      _tokens(std::move(tokens))
{
    for (const std::string& name : settings.hostNames)
        _names.push_back(lowered(name));
    for (const std::string& name : settings.anonymous)
        if (const auto scope = scopeNamed(name))
            _anonymous = _anonymous.with(*scope);
}

bool Guard::isOwnName(std::string_view host) const
{
    // an address can't be made to lead elsewhere, a name can
    const std::string name = lowered(nameIn(host));
    return isAddress(name) || std::ranges::find(_names, name) != _names.end();
}

bool Guard::isAllowed(std::string_view origin) const
{
    return std::ranges::any_of(
        _origins, [&](const std::string& one) { return one == "*" || one == origin; });
}

std::optional<Response> Guard::refuseHost(const Request& request) const
{
    const std::string_view host = request.header("host");
    if (isOwnName(host))
        return std::nullopt;
    return problem(
        421,
        "the service is not called '" + std::string(nameIn(host)) +
            "': whoever runs it can add the name to its host-names");
}

std::optional<Response> Guard::refuseOrigin(const Request& request) const
{
    const std::string_view origin = request.header("origin");
    if (origin.empty() || isAllowed(origin))
        return std::nullopt;
    const std::size_t scheme = origin.find("://");
    if (scheme != std::string_view::npos &&
        lowered(origin.substr(scheme + 3)) == lowered(request.header("host")))
        return std::nullopt; // its own pages
    return problem(
        403,
        "pages of " + std::string(origin) +
            " may not use the service: whoever runs it can add them to its cors-origins");
}

std::optional<Response> Guard::identify(Request& request, Scope needed) const
{
    constexpr std::string_view kScheme = "bearer ";
    const std::string_view authorization = request.header("authorization");
    std::string_view token = tokenInProtocols(request.header("sec-websocket-protocol"));
    if (lowered(authorization.substr(0, kScheme.size())) == kScheme)
        token = authorization.substr(kScheme.size());
    else if (!authorization.empty())
        return problem(401, "the Authorization is not of the form 'Bearer TOKEN'")
            .with("WWW-Authenticate", "Bearer");

    request.principal = {"", _anonymous};
    if (!token.empty()) {
        auto principal = _tokens.principalOf(token);
        if (!principal)
            return problem(401, "the token is not known")
                .with("WWW-Authenticate", "Bearer error=\"invalid_token\"");
        request.principal = std::move(*principal);
    }
    if (request.principal.scopes.contain(needed))
        return std::nullopt;
    const std::string scope(nameOf(needed));
    if (token.empty())
        return problem(401, "this needs a token with the scope '" + scope + "'")
            .with("WWW-Authenticate", "Bearer scope=\"" + scope + "\"");
    return problem(403, "the token lacks the scope '" + scope + "'");
}

Response Guard::preflight(const Request& request, const std::string& methods) const
{
    Response response;
    response.status = 204;
    response.headers.emplace_back("Allow", methods + ", OPTIONS");
    if (!request.header("access-control-request-method").empty() &&
        isAllowed(request.header("origin"))) {
        response.headers.emplace_back("Access-Control-Allow-Methods", methods);
        response.headers.emplace_back(
            "Access-Control-Allow-Headers", "authorization, content-type, if-none-match");
        response.headers.emplace_back("Access-Control-Max-Age", "600");
    }
    return response;
}

void Guard::allowReading(const Request& request, Response& response) const
{
    if (_origins.empty())
        return;
    const std::string_view origin = request.header("origin");
    response.headers.emplace_back("Vary", "Origin");
    if (origin.empty() || !isAllowed(origin))
        return;
    response.headers.emplace_back("Access-Control-Allow-Origin", std::string(origin));
    response.headers.emplace_back("Access-Control-Expose-Headers", "ETag, Location, Retry-After");
}

} // namespace isofront::server

#include "Service.h"

#include <algorithm>
#include <exception>
#include <new>

namespace isofront::server {
namespace {

std::multimap<std::string, std::string> queryOf(std::string_view text, bool& isValid)
{
    std::multimap<std::string, std::string> query;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('&'), text.size());
        const std::string_view pair = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (pair.empty())
            continue;
        const std::size_t equals = std::min(pair.find('='), pair.size());
        auto name = percentDecoded(pair.substr(0, equals), true);
        auto value = percentDecoded(pair.substr(std::min(equals + 1, pair.size())), true);
        isValid = isValid && name && value;
        if (name && value)
            query.emplace(std::move(*name), std::move(*value));
    }
    return query;
}

/// The path and query of a request's target. One that names the service as well, as those to
/// proxies do, says by which name it is called, whatever the field Host says. Source: R. Fielding,
/// M. Nottingham, J. Reschke, "HTTP/1.1", RFC 9112, section 3.2.
std::string_view withoutAuthority(Request& request)
{
    constexpr std::string_view kScheme = "http://";
    std::string_view target = request.target;
    std::string start(target.substr(0, kScheme.size()));
    for (char& c : start)
        c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (start != kScheme)
        return target;
    target.remove_prefix(kScheme.size());
    const std::size_t end = std::min(target.find_first_of("/?"), target.size());
    request.headers["host"] = target.substr(0, end);
    target.remove_prefix(end);
    if (!target.empty())
        return target;
    return request.method == Method::options ? "*" : "/";
}

/// Whether an answer that the client has already is the one that it would get.
bool isHeldAlready(const Request& request, const Response& response)
{
    const std::string_view held = request.header("if-none-match");
    if (held.empty() || response.status != 200 ||
        (request.method != Method::get && request.method != Method::head))
        return false;
    for (const auto& [name, value] : response.headers)
        if (name == "ETag")
            return held == "*" || held.find(value) != std::string_view::npos;
    return false;
}

} // namespace

Service::Service(const Settings& settings, Tokens tokens, Log& log, Metrics& metrics)
    : _settings(settings), _guard(settings, std::move(tokens)), _log(log), _metrics(metrics)
{
}

std::variant<Service::Admission, Response> Service::admit(Request& request) const
{
    const std::string_view target = withoutAuthority(request);
    const std::size_t mark = std::min(target.find('?'), target.size());
    bool isValid = true;
    request.path = target.substr(0, mark);
    request.query = queryOf(target.substr(std::min(mark + 1, target.size())), isValid);
    const bool isOfAll = request.method == Method::options && target == "*";
    const auto segments = segmentsOf(request.path);
    if (!isValid || (!segments && !isOfAll))
        return problem(400, "the path or its query is not a valid one");
    if (auto refusal = _guard.refuseHost(request))
        return std::move(*refusal);
    if (isOfAll)
        return _guard.preflight(request, _routes.methods());

    RouteTable::Match match = _routes.find(request.method, *segments);
    if (match.route == nullptr) {
        if (match.allowed.empty())
            return problem(404, "there is nothing at " + request.path);
        if (request.method == Method::options)
            return _guard.preflight(request, match.allowed);
        return problem(405, request.path + " takes " + match.allowed).with("Allow", match.allowed);
    }
    request.parameters = std::move(match.parameters);
    const Route& route = *match.route;
    if (route.open || route.body != BodyKind::none || route.method == Method::remove)
        if (auto refusal = _guard.refuseOrigin(request))
            return std::move(*refusal);
    if (auto refusal = _guard.identify(request, route.scope))
        return std::move(*refusal);
    if (const auto fault = faultInQuery(route, request))
        return problem(400, *fault);
    if (_isDraining && route.scope != Scope::none)
        return problem(503, "the service is ending").with("Retry-After", "5");
    Admission admission{&route, 0};
    if (route.body == BodyKind::text)
        admission.bodyLimit = _settings.bodyBytes;
    else if (route.body == BodyKind::file)
        admission.bodyLimit = _settings.uploadBytes;
    return admission;
}

std::optional<Response> Service::refuseForLoad() const
{
    if (_metrics.value(Metrics::Level::requests) < _settings.requests)
        return std::nullopt;
    _metrics.count(Metrics::Count::refused);
    return problem(503, "too many requests at once: try again").with("Retry-After", "1");
}

std::optional<Response> Service::refuseStream() const
{
    if (_metrics.value(Metrics::Level::streams) < _settings.streams)
        return std::nullopt;
    _metrics.count(Metrics::Count::refused);
    return problem(503, "as many clients are connected as may be: try again")
        .with("Retry-After", "5");
}

std::optional<Response> Service::expect(Request& request, const Admission& admission)
{
    if (!admission.route->expect)
        return std::nullopt;
    try {
        auto room = admission.route->expect(request);
        if (!room)
            return std::move(room.error());
        request.room = std::move(*room);
        return std::nullopt;
    } catch (const std::exception& error) {
        _log.write(
            LogLevel::error, "request failed", {{"path", request.path}, {"why", error.what()}});
        return problem(500, "the service failed at that; its log says more");
    }
}

Response Service::answer(const Request& request, const Admission& admission)
{
    try {
        return admission.route->handle(request);
    } catch (const std::bad_alloc&) {
        _log.write(LogLevel::error, "out of memory", {{"path", request.path}});
        return problem(503, "the service has not enough memory for that").with("Retry-After", "10");
    } catch (const std::exception& error) {
        _log.write(
            LogLevel::error, "request failed", {{"path", request.path}, {"why", error.what()}});
        return problem(500, "the service failed at that; its log says more");
    }
}

tl::expected<std::unique_ptr<Stream>, Response>
Service::open(const Request& request, const Admission& admission)
{
    try {
        return admission.route->open(request);
    } catch (const std::exception& error) {
        _log.write(
            LogLevel::error, "stream failed", {{"path", request.path}, {"why", error.what()}});
        return tl::unexpected(problem(500, "the service failed at that; its log says more"));
    }
}

void Service::finish(
    const Request& request,
    const Route* route,
    std::chrono::steady_clock::time_point begin,
    Response& response)
{
    _guard.allowReading(request, response);
    response.headers.emplace_back("X-Content-Type-Options", "nosniff");
    if (isHeldAlready(request, response)) {
        response.status = 304;
        response.body.clear();
        response.sharedBody.reset();
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const std::size_t bytes = response.content().size();
    _metrics.answered(
        nameOf(request.method),
        route != nullptr ? route->pattern : "none",
        response.status,
        seconds);
    _metrics.count(Metrics::Count::bytesSent, static_cast<double>(bytes));
    const bool isRoutine = route != nullptr && route->scope == Scope::none;
    _log.write(
        response.status >= 500 ? LogLevel::warning
        : isRoutine            ? LogLevel::debug
                               : LogLevel::info,
        "request",
        {{"method", nameOf(request.method)},
         {"path", request.path.empty() ? request.target : request.path},
         {"status", response.status},
         {"bytes", bytes},
         {"milliseconds", seconds * 1e3},
         {"peer", request.peer},
         {"name", request.principal.name}});
}

} // namespace isofront::server

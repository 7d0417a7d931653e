#pragma once

#include "Log.h"
#include "Metrics.h"
#include "api/Guard.h"
#include "api/Message.h"
#include "api/Route.h"

#include <isofront/server/Settings.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>

namespace isofront::server {

/// All that the service does, without sockets: takes requests and gives answers. A transport asks
/// twice: with the header alone (`admit`), so that no body is read in vain, and with all of it.
///
/// Thread: any, once all APIs are added.
class Service {
public:
    Service(const Settings& settings, Tokens tokens, Log& log, Metrics& metrics);
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    /// Before the first request only.
    void add(Api api) { _routes.add(std::move(api)); }

    /// What a request asks for, and that it may.
    struct Admission {
        const Route* route = nullptr;
        std::uint64_t bodyLimit = 0; ///< [bytes]
    };
    /// @param request  with method, target, headers and peer; gets its path, parameters, query and
    ///                 principal
    /// @return the answer, if nothing has to be asked of anybody
    std::variant<Admission, Response> admit(Request& request) const;
    /// The answer if `Settings::requests` are under way already. Whoever goes on counts itself as
    /// one
    /// (`Metrics::Level::requests`) until it is answered.
    [[nodiscard]] std::optional<Response> refuseForLoad() const;
    /// The same of `Settings::streams`; whoever goes on counts itself as one of those.
    [[nodiscard]] std::optional<Response> refuseStream() const;
    /// Asks whether the body is wanted, and makes room for it in the request.
    /// @return the answer, if it isn't
    std::optional<Response> expect(Request& request, const Admission& admission);
    /// Does what was admitted. Never throws: what goes wrong inside is logged and becomes a 500.
    Response answer(const Request& request, const Admission& admission);
    /// Opens the conversation that was admitted.
    tl::expected<std::unique_ptr<Stream>, Response>
    open(const Request& request, const Admission& admission);

    /// What every answer has: to be called once on each, those of `admit` and of the transport
    /// included. Also counts it and writes it to the log.
    /// @param route  what it was asked of; nullptr if that isn't known
    void finish(
        const Request& request,
        const Route* route,
        std::chrono::steady_clock::time_point begin,
        Response& response);

    /// From now on clients are told to go elsewhere, and health is told as such.
    void beginDraining() { _isDraining = true; }
    [[nodiscard]] bool isDraining() const { return _isDraining; }

    [[nodiscard]] const Settings& settings() const { return _settings; }
    [[nodiscard]] const RouteTable& routes() const { return _routes; }
    [[nodiscard]] Log& log() { return _log; }
    [[nodiscard]] Metrics& metrics() { return _metrics; }

private:
    Settings _settings;
    Guard _guard;
    Log& _log;
    Metrics& _metrics;
    RouteTable _routes;
    std::atomic<bool> _isDraining = false;
};

} // namespace isofront::server
